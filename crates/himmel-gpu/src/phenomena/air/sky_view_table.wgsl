// How the sky view is laid out and looked up. Near a light the aerosols' forward peaks are too sharp for the table: there
// it holds them relative to their mean phase function, which the pixel evaluates at its own angle.

//#include "frame/frame.wgsl"
//#include "phenomena/air/march.wgsl"

// Layers of a light: radiance; what of the peaks the pixel adds, over the mean phase function.
@group(1) @binding(2) var sky_view_table: texture_2d_array<f32>;
@group(1) @binding(3) var linear_sampler: sampler;

// Angles to the light between which the peaks go over from the pixel to the table, rad; the second also in tiles.rs.
const AUREOLE_FROM: f32 = 0.20;
const AUREOLE_TO: f32 = 0.35;

// Share of the peaks that the table itself holds.
fn table_share(theta: f32) -> f32 {
    return smoothstep(AUREOLE_FROM, AUREOLE_TO, theta);
}

fn sky_view_layer(light: u32) -> u32 {
    return (view.station * frame.light_count + light) * 2u;
}

// The ray of a texel in a light's own frame: z up, x towards its azimuth.
struct SkyViewRay {
    direction: vec3f,
    // Of the zenith angle.
    sine: f32,
    // Angle to the light and its cosine.
    theta: f32,
    nu: f32,
}

fn sky_view_ray(texel: vec2u, size: vec2u, light: u32) -> SkyViewRay {
    let mu = texel_mu(i32(texel.y), i32(size.y), view.altitude_m);
    let sine = sqrt(max(1.0 - mu * mu, 0.0));
    let azimuth = 2.0 * asin(f32(texel.x) / f32(size.x - 1u));
    let mu_s = view.lights[light].mu_s;
    let direction = vec3f(sine * cos(azimuth), sine * sin(azimuth), mu);
    let sun = vec3f(sqrt(max(1.0 - mu_s * mu_s, 0.0)), 0.0, mu_s);
    // From the chord, which keeps the digits of small angles.
    return SkyViewRay(direction, sine, angle_between(direction, sun), clamp(dot(direction, sun), -1.0, 1.0));
}

// Factor that the table's light is stored with.
fn sky_view_scale(light: u32) -> f32 {
    return textureLoad(cell_table, vec2i(i32(light), cell_rows()), view.station, 0).x;
}

// Where a ray lies in the table of a light: across sin(φ/2) of its azimuth from the light, half the circle; up and down by
// elevation. `below`: whether it meets the ground.
fn sky_view_uv(light: u32, ray: vec3f, mu: f32, below: bool) -> vec2f {
    let size = vec2f(textureDimensions(sky_view_table));
    let y = elevation_texel(asin(clamp(mu, -1.0, 1.0)), view.horizon, below, i32(size.y));
    let level = ray - mu * view.up;
    let cosine = dot(level, view.lights[light].heading) * inverseSqrt(max(dot(level, level), 1e-12));
    let x = sqrt(clamp(0.5 - 0.5 * cosine, 0.0, 1.0)) * (size.x - 1.0);
    return (vec2f(x, y) + 0.5) / size;
}

fn sky_view_sample(layer: u32, uv: vec2f) -> vec4f {
    return textureSampleLevel(sky_view_table, linear_sampler, uv, layer, 0.0);
}

// Radiance along a ray at more than AUREOLE_TO from the light, per unit irradiance of the light, 1/sr, times the scale.
fn sky_view_far(light: u32, ray: vec3f, mu: f32, below: bool) -> vec4f {
    return max(sky_view_sample(sky_view_layer(light), sky_view_uv(light, ray, mu, below)), vec4f(0.0));
}

// The same at any angle.
fn sky_view_radiance(light: u32, ray: vec3f, mu: f32, below: bool) -> vec4f {
    let uv = sky_view_uv(light, ray, mu, below);
    let layer = sky_view_layer(light);
    var stored = sky_view_sample(layer, uv);
    if aerosols > 0u {
        // From the chord: exact where the peaks are.
        let theta = 2.0 * asin(min(0.5 * length(ray - view.lights[light].direction), 1.0));
        stored += sky_view_sample(layer + 1u, uv) * mean_phase(theta_coordinate_of(theta));
    }
    return max(stored, vec4f(0.0));
}
