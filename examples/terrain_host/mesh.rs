//! The planet around the camera as one mesh: rings whose distance grows with their radius, out to behind the horizon.

use std::f64::consts::TAU;

use himmel::glam::{DMat3, DVec3};

use crate::relief::Relief;

/// Cells of the finest map have 200 m; closer rings would show nothing new.
const SMALLEST_STEP_M: f64 = 60.0;
/// No relief of either planet is higher: so far below the horizon it can still look over.
const HIGHEST_M: f64 = 24e3;

/// Layout of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// East, north, up of the camera, m: small numbers where the eye is close, so 32 bits do.
    position: [f32; 3],
    normal: [f32; 3],
    /// Above the datum.
    height_m: f32,
}

/// Where the camera is over the planet.
pub struct Standpoint {
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    /// Of the datum.
    pub radius_m: f64,
    /// Of the camera above the datum.
    pub altitude_m: f64,
}

impl Standpoint {
    /// Axes of the planet (z: north pole, x: meridian 0) from east, north, up.
    fn planet_from_enu(&self) -> DMat3 {
        let (sin_lat, cos_lat) = self.latitude_deg.to_radians().sin_cos();
        let (sin_lon, cos_lon) = self.longitude_deg.to_radians().sin_cos();
        DMat3::from_cols(
            DVec3::new(-sin_lon, cos_lon, 0.0),
            DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
            DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
        )
    }

    /// Height of the relief below the camera, m.
    pub fn ground_m(&self, relief: &Relief) -> f64 {
        relief.height_m(self.planet_from_enu().z_axis)
    }

    /// How far the horizon of the datum lies below the horizontal, rad; it is as far along the ground as seen from the centre.
    pub fn dip_rad(&self) -> f64 {
        (self.radius_m / (self.radius_m + self.altitude_m)).acos()
    }
}

/// A mesh in the camera's east-north-up.
pub struct Mesh {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
    /// Of the relief above its datum, m.
    pub lowest_m: f64,
}

impl Mesh {
    /// `sectors` to the circle; rings are twice as far apart as its spokes. `lift_m` raises all of the relief.
    pub fn around(at: &Standpoint, relief: &Relief, sectors: usize, lift_m: f64) -> Self {
        let reach_m = at.radius_m * (at.dip_rad() + (at.radius_m / (at.radius_m + HIGHEST_M)).acos());
        let above_m = (at.altitude_m - lift_m - at.ground_m(relief)).max(0.0);
        let spread = TAU / sectors as f64;
        let mut radii_m = vec![0.0];
        let mut radius_m = 0.0;
        while radius_m < reach_m {
            // From high above, the foot point is as far away as the altitude.
            radius_m += SMALLEST_STEP_M.max(2.0 * spread * radius_m).max(spread * above_m);
            radii_m.push(radius_m);
        }

        let planet_from_enu = at.planet_from_enu();
        let mut points = Vec::with_capacity(radii_m.len() * sectors);
        let mut lowest_m = f64::INFINITY;
        for radius_m in &radii_m {
            let (sin_arc, cos_arc) = (radius_m / at.radius_m).sin_cos();
            for sector in 0..sectors {
                let (sin_azimuth, cos_azimuth) = (spread * sector as f64).sin_cos();
                let up = DVec3::new(sin_arc * sin_azimuth, sin_arc * cos_azimuth, cos_arc);
                let height_m = relief.height_m(planet_from_enu * up);
                lowest_m = lowest_m.min(height_m);
                let position = up * (at.radius_m + height_m + lift_m) - DVec3::Z * (at.radius_m + at.altitude_m);
                points.push((position, up, height_m));
            }
        }

        let position = |ring: usize, sector: usize| points[ring * sectors + sector % sectors].0;
        let vertices = points.iter().enumerate().map(|(index, &(here, up, height_m))| {
            let (ring, sector) = (index / sectors, index % sectors);
            let outwards =
                position((ring + 1).min(radii_m.len() - 1), sector) - position(ring.saturating_sub(1), sector);
            let clockwise = position(ring, sector + 1) - position(ring, sector + sectors - 1);
            // All of the innermost ring is one point.
            let normal = clockwise.cross(outwards).try_normalize().unwrap_or(up);
            Vertex {
                position: here.as_vec3().to_array(),
                normal: normal.as_vec3().to_array(),
                height_m: height_m as f32,
            }
        });
        let vertices = vertices.collect();

        let mut indices = Vec::with_capacity(6 * (radii_m.len() - 1) * sectors);
        for ring in 0..radii_m.len() - 1 {
            for sector in 0..sectors {
                let corner = |ring: usize, sector: usize| (ring * sectors + sector % sectors) as u32;
                let (inner, inner_next) = (corner(ring, sector), corner(ring, sector + 1));
                let (outer, outer_next) = (corner(ring + 1, sector), corner(ring + 1, sector + 1));
                // Counter-clockwise from above.
                indices.extend([inner, outer_next, outer, inner, inner_next, outer_next]);
            }
        }
        Self { vertices, indices, lowest_m }
    }
}
