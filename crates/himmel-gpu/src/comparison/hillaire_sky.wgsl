// The picture of [hillaire2020]: the table of the sky, the Sun's disc through the air, and the end that our own sky has.

//#include "comparison/hillaire.wgsl"
//#include "output/tonemap.wgsl"
//#include "output/dither.wgsl"

// Depth at infinity: 0 where depth is reversed, else 1.
override far_depth: f32 = 1.0;
// 0: linear Rec. 709 times exposure; 1: tone mapped and display-encoded.
override finished: u32 = 0u;

struct SkyVertex {
    @builtin(position) position: vec4f,
    @location(0) ray: vec3f,
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> SkyVertex {
    let ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    let ray = hillaire.ray_origin + hillaire.ray_x * ndc.x + hillaire.ray_y * ndc.y;
    return SkyVertex(vec4f(ndc, far_depth, 1.0), ray);
}

// Where a direction stands in the table: across the square root of its azimuth's haversine, sin(φ/2), half the circle
// from the Sun; up and down the square root of its angle from the horizon.
fn sky_view_uv(ray: vec3f, horizon: f32) -> vec2f {
    let cos_azimuth = ray.x * inverseSqrt(max(dot(ray.xy, ray.xy), 1e-12));
    let u = sqrt(clamp(0.5 - 0.5 * cos_azimuth, 0.0, 1.0));
    let horizon_angle = acos(horizon);
    let angle = acos(clamp(ray.z, -1.0, 1.0));
    let below = ray.z < horizon;
    let range = select(horizon_angle, PI - horizon_angle, below);
    let s = sqrt(clamp(abs(angle - horizon_angle) / range, 0.0, 1.0));
    let half_rows = 0.5 * SKY_VIEW_SIZE.y;
    let row = s * (half_rows - 1.0) + 0.5 + select(0.0, half_rows, below);
    return vec2f((u * (SKY_VIEW_SIZE.x - 1.0) + 0.5) / SKY_VIEW_SIZE.x, row / SKY_VIEW_SIZE.y);
}

// Radiance of the disc per unit irradiance of the Sun, 1/sr. A disc smaller than a pixel is widened to three quarters of
// one, its flux kept; the edge is smoothed over a pixel.
fn sun_disc_radiance(ray: vec3f, pixel: f32) -> vec4f {
    let drawn = max(hillaire.sun_radius, 0.75 * pixel);
    // From the chord, not from a dot product: f32 cosines of small angles have no digits left.
    let chord = length(ray - hillaire.sun_disc);
    let cover = clamp((drawn - chord) / pixel + 0.5, 0.0, 1.0);
    let x = min(chord / drawn, 1.0);
    let mu = sqrt(1.0 - x * x);
    let c = hillaire.limb_darkening;
    let relative = c[0] + mu * (c[1] + mu * (c[2] + mu * (c[3] + mu * (c[4] + mu * c[5]))));
    return cover * relative / (PI * drawn * drawn);
}

@fragment
fn sky_fragment(in: SkyVertex) -> @location(0) vec4f {
    let ray = normalize(in.ray);
    let pixel = max(max(length(dpdx(ray)), length(dpdy(ray))), 1e-9);
    let horizon = hillaire.horizon;
    var four = textureSampleLevel(sky_view_table, linear_sampler, sky_view_uv(ray, horizon), 0.0) / TABLE_SCALE;
    let reach = max(hillaire.sun_radius, 0.75 * pixel) + pixel;
    // As in our own pipelines nothing hangs on uniforms alone: lavapipe would compile them anew each frame.
    let near = select(4.0, distance(ray, hillaire.sun_disc), hillaire.sun_disc_visible != 0u);
    if near < reach && ray.z >= horizon {
        four += sun_transmittance(hillaire.altitude_m, ray.z) * sun_disc_radiance(ray, pixel);
    }
    four *= hillaire.sun_irradiance;
    let luminance = hillaire.exposure * vec3f(
        dot(hillaire.rec709_from_four_r, four),
        dot(hillaire.rec709_from_four_g, four),
        dot(hillaire.rec709_from_four_b, four),
    );
    if finished == 0u {
        return vec4f(clamp(luminance, vec3f(-hillaire.largest), vec3f(hillaire.largest)), 1.0);
    }
    // 1e30 keeps the tone mappers finite; negative values are colours outside Rec. 709.
    var encoded = tonemap(hillaire.tonemap, clamp(luminance, vec3f(0.0), vec3f(1e30)), hillaire.exposure);
    let noise = triangular_noise(vec2u(in.position.xy + hillaire.pixel)) / max(hillaire.dither_levels, 1.0);
    encoded += select(vec3f(0.0), noise, hillaire.dither_levels > 0.0);
    encoded = clamp(encoded, vec3f(0.0), vec3f(1.0));
    return vec4f(select(encoded, srgb_decode(encoded), hillaire.encoding == 2u), 1.0);
}
