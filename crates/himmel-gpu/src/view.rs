//! Where a camera stands and what it sees.

use glam::{DMat4, DVec3, DVec4};

use crate::error::GpuError;

/// How directions become pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// The host's own projection: clip-from-view, as wgpu wants it (x right, y up, z into 0..=1). Perspective of any
    /// kind (infinite, reversed, off-axis) or orthographic. The camera looks along −z.
    Matrix(DMat4),
    /// Equidistant fisheye: the angle from the axis grows evenly with the distance from the centre. The value is the
    /// angle from bottom to top in radians, up to 2π.
    Fisheye(f64),
    /// The whole sphere: 360° of azimuth around the camera's, 180° of altitude.
    Equirectangular,
}

/// One camera of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// How directions become pixels.
    pub projection: Projection,
    /// Rotation and position of the camera: metres east, north and up of the observer. The camera looks along its −z
    /// with +y up. Hosts whose world is y-up use [`View::enu_from_y_up`] on the left.
    pub enu_from_view: DMat4,
    /// Width over height of the picture.
    pub aspect: f64,
    /// Rows of the whole picture in pixels, by which points of light are sized and the Milky Way is smoothed; 0: unknown,
    /// which costs some time and is right for pictures of at least 360 rows (of about 1,080 for the Milky Way).
    pub rows_px: u32,
    /// The part of the picture that is drawn: left, bottom, width, height in 0..=1. For tiles of large pictures.
    pub part: [f64; 4],
    /// Pixel coordinates of that part's first pixel, for dithering without seams.
    pub first_pixel: [u32; 2],
}

impl View {
    /// Rows of the whole picture; where nobody told, so few that nothing that is sized by them is cut off.
    pub(crate) fn rows_or_fewest(&self) -> u32 {
        if self.rows_px == 0 { 360 } else { self.rows_px }
    }

    /// A camera at the observer that looks along an azimuth (from north through east) and altitude with a vertical
    /// field of view, all in radians.
    pub fn looking(azimuth_rad: f64, altitude_rad: f64, fov_rad: f64, aspect: f64) -> Self {
        let clip_from_view = DMat4::perspective_infinite_reverse_rh(fov_rad, aspect, 1.0);
        Self::with_projection(azimuth_rad, altitude_rad, Projection::Matrix(clip_from_view), aspect)
    }

    /// A camera at the observer with any projection.
    pub fn with_projection(azimuth_rad: f64, altitude_rad: f64, projection: Projection, aspect: f64) -> Self {
        let (sin_a, cos_a) = azimuth_rad.sin_cos();
        let (sin_h, cos_h) = altitude_rad.sin_cos();
        let right = DVec3::new(cos_a, -sin_a, 0.0);
        let forward = DVec3::new(sin_a * cos_h, cos_a * cos_h, sin_h);
        let up = right.cross(forward);
        let enu_from_view =
            DMat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), DVec4::new(0.0, 0.0, 0.0, 1.0));
        Self { projection, enu_from_view, aspect, rows_px: 0, part: [0.0, 0.0, 1.0, 1.0], first_pixel: [0, 0] }
    }

    /// A host's camera: its projection as in [`Projection::Matrix`], and where it stands and looks as in
    /// [`View::enu_from_view`].
    pub fn from_camera(clip_from_view: DMat4, enu_from_view: DMat4) -> Self {
        // The aspect is in the matrix already; only fisheyes ask for it.
        Self {
            projection: Projection::Matrix(clip_from_view),
            enu_from_view,
            aspect: 1.0,
            rows_px: 0,
            part: [0.0, 0.0, 1.0, 1.0],
            first_pixel: [0, 0],
        }
    }

    /// East-north-up from a right-handed world with x east, y up and z south, as most engines have it.
    pub fn enu_from_y_up() -> DMat4 {
        DMat4::from_cols(DVec4::X, DVec4::Z, -DVec4::Y, DVec4::W)
    }

    /// Rays of a linear projection: middle, and change with ndc.x and ndc.y, in view space.
    pub(crate) fn rays(&self) -> Result<[DVec3; 3], GpuError> {
        let Projection::Matrix(clip_from_view) = self.projection else {
            return Ok([-DVec3::Z, DVec3::ZERO, DVec3::ZERO]);
        };
        let inverse = clip_from_view.inverse();
        if !inverse.is_finite() {
            return Err(GpuError::View("its projection matrix has no inverse".into()));
        }
        // A point of the picture is the line between two depths. Homogeneous difference, so that one may be infinite.
        let through = |x: f64, y: f64| {
            let (a, b) = (inverse * DVec4::new(x, y, 0.25, 1.0), inverse * DVec4::new(x, y, 0.75, 1.0));
            let ray = b.truncate() * a.w - a.truncate() * b.w;
            // Either depth may be the nearer one: the camera looks along −z.
            if ray.z > 0.0 { -ray } else { ray }
        };
        let (middle, right, top) = (through(0.0, 0.0), through(1.0, 0.0), through(0.0, 1.0));
        let scale = middle.length();
        if !(scale.is_finite() && scale > 0.0) {
            return Err(GpuError::View("its projection matrix has no inverse".into()));
        }
        Ok([middle / scale, (right - middle) / scale, (top - middle) / scale])
    }

    /// The look direction of a point of the picture (ndc, y up), east-north-up; `None` outside a fisheye. The f64 twin
    /// of `look_direction` in `sky.wgsl`.
    pub fn direction(&self, ndc: [f64; 2]) -> Option<DVec3> {
        self.along(&self.rays().ok()?, ndc)
    }

    /// The same by [`rays`](Self::rays) in hand: for many places.
    pub(crate) fn along(&self, [middle, x, y]: &[DVec3; 3], ndc: [f64; 2]) -> Option<DVec3> {
        let look = match self.projection {
            Projection::Matrix(_) => (*middle + *x * ndc[0] + *y * ndc[1]).normalize(),
            Projection::Fisheye(span) => {
                let (x, y) = (ndc[0] * self.aspect, ndc[1]);
                let radius = x.hypot(y);
                let angle = radius * 0.5 * span;
                if angle > (0.5 * span).min(std::f64::consts::PI) {
                    return None;
                }
                let scale = angle.sin() / radius.max(1e-9);
                DVec3::new(x * scale, y * scale, -angle.cos())
            }
            Projection::Equirectangular => {
                let forward = self.enu_from_view.transform_vector3(-DVec3::Z);
                let azimuth = forward.x.atan2(forward.y) + ndc[0] * std::f64::consts::PI;
                let altitude = ndc[1] * std::f64::consts::FRAC_PI_2;
                return Some(DVec3::new(
                    azimuth.sin() * altitude.cos(),
                    azimuth.cos() * altitude.cos(),
                    altitude.sin(),
                ));
            }
        };
        Some(self.enu_from_view.transform_vector3(look))
    }

    /// Angle of a pixel in the middle of a picture of so many rows of this view, degrees.
    pub fn degrees_per_pixel(&self, height_px: u32) -> f64 {
        let half = 1.0 / f64::from(height_px.max(1));
        let [below, above] = [-half, half].map(|y| self.direction([0.0, y]).unwrap_or(DVec3::Z));
        below.angle_between(above).to_degrees()
    }

    pub(crate) fn check(&self) -> Result<(), GpuError> {
        if !self.enu_from_view.is_finite() {
            return Err(GpuError::View("its enu_from_view matrix is not finite".into()));
        }
        let rotation = glam::DMat3::from_mat4(self.enu_from_view);
        let skew = rotation.transpose() * rotation - glam::DMat3::IDENTITY;
        if skew.to_cols_array().iter().any(|value| value.abs() > 1e-3) {
            return Err(GpuError::View("its enu_from_view matrix must rotate and shift only, without scale".into()));
        }
        if !(self.aspect.is_finite() && self.aspect > 0.0) {
            return Err(GpuError::View(format!("its aspect must be positive, got {}", self.aspect)));
        }
        if let Projection::Fisheye(span) = self.projection
            && !(span > 0.0 && span <= 2.0 * std::f64::consts::PI)
        {
            return Err(GpuError::View(format!(
                "a fisheye spans more than 0° and at most 360°, got {}°",
                span.to_degrees()
            )));
        }
        if self.part.iter().any(|value| !value.is_finite()) || self.part[2] <= 0.0 || self.part[3] <= 0.0 {
            return Err(GpuError::View("the part that is drawn must be finite and not empty".into()));
        }
        self.rays().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looking_north_has_east_on_the_right() {
        let view = View::looking(0.0, 0.0, 1.0, 2.0);
        assert!((view.direction([0.0, 0.0]).unwrap() - DVec3::Y).length() < 1e-12);
        assert!(view.direction([0.5, 0.0]).unwrap().x > 0.1);
        assert!(view.direction([0.0, 0.5]).unwrap().z > 0.1);
        let up = view.direction([0.0, 1.0]).unwrap();
        assert!((up.angle_between(DVec3::Y) - 0.5).abs() < 1e-12, "half the field of view");
    }

    #[test]
    fn a_pixel_has_an_angle() {
        let fisheye = View::with_projection(0.0, 1.0, Projection::Fisheye(2.0), 1.0);
        assert!((fisheye.degrees_per_pixel(1000) - 2f64.to_degrees() / 1000.0).abs() < 1e-9);
        let looking = View::looking(1.0, 0.3, 1.0, 1.5).degrees_per_pixel(1000);
        assert!((looking - (2.0 * 0.5f64.tan() / 1000.0).to_degrees()).abs() < 1e-6);
        let sphere = View::with_projection(0.0, 0.0, Projection::Equirectangular, 2.0);
        assert!((sphere.degrees_per_pixel(900) - 0.2).abs() < 1e-9);
    }

    #[test]
    fn every_perspective_gives_the_same_rays() {
        let (fov, aspect) = (0.9, 1.5);
        let reference = View::looking(1.0, 0.3, fov, aspect);
        for projection in [
            DMat4::perspective_infinite_rh(fov, aspect, 0.1),
            DMat4::perspective_rh(fov, aspect, 0.1, 1e4),
            DMat4::perspective_rh(fov, aspect, 1e4, 0.1),
        ] {
            let view = View { projection: Projection::Matrix(projection), ..reference };
            for ndc in [[0.0, 0.0], [1.0, -1.0], [-0.3, 0.8]] {
                let (a, b) = (view.direction(ndc).unwrap(), reference.direction(ndc).unwrap());
                assert!((a - b).length() < 1e-9, "{projection} {ndc:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_hosts_camera_is_the_same_view() {
        let reference = View::looking(1.0, 0.3, 0.9, 1.5);
        let Projection::Matrix(clip_from_view) = reference.projection else { unreachable!() };
        let view = View::from_camera(clip_from_view, reference.enu_from_view);
        for ndc in [[0.0, 0.0], [1.0, -1.0], [-0.3, 0.8]] {
            assert_eq!(view.direction(ndc), reference.direction(ndc));
        }
    }

    #[test]
    fn an_engine_with_y_up_sees_north_along_minus_z() {
        let enu = View::enu_from_y_up().transform_vector3(-DVec3::Z);
        assert!((enu - DVec3::Y).length() < 1e-12);
        assert!((View::enu_from_y_up().determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn views_without_meaning_are_refused() {
        let good = View::looking(0.0, 0.0, 1.0, 1.0);
        for bad in [
            View { projection: Projection::Matrix(DMat4::ZERO), ..good },
            View { projection: Projection::Fisheye(f64::NAN), ..good },
            View { enu_from_view: DMat4::from_scale(DVec3::splat(2.0)), ..good },
            View { enu_from_view: DMat4::NAN, ..good },
            View { aspect: 0.0, ..good },
            View { part: [0.0, 0.0, 0.0, 1.0], ..good },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
        assert!(good.check().is_ok());
    }
}
