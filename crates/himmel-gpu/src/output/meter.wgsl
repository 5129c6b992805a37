// Automatic exposure: the geometric mean of a small picture's luminance, into one texel.

@group(0) @binding(0) var picture: texture_2d<f32>;

// Luminance below which a pixel counts as this: the darkest night sky is 2e-4 cd/m².
const DARKEST: f32 = 1e-5;

@vertex
fn meter_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// x: the factor that exposure multiplies by; y: EV100; z: mean luminance in cd/m².
@fragment
fn meter_fragment() -> @location(0) vec4f {
    let size = textureDimensions(picture);
    var sum = 0.0;
    var count = 0.0;
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            let colour = textureLoad(picture, vec2u(x, y), 0);
            // Alpha is 0 where there is no picture.
            sum += colour.a * log2(max(dot(colour.rgb, vec3f(0.2126, 0.7152, 0.0722)), DARKEST));
            count += colour.a;
        }
    }
    let log_mean = sum / max(count, 1.0);
    // Reflected-light meter with K = 12.5: EV100 = log2(L · 100 / 12.5) [iso2720]. −10: the darkest night.
    let ev100 = clamp(log_mean + 3.0, -10.0, 24.0);
    // Saturation-based sensitivity: white at 1.2 · 2^EV100 cd/m² [lagarde2014].
    return vec4f(exp2(-ev100) / 1.2, ev100, exp2(log_mean), 1.0);
}
