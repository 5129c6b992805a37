//! What every pass knows: the uniforms of the frame and of a view.

use crate::layout::gpu_struct;
use crate::phenomena::moon::MoonUniform;
use crate::phenomena::sun::{BendingUniform, DiscUniform, ShadowUniform};

/// Most lights of a frame: suns, and moons once they are drawn.
pub const MOST_LIGHTS: usize = 4;

gpu_struct! {
    /// One for each frame; the fields are explained in `frame.wgsl`.
    pub struct FrameUniform {
        /// Row R of colour from radiance.
        pub rec709_from_four_r: [f32; 4],
        /// Row G.
        pub rec709_from_four_g: [f32; 4],
        /// Row B.
        pub rec709_from_four_b: [f32; 4],
        /// Limb-darkening coefficients at the four wavelengths.
        pub limb_darkening: [[f32; 4]; 6],
        /// Factor on luminance; 0: automatic.
        pub exposure: f32,
        /// Cells along a ray.
        pub steps: u32,
        /// Index of the tone mapper.
        pub tonemap: u32,
        /// 1: display-encoded target, 2: sRGB target.
        pub encoding: u32,
        /// Steps of the target that dithering hides; 0: off.
        pub dither_levels: f32,
        /// Largest finite value of the target.
        pub largest: f32,
        /// Factor on automatic exposure.
        pub compensation: f32,
        /// Lights in use.
        pub light_count: u32,
        /// How the air bends what is seen.
        pub bending: BendingUniform,
    }
}

gpu_struct! {
    /// A sun as a view sees it.
    pub struct LightUniform {
        /// Direction without refraction in view space.
        pub direction: [f32; 3],
        /// Apparent radius of the disc, rad.
        pub radius: f32,
        /// Refracted direction of the disc in view space.
        pub disc_direction: [f32; 3],
        /// Whether the disc is drawn.
        pub disc_visible: u32,
        /// Irradiance relative to the preset's star at 1 au.
        pub irradiance: [f32; 4],
        /// Heading on the view's horizon in view space.
        pub heading: [f32; 3],
        /// Cosine of its zenith angle.
        pub mu_s: f32,
    }
}

gpu_struct! {
    /// One for each view; the fields are explained in `frame.wgsl`.
    pub struct ViewUniform {
        /// Ray through the middle of the picture.
        pub ray_origin: [f32; 3],
        /// 0 linear, 1 fisheye, 2 equirectangular.
        pub projection: u32,
        /// Change of the ray with ndc.x.
        pub ray_x: [f32; 3],
        /// Half angle of the fisheye, rad.
        pub half_angle: f32,
        /// Change of the ray with ndc.y.
        pub ray_y: [f32; 3],
        /// Width over height.
        pub aspect: f32,
        /// Zenith in view space.
        pub up: [f32; 3],
        /// Altitude of the camera, m.
        pub altitude_m: f32,
        /// Camera-relative east for equirectangular pictures.
        pub east: [f32; 3],
        /// Layer of the tables per station.
        pub station: u32,
        /// The camera's azimuth on the horizon.
        pub north: [f32; 3],
        /// Whether the sky comes from the sky-view table.
        pub sky_view: u32,
        /// Part of the picture that is drawn.
        pub tile: [f32; 4],
        /// First pixel of that part.
        pub pixel: [f32; 2],
        /// Elevation of the horizon, rad.
        pub horizon: f32,
        /// Cosine of the horizon's zenith angle.
        pub horizon_mu: f32,
        /// The lights.
        pub lights: [LightUniform; MOST_LIGHTS],
        /// The first light's disc.
        pub disc: DiscUniform,
        /// The shadow of what stands before it.
        pub shadow: ShadowUniform,
        /// Occluder's radius of the eclipse table.
        pub table_b: f32,
        /// Whose air a station is for.
        pub body: u32,
        /// Layer of the night's grid.
        pub night_layer: u32,
        /// What its 1 is, cd/m².
        pub night_unit: f32,
        /// Bins of points along the sides of the picture.
        pub point_bins: [u32; 2],
        /// Where the view's begin.
        pub point_bins_first: u32,
        /// Fills up.
        pub padding: u32,
        /// Glare of points.
        pub glare: [f32; 4],
        /// The Moon.
        pub moon: MoonUniform,
        /// Rows of ICRS from view space; w: level of the star map, its side in texels.
        pub icrs_from_view: [[f32; 4]; 3],
        /// Rows of the ecliptic (x to the Sun) from view space.
        pub ecliptic_from_view: [[f32; 4]; 3],
        /// Rectangles of cells, see `tiles.rs`.
        pub rectangles: [[[u32; 4]; 12]; 6],
    }
}
