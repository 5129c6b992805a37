// What every pass knows: one uniform for the frame, one for each view.
// Field order and sizes are mirrored in frame/mod.rs; a test compares the offsets.

struct FrameUniform {
    // Rows R, G, B: linear Rec. 709 in cd/m² from radiance per unit irradiance of the Sun.
    rec709_from_four_r: vec4f,
    rec709_from_four_g: vec4f,
    rec709_from_four_b: vec4f,
    ground_albedo: vec4f,
    // Coefficients of the Sun's limb darkening: Σ c_k µ^k relative to the mean.
    limb_darkening: array<vec4f, 6>,
    bottom_radius_m: f32,
    top_altitude_m: f32,
    // Irradiance of the Sun relative to 1 au.
    sun_irradiance: f32,
    // Multiplies luminance; 0: take it from the exposure texture.
    exposure: f32,
    steps: u32,
    tonemap: u32,
    // 1: the target wants display-encoded values; 2: it encodes by itself (an sRGB format).
    encoding: u32,
    // Levels of the target that dithering hides; 0: no dithering.
    dither_levels: f32,
    // Largest finite value of the target.
    largest: f32,
    // Added to automatic exposure, as a factor.
    compensation: f32,
    padding: vec2f,
}

struct ViewUniform {
    // Ray directions in view space: origin + x · ndc.x + y · ndc.y (perspective and orthographic).
    ray_origin: vec3f,
    projection: u32,
    ray_x: vec3f,
    // Half the angle that a fisheye spans from bottom to top, radians.
    half_angle: f32,
    ray_y: vec3f,
    // Width over height of the whole picture (fisheye).
    aspect: f32,
    // The zenith in view space.
    up: vec3f,
    altitude_m: f32,
    // Towards the Sun's disc, refracted, in view space.
    sun_disc: vec3f,
    sun_radius: f32,
    // Towards the Sun without refraction, in view space.
    sun: vec3f,
    sun_disc_visible: u32,
    // For equirectangular pictures: view space from east, north (up is above).
    east: vec3f,
    padding_0: f32,
    north: vec3f,
    padding_1: f32,
    // Part of the picture that is drawn: ndc of the picture = xy + zw · ndc of the target.
    tile: vec4f,
    // First pixel of that part.
    pixel: vec2f,
    padding_2: vec2f,
}

@group(0) @binding(0) var<uniform> frame: FrameUniform;
@group(0) @binding(1) var extinction_table: texture_2d<f32>;
@group(0) @binding(2) var scattering_table: texture_2d<f32>;
@group(0) @binding(3) var optical_depth_table: texture_2d<f32>;
@group(0) @binding(4) var irradiance_table: texture_2d<f32>;
@group(0) @binding(5) var exposure_texture: texture_2d<f32>;
@group(1) @binding(0) var<uniform> view: ViewUniform;
