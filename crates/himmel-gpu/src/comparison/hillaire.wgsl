// The usual approximation [hillaire2020]: what its tables and its picture share. Twin of himmel_air::hillaire, `USUAL`.
// Vectors are in the Sun's frame: z is the zenith at the camera, x points to the Sun's azimuth.

//#include "frame/sphere.wgsl"

struct HillaireUniform {
    // Rows R, G, B: linear Rec. 709 in cd/m² from radiance per unit irradiance of the Sun.
    rec709_from_four_r: vec4f,
    rec709_from_four_g: vec4f,
    rec709_from_four_b: vec4f,
    // Irradiance of the Sun relative to 1 au.
    sun_irradiance: vec4f,
    ground_albedo: vec4f,
    // Coefficients of the Sun's limb darkening: Σ c_k µ^k relative to the mean.
    limb_darkening: array<vec4f, 6>,
    // Ray directions: origin + x · ndc.x + y · ndc.y.
    ray_origin: vec3f,
    bottom_radius_m: f32,
    ray_x: vec3f,
    top_altitude_m: f32,
    ray_y: vec3f,
    altitude_m: f32,
    // Towards the Sun's disc, refracted.
    sun_disc: vec3f,
    sun_radius: f32,
    // Cosine of the Sun's zenith angle without refraction: lights the air.
    mu_s: f32,
    exposure: f32,
    // Cosine of the zenith angle of the camera's horizon.
    horizon: f32,
    sun_disc_visible: u32,
    tonemap: u32,
    // 1: the target wants display-encoded values; 2: it encodes by itself (an sRGB format).
    encoding: u32,
    // Levels of the target that dithering hides; 0: no dithering.
    dither_levels: f32,
    // Largest finite value of the target.
    largest: f32,
    // First pixel of the part of the picture that is drawn.
    pixel: vec2f,
    padding: vec2f,
}

@group(0) @binding(0) var<uniform> hillaire: HillaireUniform;
// For each altitude: extinction of all components, then scattering of each phase function's components, 1/m.
@group(0) @binding(1) var<storage, read> medium: array<vec4f>;
// For each phase function: its values over the scattering angle, 1/sr.
@group(0) @binding(2) var<storage, read> phases: array<vec4f>;
@group(0) @binding(3) var linear_sampler: sampler;
@group(0) @binding(4) var transmittance_table: texture_2d<f32>;
@group(0) @binding(5) var multiple_table: texture_2d<f32>;
@group(0) @binding(6) var sky_view_table: texture_2d<f32>;

// How many phase functions there are: 1 to 4.
override phase_count: u32 = 2u;

// Nodes of the medium over √(h / top), and of a phase function over √(θ / π).
const NODES: u32 = 256u;
// Tables hold 256 times what they mean: half floats are exact to 2e-4 down to 2.4e-7 /sr and end at 255 /sr.
const TABLE_SCALE: f32 = 256.0;
const HALF_LARGEST: f32 = 65504.0;
const TRANSMITTANCE_SIZE: vec2f = vec2f(256.0, 64.0);
const MULTIPLE_SIZE: vec2f = vec2f(32.0, 32.0);
// Rows 0 to 49 look above the horizon, 50 to 99 below: no filter mixes the two.
const SKY_VIEW_SIZE: vec2f = vec2f(200.0, 100.0);

// The first and last node of a table lie at coordinates 0 and 1, in the middle of their texels.
fn texel_uv(coordinate: vec2f, size: vec2f) -> vec2f {
    return (coordinate * (size - 1.0) + 0.5) / size;
}

fn node_coordinate(index: vec2u, size: vec2f) -> vec2f {
    return vec2f(index) / (size - 1.0);
}

// One value for each phase function.
struct PhaseValues {
    a: vec4f,
    b: vec4f,
    c: vec4f,
    d: vec4f,
}

fn phase_value(which: u32, x: f32) -> vec4f {
    let i = min(u32(x), NODES - 2u);
    return mix(phases[which * NODES + i], phases[which * NODES + i + 1u], x - f32(i));
}

// The phase functions at cos θ = nu, 1/sr.
fn phases_at(nu: f32) -> PhaseValues {
    let x = sqrt(acos(clamp(nu, -1.0, 1.0)) / PI) * f32(NODES - 1u);
    var values = PhaseValues(phase_value(0u, x), vec4f(0.0), vec4f(0.0), vec4f(0.0));
    if phase_count > 1u { values.b = phase_value(1u, x); }
    if phase_count > 2u { values.c = phase_value(2u, x); }
    if phase_count > 3u { values.d = phase_value(3u, x); }
    return values;
}

// What the air is at one altitude, 1/m.
struct Local {
    extinction: vec4f,
    scattering: vec4f,
    // Σ σ_s p, 1/(m sr).
    phased: vec4f,
}

fn local_air(altitude_m: f32, phase: PhaseValues) -> Local {
    let x = sqrt(clamp(altitude_m / hillaire.top_altitude_m, 0.0, 1.0)) * f32(NODES - 1u);
    let i = min(u32(x), NODES - 2u);
    let f = x - f32(i);
    let stride = 1u + phase_count;
    let low = i * stride;
    let high = low + stride;
    let a = mix(medium[low + 1u], medium[high + 1u], f);
    var here = Local(mix(medium[low], medium[high], f), a, a * phase.a);
    if phase_count > 1u {
        let b = mix(medium[low + 2u], medium[high + 2u], f);
        here.scattering += b;
        here.phased += b * phase.b;
    }
    if phase_count > 2u {
        let c = mix(medium[low + 3u], medium[high + 3u], f);
        here.scattering += c;
        here.phased += c * phase.c;
    }
    if phase_count > 3u {
        let d = mix(medium[low + 4u], medium[high + 4u], f);
        here.scattering += d;
        here.phased += d * phase.d;
    }
    return here;
}

// ∫ T dt over a cell of even air that lets `through` pass, m. Below an optical depth of 1e-3 the closed form cancels in
// f32; the series is exact to 1e-7.
fn effective_length(extinction: vec4f, through: vec4f, length_m: f32) -> vec4f {
    let depth = extinction * length_m;
    return select((vec4f(1.0) - through) / extinction, length_m * (vec4f(1.0) - 0.5 * depth), depth < vec4f(1e-3));
}

// Transmittance to the Sun, 0 in the planet's shadow.
fn sun_transmittance(altitude_m: f32, mu_s: f32) -> vec4f {
    if mu_s < horizon_cosine(hillaire.bottom_radius_m, altitude_m) {
        return vec4f(0.0);
    }
    let uv = depth_table_uv(hillaire.bottom_radius_m, hillaire.top_altitude_m, altitude_m, mu_s);
    return textureSampleLevel(transmittance_table, linear_sampler, texel_uv(uv, TRANSMITTANCE_SIZE), 0.0);
}

// Ψ_ms: mean radiance of the light that was scattered or reflected at least once, 1/sr.
fn multiple_at(altitude_m: f32, mu_s: f32) -> vec4f {
    let uv = vec2f(0.5 * mu_s + 0.5, altitude_m / hillaire.top_altitude_m);
    return textureSampleLevel(multiple_table, linear_sampler, texel_uv(uv, MULTIPLE_SIZE), 0.0) / TABLE_SCALE;
}

// L_o: direct sunlight that level ground reflects, 1/sr.
fn ground_reflected(mu_s: f32) -> vec4f {
    if mu_s <= 0.0 {
        return vec4f(0.0);
    }
    return hillaire.ground_albedo / PI * mu_s * sun_transmittance(0.0, mu_s);
}
