// Reads the air's tables. Bilinear by hand: exact weights on every adapter, and rgba32float needs no filtering.

//#include "frame/frame.wgsl"
//#include "frame/sphere.wgsl"

fn table_lookup(table: texture_2d<f32>, uv: vec2f) -> vec4f {
    // Every table has at least two texels a side, so the node before the last is always there.
    let last = vec2i(textureDimensions(table)) - 1;
    let p = clamp(uv, vec2f(0.0), vec2f(1.0)) * vec2f(last);
    let base = min(vec2i(p), last - 1);
    let f = p - vec2f(base);
    let low = mix(textureLoad(table, base, 0), textureLoad(table, base + vec2i(1, 0), 0), f.x);
    let high = mix(textureLoad(table, base + vec2i(0, 1), 0), textureLoad(table, base + 1, 0), f.x);
    return mix(low, high, f.y);
}

fn row_lookup(table: texture_2d<f32>, u: f32) -> vec4f {
    let last = i32(textureDimensions(table).x) - 1;
    let p = clamp(u, 0.0, 1.0) * f32(last);
    let base = min(i32(p), max(last - 1, 0));
    return mix(textureLoad(table, vec2i(base, 0), 0), textureLoad(table, vec2i(base + 1, 0), 0), p - f32(base));
}

// Coordinate of an altitude in the tables of the medium.
fn altitude_coordinate(altitude_m: f32) -> f32 {
    return sqrt(clamp(altitude_m / frame.top_altitude_m, 0.0, 1.0));
}

// Extinction coefficient of all components, 1/m.
fn extinction_per_m(altitude_m: f32) -> vec4f {
    return row_lookup(extinction_table, altitude_coordinate(altitude_m));
}

// Σ σ_s p(θ) of all components, 1/(m sr). theta_coordinate: √(θ/π).
fn scattering_per_m_sr(theta_coordinate: f32, altitude_m: f32) -> vec4f {
    return table_lookup(scattering_table, vec2f(theta_coordinate, altitude_coordinate(altitude_m)));
}

// Transmittance to space; directions below the horizon are taken as the horizon.
fn transmittance_to_space(altitude_m: f32, mu: f32) -> vec4f {
    let h = clamp(altitude_m, 0.0, frame.top_altitude_m);
    let above = max(mu, horizon_cosine(frame.bottom_radius_m, h));
    let uv = depth_table_uv(frame.bottom_radius_m, frame.top_altitude_m, h, above);
    return exp(-exp2(table_lookup(optical_depth_table, uv)));
}

// Irradiance of the sky on the ground per unit irradiance of the Sun.
fn ground_sky_irradiance(mu_s: f32) -> vec4f {
    let w = radians(5.0);
    let a = asinh(radians(-18.0) / w);
    let b = asinh(radians(90.0) / w);
    let u = (asinh(asin(clamp(mu_s, -1.0, 1.0)) / w) - a) / (b - a);
    if u < 0.0 {
        return vec4f(0.0);
    }
    return exp2(row_lookup(irradiance_table, u));
}
