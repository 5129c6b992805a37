// The glow of the night. Twin: night_glow/model.rs, where the formulas are explained.

//#include "frame/frame.wgsl"
//#include "phenomena/air/march.wgsl"

struct NightUniform {
    // Radiances are per unit irradiance of the Sun at 1 au, sr⁻¹. Airglow at the zenith.
    airglow: vec4f,
    // Of one S10 of the map's red, green, blue.
    four_from_red: vec4f,
    four_from_green: vec4f,
    four_from_blue: vec4f,
    // Light of cities: factor, and the air's depth of the vertical.
    pollution: vec4f,
    depth: vec4f,
    // Mean radiance that falls on the air, and what becomes of it (`diffuse_transmission`).
    diffuse: vec4f,
    diffuse_factor: vec4f,
    // Of the ground lit by the night.
    ground: vec4f,
    // Distance of the layer's middle from the planet's centre, m; 1/w; w over its vertical path.
    layer_radius_m: f32,
    per_layer_unit: f32,
    unit_over_vertical: f32,
    // Radiance of a texel of the zodiacal table.
    zodiacal: f32,
    // Texels of the star map to a radian in the middle of a face.
    texels_per_rad: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

@group(2) @binding(0) var<uniform> night_glow: NightUniform;
@group(2) @binding(1) var star_map: texture_cube<f32>;
// Over longitude from the Sun and latitude, nodes a degree apart.
@group(2) @binding(2) var zodiacal_table: texture_2d<f32>;
@group(2) @binding(3) var mip_sampler: sampler;

// Integral of 1 − (s² + α)² over s, three-point Gauss–Legendre.
fn layer_between(alpha: f32, start: f32, end: f32) -> f32 {
    let half = 0.5 * max(end - start, 0.0);
    let s = start + half * (1.0 + vec3f(-0.774596669241483, 0.0, 0.774596669241483));
    let u = s * s + alpha;
    return half * dot(vec3f(5.0, 8.0, 5.0) / 9.0, 1.0 - u * u);
}

// What a ray crosses of a layer relative to the zenith: on the near side of its point nearest to the planet, on the far side.
fn airglow_path(
    radius_m: f32, per_unit: f32, unit_over_vertical: f32, distance_m: f32, mu: f32, sin_theta: f32, below: bool) -> vec2f {
    let nearest = distance_m * sin_theta;
    let alpha = ((nearest - radius_m) * per_unit) * ((nearest + radius_m) * per_unit);
    let outer = sqrt(max(1.0 - alpha, 0.0));
    let inner = sqrt(max(-1.0 - alpha, 0.0));
    let eye = distance_m * mu * per_unit;
    let near = layer_between(alpha, inner, min(outer, -eye));
    let far = select(layer_between(alpha, max(inner, eye), outer), 0.0, below);
    return unit_over_vertical * vec2f(near, far);
}

// From the star map by the ray and how far it is to the next pixel, rad.
fn starlight(ray: vec3f, pixel: f32) -> vec4f {
    let direction = vec3f(
        dot(view.icrs_from_view[0].xyz, ray), dot(view.icrs_from_view[1].xyz, ray), dot(view.icrs_from_view[2].xyz, ray));
    let level = log2(max(pixel * night_glow.texels_per_rad, 1.0));
    let rgb = textureSampleLevel(star_map, mip_sampler, direction, level).rgb;
    return night_glow.four_from_red * rgb.r + night_glow.four_from_green * rgb.g + night_glow.four_from_blue * rgb.b;
}

fn zodiacal_light(ray: vec3f) -> vec4f {
    let direction = vec3f(
        dot(view.ecliptic_from_view[0].xyz, ray),
        dot(view.ecliptic_from_view[1].xyz, ray),
        dot(view.ecliptic_from_view[2].xyz, ray));
    let degrees = vec2f(atan2(abs(direction.y), direction.x), asin(min(abs(direction.z), 1.0))) * (180.0 / PI);
    let uv = (degrees + 0.5) / vec2f(textureDimensions(zodiacal_table));
    return night_glow.zodiacal * textureSampleLevel(zodiacal_table, mip_sampler, uv, 0.0);
}

// What the night shows along a ray: airglow, zodiacal light, stars through the air, and what it scatters of them and of cities'
// light. `within`: the camera is in the air, below the layer.
fn night_radiance(ray: vec3f, pixel: f32, mu: f32, sin_theta: f32, below: bool, within: bool) -> vec4f {
    let radius_m = airs[body].bottom_radius_m;
    let distance_m = radius_m + view.altitude_m;
    var start_m = view.altitude_m;
    var start_mu = mu;
    var misses = false;
    if !within {
        let start = enter(view.altitude_m, mu, sin_theta, 0.0, 0.0, 0.0);
        start_m = start.altitude_m;
        start_mu = start.mu;
        misses = start.misses;
    }
    let layer = night_glow;
    let path = airglow_path(
        layer.layer_radius_m, layer.per_layer_unit, layer.unit_over_vertical, distance_m, mu, sin_theta, below);
    if below {
        // Upward from the ground, and upward from here, along the same line.
        let nearest = distance_m * sin_theta;
        let up = sqrt(max(vec2f(1.0) - vec2f(nearest / radius_m, nearest / (radius_m + start_m)) *
            vec2f(nearest / radius_m, nearest / (radius_m + start_m)), vec2f(0.0)));
        let through = min(scaled_to_space(0.0, up.x) / max(scaled_to_space(start_m, up.y), vec4f(1e-30)), vec4f(1.0));
        return layer.airglow * path.x + mix(0.5 * (layer.diffuse + layer.ground), layer.ground, through);
    }
    var through = scaled_to_space(start_m, start_mu);
    through = select(through, vec4f(1.0), misses);
    let up = clamp(mu, 0.0, 1.0);
    let total = ((2.0 + 3.0 * up) + (2.0 - 3.0 * up) * through) * layer.diffuse_factor;
    let behind = starlight(ray, pixel) + zodiacal_light(ray) + layer.airglow * path.y;
    return behind * through + layer.airglow * path.x + layer.diffuse * max(total - through, vec4f(0.0))
        + layer.pollution * (1.0 - exp(-layer.depth * inverseSqrt(1.0 - 0.96 * (1.0 - up * up))));
}
