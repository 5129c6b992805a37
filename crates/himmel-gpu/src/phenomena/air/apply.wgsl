// Puts the air before another renderer's picture, by its depth.

//#include "phenomena/air/aerial.wgsl"
//#include "output/dither.wgsl"

@group(2) @binding(1) var scene_colour: texture_2d<f32>;
@group(2) @binding(2) var scene_depth: texture_depth_2d;
@group(2) @binding(4) var froxel_light: texture_3d<f32>;
@group(2) @binding(5) var froxel_through: texture_3d<f32>;

// Whether the air comes from froxels, or every pixel marches its ray.
override from_froxels: bool = false;

// Cells of a pixel's own march.
const APPLY_CELLS: u32 = 32u;

fn volume_lookup(volume: texture_3d<f32>, uvw: vec3f) -> vec3f {
    let last = vec3i(textureDimensions(volume)) - 1;
    let p = clamp(uvw, vec3f(0.0), vec3f(1.0)) * vec3f(last);
    let base = min(vec3i(p), last - 1);
    let f = p - vec3f(base);
    var sum = vec3f(0.0);
    for (var i = 0; i < 8; i++) {
        let step = vec3i(i & 1, (i >> 1) & 1, i >> 2);
        let weight = mix(vec3f(1.0) - f, f, vec3f(step));
        sum += weight.x * weight.y * weight.z * textureLoad(volume, base + step, 0).rgb;
    }
    return sum;
}

// Where a distance stands among the slices, 0..1. Between two of them light grows evenly with the distance, not with the
// slices, which crowd at the viewer: 12 % apart at the second.
fn slice_place(t: f32) -> f32 {
    let last = f32(textureDimensions(froxel_light).z - 1u);
    let slice = min(floor(slice_share(t) * last), last - 1.0);
    let from_t = slice_distance(slice / last);
    let to_t = slice_distance((slice + 1.0) / last);
    return (slice + clamp((t - from_t) / max(to_t - from_t, 1e-9), 0.0, 1.0)) / last;
}

struct ApplyVertex {
    @builtin(position) position: vec4f,
    @location(0) ndc: vec2f,
}

@vertex
fn apply_vertex(@builtin(vertex_index) index: u32) -> ApplyVertex {
    let ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return ApplyVertex(vec4f(ndc, 0.0, 1.0), ndc);
}

@fragment
fn apply_fragment(in: ApplyVertex) -> @location(0) vec4f {
    let pixel = vec2i(in.position.xy);
    let colour = textureLoad(scene_colour, pixel, 0);
    let depth = textureLoad(scene_depth, pixel, 0);
    let sight = sight_of(in.ndc, depth);
    var light = vec3f(0.0);
    var through = vec3f(1.0);
    if from_froxels {
        let ray = sight_ray(sight, 0u);
        let uvw = vec3f(0.5 * in.ndc + 0.5, slice_place(sight.distance_m - ray.before_m));
        light = volume_lookup(froxel_light, uvw);
        through = volume_lookup(froxel_through, uvw);
    } else {
        let jitter = select(0.5, hash_unit(vec3u(vec2u(pixel), 7u)).x, shafts);
        for (var i = 0u; i < frame.light_count; i++) {
            let air = march_sight(sight, i, APPLY_CELLS, jitter);
            light += rec709_of(view.lights[i].irradiance * air.light);
            through = rec709_through(air.through);
        }
    }
    var exposure = apply.exposure;
    if exposure == 0.0 {
        exposure = frame.exposure;
        if exposure == 0.0 {
            exposure = textureLoad(exposure_texture, vec2i(0), 0).x * frame.compensation;
        }
    }
    // Where nothing was drawn the sky is there already, or black.
    if depth == apply.far_depth {
        return colour;
    }
    return vec4f(colour.rgb * through + light * exposure, colour.a);
}
