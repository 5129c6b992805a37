// Automatic exposure: the geometric mean of a small picture's luminance, into one texel.

//#include "output/eye.wgsl"

struct MeterUniform {
    // 1: the mean becomes as bright as an eye finds it; 0: middle grey.
    eye: u32,
    // Since the last frame; negative: adapted at once.
    seconds: f32,
    // 1: darkness waits for photopigments.
    pigments: u32,
    padding: u32,
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<uniform> meter: MeterUniform;
// The texel of the last frame.
@group(0) @binding(2) var before: texture_2d<f32>;

// Pixels darker than this share of the mean do not count: the black of space beside a lit planet.
const DARK_SHARE: f32 = 1e-3;
// Luminance of nothing at all, cd/m²; the darkest night sky has 2e-4.
const DARKEST: f32 = 1e-5;

// Photopic and scotopic luminance; z is 0 where there is no picture.
fn luminance_at(x: u32, y: u32) -> vec3f {
    let colour = textureLoad(picture, vec2u(x, y), 0);
    return vec3f(
        max(dot(colour.rgb, LUMINANCE_WEIGHTS), 0.0), max(dot(colour.rgb, SCOTOPIC_FROM_REC709), 0.0), colour.a);
}

// How fast an eye follows, s.
fn adaptation_seconds(luminance: f32, brighter: bool) -> f32 {
    let rods = 0.04 / (0.04 + luminance);
    let both = select(vec2f(0.4, 0.1), vec2f(400.0, 110.0), meter.pigments == 1u && !brighter);
    return mix(both.y, both.x, rods);
}

@vertex
fn meter_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// x: the factor that exposure multiplies by; y: EV100; z: the luminance adapted to, cd/m²; w: 1.
@fragment
fn meter_fragment() -> @location(0) vec4f {
    let size = textureDimensions(picture);
    var mean = 0.0;
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            let sample = luminance_at(x, y);
            mean += sample.x * sample.z / f32(size.x * size.y);
        }
    }
    let dark = max(DARK_SHARE * mean, DARKEST);
    var sum = vec2f(0.0);
    var count = 0.0;
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            let sample = luminance_at(x, y);
            if sample.z > 0.5 && sample.x >= dark {
                sum += log2(max(sample.xy, vec2f(DARKEST)));
                count += 1.0;
            }
        }
    }
    var log_mean = select(vec2f(log2(DARKEST)), sum / max(count, 1.0), count > 0.0);
    let last = textureLoad(before, vec2u(0u), 0);
    if meter.seconds >= 0.0 && last.w > 0.5 && last.z > 0.0 {
        let past = log2(last.z);
        let share = exp(-meter.seconds / adaptation_seconds(last.z, log_mean.x > past));
        log_mean += vec2f(share * (past - log_mean.x));
    }
    // The mean becomes middle grey, 0.18, where saturation-based sensitivity puts white at 1.2 · 2^EV100 cd/m²
    // [lagarde2014]: EV100 = log2(L / (1.2 · 0.18)). −12: half of the darkest night.
    let luminance = exp2(log_mean);
    var middle = log_mean.x;
    if meter.eye == 1u {
        let seen = mesopic(luminance.x, luminance.y + EIGENGRAU).y;
        middle = log2(seen / brightness(luminance.x, luminance.y));
    }
    let ev100 = clamp(middle - log2(1.2 * 0.18), -12.0, 24.0);
    return vec4f(exp2(-ev100) / 1.2, ev100, luminance.x, 1.0);
}
