// From scene-linear Rec. 709 to the display. Twins in output/tonemap.rs. Each tone mapper takes exposed, non-negative
// colour and returns display-encoded values 0..1.

//#include "output/eye.wgsl"

fn srgb_encode(linear: vec3f) -> vec3f {
    let low = 12.92 * linear;
    let high = 1.055 * pow(max(linear, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3f(0.0031308));
}

fn srgb_decode(encoded: vec3f) -> vec3f {
    let low = encoded / 12.92;
    let high = pow((max(encoded, vec3f(0.04045)) + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, encoded <= vec3f(0.04045));
}

fn tonemap_linear(colour: vec3f) -> vec3f {
    return srgb_encode(clamp(colour, vec3f(0.0), vec3f(1.0)));
}

fn tonemap_reinhard(colour: vec3f) -> vec3f {
    let low = pow(0.38317 * colour, vec3f(1.0 / 2.2));
    let high = vec3f(1.0) - exp(-colour);
    return select(high, low, colour < vec3f(1.413));
}

fn tonemap_hejl(colour: vec3f) -> vec3f {
    // 1e4 keeps the square finite in f32; the curve is 1 long before.
    let x = min(colour, vec3f(1e4));
    return (x * (6.2 * x + 0.5)) / (x * (6.2 * x + 1.7) + 0.06);
}

// power, saturation: the look that is applied between contrast and outset; 1, 1 is none.
fn agx(colour: vec3f, power: f32, saturation: f32) -> vec3f {
    let inset = mat3x3f(
        vec3f(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
        vec3f(0.0784335999999992, 0.878468636469772, 0.0784336),
        vec3f(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
    );
    let outset = mat3x3f(
        vec3f(1.19687900512017, -0.0528968517574562, -0.0529716355144438),
        vec3f(-0.0980208811401368, 1.15190312990417, -0.0980434501171241),
        vec3f(-0.0990297440797205, -0.0989611768448433, 1.15107367264116),
    );
    let stops = log2(max(inset * colour, vec3f(1e-10)));
    let x = clamp((stops + 12.47393) / (4.026069 + 12.47393), vec3f(0.0), vec3f(1.0));
    let x2 = x * x;
    let x4 = x2 * x2;
    let plain = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    let shaped = pow(max(plain, vec3f(0.0)), vec3f(power));
    let grey = dot(shaped, vec3f(0.2126, 0.7152, 0.0722));
    let contrast = grey + saturation * (shaped - grey);
    let display_linear = pow(max(outset * contrast, vec3f(0.0)), vec3f(2.2));
    return srgb_encode(clamp(display_linear, vec3f(0.0), vec3f(1.0)));
}

fn tonemap_agx(colour: vec3f) -> vec3f {
    return agx(colour, 1.0, 1.0);
}

fn tonemap_agx_punchy(colour: vec3f) -> vec3f {
    return agx(colour, 1.35, 1.4);
}

fn tonemap_neutral(colour: vec3f) -> vec3f {
    let start_compression = 0.8 - 0.04;
    let desaturation = 0.15;
    let x = min(colour.r, min(colour.g, colour.b));
    let offset = select(0.04, x - 6.25 * x * x, x < 0.08);
    var shifted = colour - offset;
    let peak = max(shifted.r, max(shifted.g, shifted.b));
    if peak >= start_compression {
        let d = 1.0 - start_compression;
        let new_peak = 1.0 - d * d / (peak + d - start_compression);
        shifted *= new_peak / peak;
        let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
        shifted = mix(shifted, vec3f(new_peak), g);
    }
    return srgb_encode(clamp(shifted, vec3f(0.0), vec3f(1.0)));
}

// What an eye sees, then agx-punchy. `exposure`: what luminance was multiplied by to give `colour`; `rod_colour`: see
// `seen_by_eye`.
fn tonemap_eye(colour: vec3f, exposure: f32, rod_colour: vec3f) -> vec3f {
    // 1e-20 for pictures that nobody exposed.
    let factor = max(exposure, 1e-20);
    // 1e30: finite in f32.
    return tonemap_agx_punchy(max(seen_by_eye(min(colour / factor, vec3f(1e30)), rod_colour) * factor, vec3f(0.0)));
}

// The operator that a pipeline is made for; 8: whichever the caller names. Rasterisers on CPUs run all that a switch has.
override tonemap_operator: u32 = 8u;

fn tonemap(mapper: u32, colour: vec3f, exposure: f32) -> vec3f {
    switch select(mapper, tonemap_operator, tonemap_operator < 8u) {
        case 0u: { return tonemap_linear(colour); }
        case 1u: { return tonemap_reinhard(colour); }
        case 2u: { return tonemap_hejl(colour); }
        case 3u: { return tonemap_agx(colour); }
        case 4u: { return tonemap_agx_punchy(colour); }
        case 5u: { return tonemap_neutral(colour); }
        case 6u: { return tonemap_eye(colour, exposure, vec3f(1.0)); }
        default: { return tonemap_eye(colour, exposure, NIGHT_BLUE); }
    }
}
