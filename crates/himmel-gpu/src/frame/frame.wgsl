// What every pass knows: one uniform for the frame, one for each view.
// Field order and sizes are mirrored in frame/mod.rs; a test compares the offsets.

//#include "phenomena/sun/disc.wgsl"
//#include "phenomena/moon/uniform.wgsl"

// Lights that a frame may have: suns, and moons once they are drawn.
const MOST_LIGHTS: u32 = 4u;

struct FrameUniform {
    // Rows R, G, B: linear Rec. 709 in cd/m² from radiance per unit irradiance of the Sun.
    rec709_from_four_r: vec4f,
    rec709_from_four_g: vec4f,
    rec709_from_four_b: vec4f,
    // Coefficients of the Sun's limb darkening: Σ c_k µ^k relative to the mean.
    limb_darkening: array<vec4f, 6>,
    // Multiplies luminance; 0: take it from the exposure texture.
    exposure: f32,
    // Cells along a ray.
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
    light_count: u32,
    // How the air bends what is seen.
    bending: BendingUniform,
}

// A sun as a view sees it.
struct LightUniform {
    // Towards it without refraction, in view space.
    direction: vec3f,
    // Apparent radius of its disc, rad.
    radius: f32,
    // Towards its disc, refracted, in view space.
    disc_direction: vec3f,
    disc_visible: u32,
    // Irradiance above the air relative to the preset's star at 1 au.
    irradiance: vec4f,
    // Its heading on the view's horizon, a unit vector in view space.
    heading: vec3f,
    // Cosine of its zenith angle at the view.
    mu_s: f32,
}

struct ViewUniform {
    // Ray directions in view space: origin + x · ndc.x + y · ndc.y (perspective).
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
    // For equirectangular pictures: view space from east, north (up is above).
    east: vec3f,
    // Which of the frame's stations the view stands at: its layer of the tables per station.
    station: u32,
    north: vec3f,
    // 1: the sky comes from the sky-view table; 0: every pixel marches its ray.
    sky_view: u32,
    // Part of the picture that is drawn: ndc of the picture = xy + zw · ndc of the target.
    tile: vec4f,
    // First pixel of that part.
    pixel: vec2f,
    // Elevation of the horizon, rad.
    horizon: f32,
    // Cosine of the horizon's zenith angle.
    horizon_mu: f32,
    lights: array<LightUniform, 4>,
    // The first light's disc, and the shadow of what stands before it.
    disc: DiscUniform,
    shadow: ShadowUniform,
    // Radius of the occluder, in radii of the Sun, that the eclipse table is made for.
    table_b: f32,
    // Whose air a station of another body is for.
    body: u32,
    // Layer of the night's grid that is the view's; what its 1 is, cd/m².
    night_layer: u32,
    night_unit: f32,
    // Bins of points along the sides of the picture; where the view's begin.
    point_bins: vec2u,
    point_bins_first: u32,
    padding: u32,
    // Glare of points: inverse cube, inverse square; softening, rad; exposed value at which it ends.
    glare: vec4f,
    moon: MoonUniform,
    // Rows of ICRS from view space (w: level of the star map, its side in texels), and of the ecliptic with its x to the Sun.
    icrs_from_view: array<vec4f, 3>,
    ecliptic_from_view: array<vec4f, 3>,
    // Rectangles of cells, four to a vector: x₀, y₀, x₁, y₁ in cells, a byte each, from the lowest.
    rectangles: array<vec4u, 72>,
}

@group(0) @binding(0) var<uniform> frame: FrameUniform;
@group(0) @binding(6) var exposure_texture: texture_2d<f32>;
// Visible part of the Sun over the separation of the discs, see `eclipse.wgsl`.
@group(0) @binding(8) var eclipse_table: texture_2d<f32>;
@group(1) @binding(0) var<uniform> view: ViewUniform;
