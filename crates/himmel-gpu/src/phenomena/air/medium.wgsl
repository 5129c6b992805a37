// The air and its tables, as every pass reads them. Bilinear by hand: exact weights on every adapter, and rgba32float
// needs no filtering. Twins: himmel_air::moments::Prepared, himmel_air::Columns, the table of moments.

//#include "frame/sphere.wgsl"

const MOST_SPECIES: u32 = 16u;
const MOST_AEROSOLS: u32 = 4u;
const MOST_BODIES: u32 = 4u;
// Row of the density table that holds how the moment table's columns lie at an altitude.
const SUNS_ROW: i32 = 4;
// Darkest G and irradiance that tables hold; what stands within a tenth of it is nothing.
const FLOOR: f32 = 1e-30;

// Of the air in hand: rows of densities, and aerosols. Constants, so that loops unroll and uniforms are read in place.
override species_groups: u32 = 4u;
override aerosols: u32 = 4u;

// All components with one profile; coefficients where the profile is 1, 1/m.
struct Species {
    extinction: vec4f,
    // Scattering into the aerosols' forward peaks.
    peak: vec4f,
    // Scaled medium: σ_s′, σ_s′χ₁′, σ_s′χ₂′.
    scaled_0: vec4f,
    scaled_1: vec4f,
    scaled_2: vec4f,
    // Molecules alone: σ_R, σ_R χ₂.
    molecules_0: vec4f,
    molecules_2: vec4f,
    // x: scattering into peaks at the reference wavelength.
    reference: vec4f,
}

struct Aerosol {
    // Scattering coefficient where the profile is 1, 1/m.
    scattering: vec4f,
    // (1 − f) σ_M p′ as a polynomial.
    smooth_0: vec4f,
    smooth_1: vec4f,
    smooth_2: vec4f,
    species: u32,
    // Layer of the peak table.
    layer: u32,
    padding_0: u32,
    padding_1: u32,
}

struct AirUniform {
    species: array<Species, 16>,
    aerosols: array<Aerosol, 4>,
    ground_albedo: vec4f,
    // Depth of the peaks at each wavelength relative to the reference.
    peak_ratio: vec4f,
    bottom_radius_m: f32,
    top_altitude_m: f32,
    padding_0: f32,
    species_count: u32,
    aerosol_count: u32,
    padding_1: u32,
    padding_2: u32,
    padding_3: u32,
}

@group(0) @binding(1) var<uniform> airs: array<AirUniform, 4>;
// Densities of four species a row over √(h / top); row SUNS_ROW: dip, lowest Sun, a, 1/(b − a). Layer: body.
@group(0) @binding(2) var density_table: texture_2d_array<f32>;
// log₂ of the scaled medium's depth to space; second layer of a body: of the peaks' depth at the reference.
@group(0) @binding(3) var depth_table: texture_2d_array<f32>;
// ln G and the ratios F_x, F_z, Q_xx, Q_zz, Q_xz to G; six layers a body.
@group(0) @binding(4) var moment_table: texture_2d_array<f32>;
// Corrections of S over depth, those of U; one row of the phase function, one of the mean of all aerosols'. Columns
// √(θ/π). Layer: aerosol.
@group(0) @binding(5) var peak_table: texture_2d_array<f32>;
// ln of the ground's irradiance by the sky over the moment table's columns; row: body.
@group(0) @binding(7) var ground_table: texture_2d<f32>;

// Whether other bodies than the one that the camera stands on or above have a part in this pass.
override far_airs: bool = false;
// Which body's air the functions below read.
var<private> body: u32 = 0u;

fn table_lookup(table: texture_2d_array<f32>, layer: u32, uv: vec2f) -> vec4f {
    // Every table has at least two texels a side, so the node before the last is always there.
    let last = vec2i(textureDimensions(table)) - 1;
    let p = clamp(uv, vec2f(0.0), vec2f(1.0)) * vec2f(last);
    let base = min(vec2i(p), last - 1);
    let f = p - vec2f(base);
    let low = mix(textureLoad(table, base, layer, 0), textureLoad(table, base + vec2i(1, 0), layer, 0), f.x);
    let high = mix(textureLoad(table, base + vec2i(0, 1), layer, 0), textureLoad(table, base + 1, layer, 0), f.x);
    return mix(low, high, f.y);
}

// Coordinate of an altitude in the table of densities and in the rows of the moments, 0..1.
fn altitude_coordinate(altitude_m: f32) -> f32 {
    return sqrt(clamp(altitude_m / airs[body].top_altitude_m, 0.0, 1.0));
}

// A row of the density table.
fn density_row(row: i32, coordinate: f32) -> vec4f {
    let last = i32(textureDimensions(density_table).x) - 1;
    let p = coordinate * f32(last);
    let base = min(i32(p), last - 1);
    return mix(
        textureLoad(density_table, vec2i(base, row), body, 0),
        textureLoad(density_table, vec2i(base + 1, row), body, 0),
        p - f32(base),
    );
}

// What a point of the air does to light, 1/m; all components together.
struct Local {
    extinction: vec4f,
    peak: vec4f,
    scaled_0: vec4f,
    scaled_1: vec4f,
    scaled_2: vec4f,
    molecules_0: vec4f,
    molecules_2: vec4f,
    peak_reference: f32,
    densities: array<vec4f, 4>,
}

fn local_air(coordinate: f32) -> Local {
    var local: Local;
    for (var group = 0u; group < species_groups; group++) {
        let density = density_row(i32(group), coordinate);
        local.densities[group] = density;
        for (var i = 0u; i < 4u; i++) {
            let n = density[i];
            let at = 4u * group + i;
            local.extinction += n * airs[body].species[at].extinction;
            local.peak += n * airs[body].species[at].peak;
            local.scaled_0 += n * airs[body].species[at].scaled_0;
            local.scaled_1 += n * airs[body].species[at].scaled_1;
            local.scaled_2 += n * airs[body].species[at].scaled_2;
            local.molecules_0 += n * airs[body].species[at].molecules_0;
            local.molecules_2 += n * airs[body].species[at].molecules_2;
            local.peak_reference += n * airs[body].species[at].reference.x;
        }
    }
    return local;
}

// The scaled medium alone: what rays of the moment table are made of.
struct ScaledLocal {
    extinction: vec4f,
    scaled_0: vec4f,
    scaled_1: vec4f,
    scaled_2: vec4f,
}

fn scaled_air(coordinate: f32) -> ScaledLocal {
    var local: ScaledLocal;
    for (var group = 0u; group < species_groups; group++) {
        let density = density_row(i32(group), coordinate);
        for (var i = 0u; i < 4u; i++) {
            let n = density[i];
            let at = 4u * group + i;
            local.extinction += n * (airs[body].species[at].extinction - airs[body].species[at].peak);
            local.scaled_0 += n * airs[body].species[at].scaled_0;
            local.scaled_1 += n * airs[body].species[at].scaled_1;
            local.scaled_2 += n * airs[body].species[at].scaled_2;
        }
    }
    return local;
}

fn sun_depth_uv(altitude_m: f32, mu: f32) -> vec2f {
    let h = clamp(altitude_m, 0.0, airs[body].top_altitude_m);
    // Directions below the horizon are taken as the horizon: the caller decides about shadow.
    let above = max(mu, horizon_cosine(airs[body].bottom_radius_m, h));
    return depth_table_uv(airs[body].bottom_radius_m, airs[body].top_altitude_m, h, above);
}

// Transmittance of the scaled medium to space.
fn scaled_to_space(altitude_m: f32, mu: f32) -> vec4f {
    return exp(-exp2(table_lookup(depth_table, 2u * body, sun_depth_uv(altitude_m, mu))));
}

// The same, and the depth of the peaks on the way at the reference wavelength.
struct ToSpace {
    through: vec4f,
    peak: f32,
}

fn to_space(altitude_m: f32, mu: f32) -> ToSpace {
    return ToSpace(scaled_to_space(altitude_m, mu), peak_to_space(altitude_m, mu));
}

// Depth of the peaks to space at the reference wavelength.
fn peak_to_space(altitude_m: f32, mu: f32) -> f32 {
    if aerosols == 0u {
        return 0.0;
    }
    return exp2(table_lookup(depth_table, 2u * body + 1u, sun_depth_uv(altitude_m, mu)).x);
}

// Transmittance of the whole medium to space: what discs and stars keep.
fn transmittance_to_space(altitude_m: f32, mu: f32) -> vec4f {
    let there = to_space(altitude_m, mu);
    return there.through * exp(-there.peak * airs[body].peak_ratio);
}

// asinh without the cancellation of log(x + √(x² + 1)) for negative x.
fn asinh_both(x: f32) -> f32 {
    return sign(x) * log(abs(x) + sqrt(x * x + 1.0));
}

const SUNS_WIDTH: f32 = 0.0872664625997;
const SUNS_CENTRE: f32 = -0.0523598775598;

// Column coordinate 0..1 of a Sun in the moment table and a factor on its light. suns: the row SUNS_ROW there.
fn suns_coordinate(suns: vec4f, mu_s: f32) -> vec2f {
    let x = asin(clamp(mu_s, -1.0, 1.0)) + suns.x;
    let u = (asinh_both((x - SUNS_CENTRE) / SUNS_WIDTH) - suns.z) * suns.w;
    if u >= 0.0 {
        return vec2f(min(u, 1.0), 1.0);
    }
    let fade = clamp(1.0 + (x - suns.y) / SUNS_WIDTH, 0.0, 1.0);
    return vec2f(0.0, fade * fade);
}

fn lit(light: vec4f) -> vec4f {
    return select(vec4f(0.0), light, light > vec4f(1.1 * FLOOR));
}

// Moments of all light scattered at least once.
struct Moments {
    g: vec4f,
    f_x: vec4f,
    f_z: vec4f,
    q_xx: vec4f,
    q_zz: vec4f,
    q_xz: vec4f,
}

// Their ratios to G; they change slowly along a ray. column: as `suns_coordinate`.
fn moment_ratios(coordinate: f32, column: f32) -> Moments {
    let uv = vec2f(column, coordinate);
    let layer = 6u * body;
    return Moments(
        vec4f(1.0),
        table_lookup(moment_table, layer + 1u, uv),
        table_lookup(moment_table, layer + 2u, uv),
        table_lookup(moment_table, layer + 3u, uv),
        table_lookup(moment_table, layer + 4u, uv),
        table_lookup(moment_table, layer + 5u, uv),
    );
}

// G itself.
fn moment_g(coordinate: f32, column: vec2f) -> vec4f {
    return lit(exp(table_lookup(moment_table, 6u * body, vec2f(column.x, coordinate))) * column.y);
}

// The directions of a view ray in the frame of the moments: x along the Sun's azimuth, and x², y².
fn frame_of_sun(mu: f32, mu_s: f32, nu: f32) -> vec3f {
    let sin_s = sqrt(max(1.0 - mu_s * mu_s, 0.0));
    let across = sqrt(max(1.0 - mu * mu, 0.0));
    // With the Sun in the zenith every azimuth is the same. 1e-4: below it f32 cosines have no azimuth left.
    if sin_s < 1e-4 {
        return vec3f(0.0, 0.5 * across * across, 0.5 * across * across);
    }
    let x = clamp((nu - mu * mu_s) / sin_s, -across, across);
    return vec3f(x, x * x, across * across - x * x);
}

// What a field of known moments scatters towards a viewer: twin of `add_scattered`.
fn scattered(m: Moments, w_0: vec4f, w_1: vec4f, w_2: vec4f, mu: f32, axes: vec3f) -> vec4f {
    let f = -(axes.x * m.f_x + mu * m.f_z);
    let q = m.q_xx * (axes.y - axes.z) + m.q_zz * (mu * mu - axes.z) + 2.0 * axes.x * mu * m.q_xz;
    return (w_0 * m.g + 3.0 * w_1 * f + 7.5 * w_2 * q) / (4.0 * PI);
}

// Irradiance of the ground by the sky, per unit irradiance of the Sun.
fn ground_sky_irradiance(mu_s: f32) -> vec4f {
    let column = suns_coordinate(density_row(SUNS_ROW, 0.0), mu_s);
    let last = i32(textureDimensions(ground_table).x) - 1;
    let p = column.x * f32(last);
    let base = min(i32(p), last - 1);
    let log_e = mix(
        textureLoad(ground_table, vec2i(base, i32(body)), 0),
        textureLoad(ground_table, vec2i(base + 1, i32(body)), 0),
        p - f32(base),
    );
    return lit(exp(log_e) * column.y);
}

// Irradiance of the level ground by Sun (with its forward-scattered company) and sky.
fn ground_irradiance(mu_s: f32) -> vec4f {
    let direct = select(vec4f(0.0), scaled_to_space(0.0, mu_s) * mu_s, mu_s > 0.0);
    return direct + ground_sky_irradiance(mu_s);
}
