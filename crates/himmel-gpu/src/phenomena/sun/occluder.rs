//! A body before the Sun, and the structs by which shaders know of it and of the bent sky.

use glam::{DMat3, DVec3};
use himmel_air::eclipse::Shadow;
use himmel_air::refraction::Bending;

use crate::layout::gpu_struct;

/// A body that may stand before the Sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occluder {
    /// Unit vector to its centre without refraction, east-north-up.
    pub direction: DVec3,
    /// Unit vector to its centre as the air shows it, east-north-up.
    pub disc_direction: DVec3,
    /// From the observer, m.
    pub distance_m: f64,
    /// Its radius, m.
    pub radius_m: f64,
    /// Its apparent radius, rad.
    pub angular_radius_rad: f64,
}

impl Occluder {
    /// The cone of its shadow, vectors east-north-up from the observer.
    ///
    /// `sun`: unit vector without refraction.
    pub fn shadow(&self, sun: DVec3, sun_radius_rad: f64, sun_distance_m: f64) -> Shadow {
        Shadow::new(self.direction * self.distance_m, self.radius_m, sun, sun_radius_rad, sun_distance_m)
    }
}

gpu_struct! {
    /// The shadow's cone; the fields are explained in `eclipse.wgsl`.
    pub struct ShadowUniform {
        /// What of the vector to the occluder is across the Sun's direction, m.
        pub across_m: [f32; 3],
        /// What of it is along the Sun's direction, m.
        pub along_m: f32,
        /// Unit vector to the Sun.
        pub sun: [f32; 3],
        /// Radius of the occluder, m.
        pub radius_m: f32,
        /// Apparent radius of the Sun, rad.
        pub sun_radius: f32,
        /// 1 − distance of the occluder over the Sun's.
        pub parallax: f32,
        /// Fills up.
        pub padding: [f32; 2],
    }
}

gpu_struct! {
    /// How the air lifts what is seen; the fields are explained in `bending.wgsl`.
    pub struct BendingUniform {
        /// Deviation at the nodes, rad.
        pub deviation: [[f32; 4]; 8],
        /// Deviation at each wavelength over that of the table.
        pub ratio: [f32; 4],
        /// The lowest elevation that clears the ground, rad.
        pub lowest: f32,
        /// How fast the nodes spread from there, rad.
        pub width: f32,
        /// asinh((π/2 − lowest)/width).
        pub span: f32,
        /// Fills up.
        pub padding: f32,
    }
}

gpu_struct! {
    /// A disc with what stands before it; the fields are explained in `disc.wgsl`.
    pub struct DiscUniform {
        /// Unit vector to its centre, without refraction.
        pub centre: [f32; 3],
        /// Apparent radius, rad.
        pub radius: f32,
        /// Unit vector to the zenith.
        pub up: [f32; 3],
        /// Apparent radius of the occluder, rad; 0: there is none.
        pub occluder_radius: f32,
        /// From the occluder's centre to the disc's.
        pub from_occluder: [f32; 3],
        /// 1: the corona is drawn.
        pub corona: f32,
    }
}

fn f32s(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

impl ShadowUniform {
    /// In the frame of a view. `view_from_enu`: its rotation.
    pub fn new(shadow: &Shadow, view_from_enu: DMat3) -> Self {
        Self {
            across_m: f32s(view_from_enu * shadow.across_m),
            along_m: shadow.along_m as f32,
            sun: f32s(view_from_enu * shadow.sun),
            radius_m: shadow.radius_m as f32,
            sun_radius: shadow.sun_radius_rad as f32,
            parallax: shadow.parallax as f32,
            padding: [0.0; 2],
        }
    }
}

impl BendingUniform {
    /// The same numbers in f32.
    pub fn new(bending: &Bending) -> Self {
        Self {
            deviation: std::array::from_fn(|i| std::array::from_fn(|j| bending.deviation_rad[4 * i + j] as f32)),
            ratio: bending.ratio.map(|ratio| ratio as f32),
            lowest: bending.lowest_rad as f32,
            width: bending.width_rad as f32,
            span: bending.span as f32,
            padding: 0.0,
        }
    }
}

impl DiscUniform {
    /// Of a disc in the frame of a view. `centre`: unit vector east-north-up, without refraction.
    pub fn new(centre: DVec3, radius_rad: f64, occluder: Option<&Occluder>, view_from_enu: DMat3) -> Self {
        // The difference of two nearly equal unit vectors, while it is still f64.
        let from_occluder = occluder.map_or(DVec3::ZERO, |occluder| centre - occluder.direction);
        Self {
            centre: f32s(view_from_enu * centre),
            radius: radius_rad as f32,
            up: f32s(view_from_enu * DVec3::Z),
            occluder_radius: occluder.map_or(0.0, |occluder| occluder.angular_radius_rad as f32),
            from_occluder: f32s(view_from_enu * from_occluder),
            corona: f32::from(u8::from(occluder.is_some())),
        }
    }
}
