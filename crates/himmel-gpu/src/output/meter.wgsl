// Automatic exposure: the geometric mean of a small picture's luminance, into one texel.

@group(0) @binding(0) var picture: texture_2d<f32>;

// Pixels darker than this share of the mean do not count: the black of space beside a lit planet.
const DARK_SHARE: f32 = 1e-3;
// Luminance of nothing at all, cd/m²; the darkest night sky has 2e-4.
const DARKEST: f32 = 1e-5;

fn luminance_at(x: u32, y: u32) -> vec2f {
    let colour = textureLoad(picture, vec2u(x, y), 0);
    // Alpha is 0 where there is no picture.
    return vec2f(max(dot(colour.rgb, vec3f(0.2126, 0.7152, 0.0722)), 0.0), colour.a);
}

@vertex
fn meter_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// x: the factor that exposure multiplies by; y: EV100; z: mean luminance in cd/m².
@fragment
fn meter_fragment() -> @location(0) vec4f {
    let size = textureDimensions(picture);
    var mean = 0.0;
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            let sample = luminance_at(x, y);
            mean += sample.x * sample.y / f32(size.x * size.y);
        }
    }
    let dark = max(DARK_SHARE * mean, DARKEST);
    var sum = 0.0;
    var count = 0.0;
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            let sample = luminance_at(x, y);
            if sample.y > 0.5 && sample.x >= dark {
                sum += log2(sample.x);
                count += 1.0;
            }
        }
    }
    let log_mean = select(log2(DARKEST), sum / max(count, 1.0), count > 0.0);
    // The mean becomes middle grey, 0.18, where saturation-based sensitivity puts white at 1.2 · 2^EV100 cd/m²
    // [lagarde2014]: EV100 = log2(L / (1.2 · 0.18)). −10: the darkest night.
    let ev100 = clamp(log_mean - log2(1.2 * 0.18), -10.0, 24.0);
    return vec4f(exp2(-ev100) / 1.2, ev100, exp2(log_mean), 1.0);
}
