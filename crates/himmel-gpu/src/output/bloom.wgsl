// Light that an eye spreads around what is bright, and the blur of eyes in dim light: passes over a finished linear
// picture. Halved again and again, then added up from the smallest, each level with its share of the light. The shares
// are the CIE's glare function, see bloom.rs.

//#include "output/tonemap.wgsl"
//#include "output/dither.wgsl"

// Most levels of the chain.
const MOST_LEVELS: u32 = 16u;

struct BloomUniform {
    // Shares of the levels, four to a vector.
    shares: array<vec4f, 4>,
    // Share of the picture itself.
    own_share: f32,
    levels: u32,
    // Angle of a pixel in the middle of the picture.
    degrees_per_pixel: f32,
    // What luminance was multiplied by, times the exposure texel's factor.
    exposure: f32,
    // 1: blurred as far as eyes are.
    acuity: u32,
    tonemap: u32,
    // 0: linear; 1: display-encoded target; 2: it encodes by itself.
    encoding: u32,
    dither_levels: f32,
    // Largest finite value of the target.
    largest: f32,
    // 1: the picture is linear on the way out.
    linear_out: u32,
    padding_0: f32,
    padding_1: f32,
}

@group(0) @binding(0) var<uniform> bloom: BloomUniform;
// The host's picture, or a level of a chain.
@group(0) @binding(1) var source: texture_2d<f32>;
// What is added to it: the sum of all smaller levels.
@group(0) @binding(2) var smaller: texture_2d<f32>;
// All levels.
@group(0) @binding(3) var chain: texture_2d<f32>;
@group(0) @binding(4) var exposure_texture: texture_2d<f32>;

struct BloomVertex {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) level: u32,
}

// The level is the instance.
@vertex
fn bloom_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> BloomVertex {
    let ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return BloomVertex(vec4f(ndc, 0.0, 1.0), instance);
}

// A pixel of the host's picture: NaN is black, infinity is the largest number that sums to something finite.
fn safe(colour: vec3f) -> vec3f {
    // Comparisons with NaN are false.
    let positive = select(vec3f(0.0), colour, colour > vec3f(0.0));
    return min(positive, vec3f(1e30));
}

fn texel(texture: texture_2d<f32>, place: vec2i, level: u32) -> vec3f {
    let size = vec2i(textureDimensions(texture, level));
    return textureLoad(texture, vec2u(clamp(place, vec2i(0), size - 1)), level).rgb;
}

// Half the size: (1 3 3 1) / 8 along each side. Every texel gives away exactly what it has, but for the edge.
@fragment
fn bloom_down(in: BloomVertex) -> @location(0) vec4f {
    let first = 2 * vec2i(in.position.xy) - 1;
    var sum = vec3f(0.0);
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let weight = select(1.0, 3.0, x == 1 || x == 2) * select(1.0, 3.0, y == 1 || y == 2) / 64.0;
            sum += weight * safe(texel(source, first + vec2i(x, y), 0u));
        }
    }
    return vec4f(sum, 1.0);
}

// Between texels of a level; `place`: in its texels, centres at half-integers.
fn between(texture: texture_2d<f32>, place: vec2f, level: u32) -> vec3f {
    let p = place - 0.5;
    let low = vec2i(floor(p));
    let f = p - floor(p);
    let top = mix(texel(texture, low, level), texel(texture, low + vec2i(1, 0), level), f.x);
    let bottom = mix(texel(texture, low + vec2i(0, 1), level), texel(texture, low + vec2i(1, 1), level), f.x);
    return mix(top, bottom, f.y);
}

fn share(level: u32) -> f32 {
    return bloom.shares[level / 4u][level % 4u];
}

// A level with its share, and the sum of all smaller ones.
@fragment
fn bloom_up(in: BloomVertex) -> @location(0) vec4f {
    var sum = share(in.level) * texel(source, vec2i(in.position.xy), 0u);
    if in.level + 1u < bloom.levels {
        sum += between(smaller, 0.5 * in.position.xy, 0u);
    }
    return vec4f(sum, 1.0);
}

// The finest grating that an eye resolves, cycles per degree.
fn acuity_cycles_per_deg(background: f32) -> f32 {
    return 17.25 * atan(1.4 * log10(max(background, 1e-12)) + 0.35) + 25.72;
}

// The picture at a size where texels are two to a power times as large.
fn blurred(place: vec2f, power: f32, sharp: vec3f) -> vec3f {
    let clamped = clamp(power, 0.0, f32(bloom.levels));
    let low = u32(floor(clamped));
    let high = min(low + 1u, bloom.levels);
    var fine = sharp;
    if low > 0u {
        fine = between(chain, place / exp2(f32(low)), low - 1u);
    }
    if high == 0u {
        return fine;
    }
    return mix(fine, between(chain, place / exp2(f32(high)), high - 1u), clamped - f32(low));
}

@fragment
fn bloom_finish(in: BloomVertex) -> @location(0) vec4f {
    let sharp = safe(texel(source, vec2i(in.position.xy), 0u));
    let exposure = bloom.exposure * textureLoad(exposure_texture, vec2u(0u), 0).x;
    var colour = sharp;
    if bloom.acuity == 1u && bloom.levels > 0u {
        // An eye is adapted to about a degree around where it looks.
        let degree = log2(max(1.0 / bloom.degrees_per_pixel, 1.0));
        let background = dot(blurred(in.position.xy, degree, sharp), LUMINANCE_WEIGHTS) / max(exposure, 1e-20);
        // Two pixels to the finest cycle.
        let power = log2(0.5 / (acuity_cycles_per_deg(background + EIGENGRAU) * bloom.degrees_per_pixel));
        colour = blurred(in.position.xy, power, sharp);
    }
    colour *= bloom.own_share;
    if bloom.levels > 0u {
        colour += between(smaller, 0.5 * in.position.xy, 0u);
    }
    if bloom.linear_out == 1u {
        return vec4f(min(colour, vec3f(bloom.largest)), 1.0);
    }
    var encoded = tonemap(bloom.tonemap, min(colour, vec3f(1e30)), exposure);
    if bloom.dither_levels > 0.0 {
        encoded += triangular_noise(vec2u(in.position.xy)) / bloom.dither_levels;
    }
    encoded = clamp(encoded, vec3f(0.0), vec3f(1.0));
    return vec4f(select(encoded, srgb_decode(encoded), bloom.encoding == 2u), 1.0);
}
