// How the sky view is laid out and looked up. Near a light the aerosols' forward peaks are too sharp for the table: there
// it holds their weights, and the pixel evaluates the peak at its own angle.

//#include "frame/frame.wgsl"
//#include "phenomena/air/march.wgsl"

// Layers of a light: radiance; depths of the peaks; weights of each aerosol (S, U).
@group(1) @binding(2) var sky_view_table: texture_2d_array<f32>;

// Angles to the light between which the peaks go over from the pixel to the table, rad.
const AUREOLE_FROM: f32 = 0.30;
const AUREOLE_TO: f32 = 0.50;

// Share of the peaks that the table itself holds.
fn table_share(theta: f32) -> f32 {
    return smoothstep(AUREOLE_FROM, AUREOLE_TO, theta);
}

fn sky_view_layer(light: u32) -> u32 {
    return (view.station * frame.light_count + light) * (2u + 2u * aerosols);
}

// The aerosols' peaks from a ray's weights and mean depths, at an angle to the light.
fn peaks_of(weights: array<vec4f, 8>, depths: vec2f, theta: f32, nu: f32) -> vec4f {
    let coordinate = theta_coordinate_of(theta);
    var sum = vec4f(0.0);
    for (var a = 0u; a < aerosols; a++) {
        let phase = aerosol_phase(airs[body].aerosols[a].layer, coordinate);
        sum += weights[2u * a] * peak_scaled(a, phase, coordinate, nu, depths.x);
        sum += weights[2u * a + 1u] * peak_unscaled(a, phase, coordinate, depths.y);
    }
    return sum;
}

// Where a ray lies in the table of a light. `below`: whether it meets the ground.
fn sky_view_uv(light: u32, ray: vec3f, mu: f32, below: bool) -> vec2f {
    let size = vec2f(textureDimensions(sky_view_table));
    let horizon = horizon_cosine(airs[body].bottom_radius_m, view.altitude_m);
    let y = elevation_texel(asin(clamp(mu, -1.0, 1.0)), asin(horizon), below, i32(size.y));
    let heading = view.lights[light].heading;
    let side = cross(view.up, heading);
    let azimuth = atan2(abs(dot(ray, side)), dot(ray, heading));
    return vec2f(azimuth / PI, y / (size.y - 1.0));
}

// Radiance along a ray at more than AUREOLE_TO from the light, per unit irradiance of the light, 1/sr.
fn sky_view_far(light: u32, ray: vec3f, mu: f32, below: bool) -> vec4f {
    return max(table_lookup(sky_view_table, sky_view_layer(light), sky_view_uv(light, ray, mu, below)), vec4f(0.0));
}

// The same at any angle.
fn sky_view_radiance(light: u32, ray: vec3f, mu: f32, below: bool) -> vec4f {
    let uv = sky_view_uv(light, ray, mu, below);
    let layer = sky_view_layer(light);
    let radiance = table_lookup(sky_view_table, layer, uv);
    let theta = angle_between(ray, view.lights[light].direction);
    let share = 1.0 - table_share(theta);
    let depths = table_lookup(sky_view_table, layer + 1u, uv).xy;
    var weights: array<vec4f, 8>;
    for (var a = 0u; a < 2u * aerosols; a++) {
        weights[a] = share * table_lookup(sky_view_table, layer + 2u + a, uv);
    }
    let peaks = peaks_of(weights, depths, theta, dot(ray, view.lights[light].direction));
    return max(radiance + peaks, vec4f(0.0));
}
