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
    // Depth of the vertical below the camera over that above it.
    depth_below: vec4f,
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
}

@group(1) @binding(4) var<uniform> night_glow: NightUniform;
// Faces of a cube; texels of three values with a common exponent.
@group(1) @binding(5) var star_map: texture_2d_array<u32>;
// A quarter of the sphere, see `zodiacal.rs`.
@group(1) @binding(6) var zodiacal_table: texture_2d<f32>;
const ZODIACAL_SIZE: vec2f = vec2f(512.0, 256.0);

// Integral of 1 − (s² + α)² over s, three-point Gauss–Legendre.
fn layer_between(alpha: f32, start: f32, end: f32) -> f32 {
    let half = 0.5 * max(end - start, 0.0);
    let s = start + half * (1.0 + vec3f(-0.774596669241483, 0.0, 0.774596669241483));
    let u = s * s + alpha;
    return half * dot(vec3f(5.0, 8.0, 5.0) / 9.0, 1.0 - u * u);
}

// What a ray crosses of a layer relative to the zenith: on the near side of its point nearest to the planet, on the far side.
// `within`: nothing of it is near.
fn airglow_path(
    radius_m: f32, per_unit: f32, unit_over_vertical: f32, distance_m: f32, mu: f32, sin_theta: f32, below: bool,
    within: bool) -> vec2f {
    let nearest = distance_m * sin_theta;
    let alpha = ((nearest - radius_m) * per_unit) * ((nearest + radius_m) * per_unit);
    let outer = sqrt(max(1.0 - alpha, 0.0));
    let inner = sqrt(max(-1.0 - alpha, 0.0));
    let eye = distance_m * mu * per_unit;
    var near = 0.0;
    if !within {
        near = layer_between(alpha, inner, min(outer, -eye));
    }
    let far = select(layer_between(alpha, max(inner, eye), outer), 0.0, below);
    return unit_over_vertical * vec2f(near, far);
}

// Three values of nine bits with a common exponent.
fn unpack_star(texel: u32) -> vec3f {
    let scale = bitcast<f32>(((texel >> 27u) + 103u) << 23u);
    return vec3f(vec3u(texel & 511u, (texel >> 9u) & 511u, (texel >> 18u) & 511u)) * scale;
}

// Of the stars that are not drawn one by one, bilinear within a face. By hand: a rasteriser on the CPU is no faster with a cube and a
// sampler, which the f64 twin could not follow across edges.
fn starlight(ray: vec3f) -> vec4f {
    let d = vec3f(
        dot(view.icrs_from_view[0].xyz, ray), dot(view.icrs_from_view[1].xyz, ray), dot(view.icrs_from_view[2].xyz, ray));
    // Faces as WebGPU's cube textures have them.
    let a = abs(d);
    let along_x = a.x >= a.y && a.x >= a.z;
    let along_y = !along_x && a.y >= a.z;
    let major = select(select(d.z, d.y, along_y), d.x, along_x);
    let negative = major < 0.0;
    let turn = select(1.0, -1.0, negative);
    let face = select(select(4u, 2u, along_y), 0u, along_x) + select(0u, 1u, negative);
    let place = select(
        select(vec2f(turn * d.x, -d.y), vec2f(d.x, turn * d.z), along_y), vec2f(-turn * d.z, -d.y), along_x) / abs(major);
    let level = u32(view.icrs_from_view[0].w);
    let side = view.icrs_from_view[1].w;
    let p = clamp((0.5 * place + 0.5) * side - 0.5, vec2f(0.0), vec2f(side - 1.0));
    let low = vec2u(p);
    let high = min(low + 1u, vec2u(u32(side) - 1u));
    let f = p - vec2f(low);
    let rgb = mix(
        mix(unpack_star(textureLoad(star_map, low, face, level).x),
            unpack_star(textureLoad(star_map, vec2u(high.x, low.y), face, level).x), f.x),
        mix(unpack_star(textureLoad(star_map, vec2u(low.x, high.y), face, level).x),
            unpack_star(textureLoad(star_map, high, face, level).x), f.x), f.y);
    return night_glow.four_from_red * rgb.r + night_glow.four_from_green * rgb.g + night_glow.four_from_blue * rgb.b;
}

fn zodiacal_light(ray: vec3f) -> vec4f {
    let direction = vec3f(
        dot(view.ecliptic_from_view[0].xyz, ray),
        dot(view.ecliptic_from_view[1].xyz, ray),
        dot(view.ecliptic_from_view[2].xyz, ray));
    let octahedron = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    let size = ZODIACAL_SIZE;
    let p = clamp(vec2f(0.5 + 0.5 * octahedron.x, abs(octahedron.z)) * size - 0.5, vec2f(0.0), size - 1.0);
    let low = min(vec2u(p), vec2u(size) - 2u);
    let high = low + 1u;
    let f = p - vec2f(low);
    return night_glow.zodiacal * mix(
        mix(textureLoad(zodiacal_table, low, 0), textureLoad(zodiacal_table, vec2u(high.x, low.y), 0), f.x),
        mix(textureLoad(zodiacal_table, vec2u(low.x, high.y), 0), textureLoad(zodiacal_table, high, 0), f.x), f.y);
}

// What the night shows along a ray: airglow, zodiacal light, stars through the air, and what it scatters of them and of cities'
// light. `within`: the camera is in the air, below the layer.
// `open`: share of the pixel that the Moon does not cover.
fn night_radiance(ray: vec3f, mu: f32, sin_theta: f32, below: bool, within: bool, open: f32) -> vec4f {
    let distance_m = airs[body].bottom_radius_m + view.altitude_m;
    // One look-up of T′ for all: towards space, or of the same line upwards from where it is in the air or on the ground.
    var from_m = view.altitude_m;
    var from_mu = select(mu, -mu, below);
    var depths = select(vec4f(1.0), night_glow.depth_below, below);
    if !within {
        let start = enter(view.altitude_m, mu, sin_theta, 0.0, 0.0, 0.0);
        let above_air = view.altitude_m > airs[body].top_altitude_m;
        if above_air && below {
            let nearest = distance_m * sin_theta / airs[body].bottom_radius_m;
            from_m = 0.0;
            from_mu = sqrt(max(1.0 - nearest * nearest, 0.0));
            depths = vec4f(1.0);
        } else if above_air {
            from_m = start.altitude_m;
            from_mu = start.mu;
            depths = vec4f(select(1.0, 0.0, start.misses));
        }
    }
    let depth = exp2(table_lookup(depth_table, 2u * body, sun_depth_uv(from_m, from_mu)));
    let through = exp(-depth * depths);
    let path = airglow_path(
        night_glow.layer_radius_m, night_glow.per_layer_unit, night_glow.unit_over_vertical, distance_m, mu, sin_theta,
        below, within);
    let up = clamp(mu, 0.0, 1.0);
    let total = ((2.0 + 3.0 * up) + (2.0 - 3.0 * up) * through) * night_glow.diffuse_factor;
    let cities = night_glow.pollution * (1.0 - exp(-night_glow.depth * inverseSqrt(1.0 - 0.96 * (1.0 - up * up))));
    let behind = open * (starlight(ray) + zodiacal_light(ray)) + night_glow.airglow * path.y;
    let sky = behind * through + night_glow.diffuse * max(total - through, vec4f(0.0)) + cities;
    let ground = mix(0.5 * (night_glow.diffuse + night_glow.ground), night_glow.ground, through);
    return select(sky, ground, below) + night_glow.airglow * path.x;
}
