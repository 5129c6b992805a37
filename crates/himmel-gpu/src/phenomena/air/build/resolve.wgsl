// Adds a finished order to the sum, closes it with the geometric tail, and stores both as they are looked up.
// Twin of `Moments::build` in himmel_air::moments.

//#include "phenomena/air/build/build.wgsl"

@group(2) @binding(0) var<storage, read_write> moments: array<vec4f>;
@group(2) @binding(1) var<storage, read_write> stored: array<vec4f>;
@group(2) @binding(2) var<storage, read_write> changes: array<atomic<u32>, 256>;
@group(2) @binding(3) var moments_out: texture_storage_2d_array<rgba32float, write>;
@group(2) @binding(4) var ground_out: texture_storage_2d<rgba32float, write>;

// A conservative cloud's ratio may come close to 1, where the tail would be a guess.
const LARGEST_RATIO: f32 = 0.97;
// G of this size counts half in the question whether the orders have converged.
const DIM: f32 = 1e-6;

// What all orders beyond the last will add, relative to the last.
fn tail(before: vec4f, last: vec4f) -> vec4f {
    let q = min(last / max(before, vec4f(FLOOR)), vec4f(LARGEST_RATIO));
    let falls = before > vec4f(FLOOR) & last > vec4f(FLOOR) & last <= before;
    return select(vec4f(0.0), q / (vec4f(1.0) - q), falls);
}

fn log_of(light: vec4f) -> vec4f {
    return log(max(light, vec4f(FLOOR)));
}

fn ratio_of(moment: vec4f, g: vec4f) -> vec4f {
    // No light has |F| > G or |Q| > G; an undershoot of the polynomial phase could.
    return select(vec4f(0.0), clamp(moment / max(g, vec4f(FLOOR)), vec4f(-1.0), vec4f(1.0)), g > vec4f(FLOOR));
}

@compute @workgroup_size(8, 8)
fn resolve(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= build.columns || id.y >= build.rows {
        return;
    }
    if build.order >= 2u && bitcast<f32>(atomicLoad(&changes[build.order - 1u])) < build.tolerance {
        return;
    }
    let texel = id.y * build.columns + id.x;
    let section = build.rows * build.columns * SEVEN;
    let new_at = texel * SEVEN;
    let old_at = section + new_at;
    let sum_at = 2u * section + new_at;
    // The last total of G, its tail included.
    let total_at = 3u * section + texel;
    var g_before = vec4f(0.0);
    var beyond = vec4f(0.0);
    var beyond_ground = vec4f(0.0);
    if build.order >= 2u {
        g_before = moments[total_at];
        beyond = tail(moments[old_at], moments[new_at]);
        beyond_ground = tail(moments[old_at + 6u], moments[new_at + 6u]);
    }
    var total: array<vec4f, 7>;
    for (var m = 0u; m < SEVEN; m++) {
        let light = moments[new_at + m];
        var sum = light;
        if build.order >= 2u {
            sum += moments[sum_at + m];
        }
        total[m] = sum + select(beyond, beyond_ground, m == 6u) * light;
        moments[sum_at + m] = sum;
        moments[old_at + m] = light;
        stored[new_at + m] = select(ratio_of(light, moments[new_at]), log_of(light), m == 0u || m == 6u);
    }
    moments[total_at] = total[0];
    let now = max(total[0], vec4f(FLOOR));
    let change = select(vec4f(0.0), abs(now - g_before) / now / (vec4f(1.0) + sqrt(vec4f(DIM) / now)), total[0] > vec4f(FLOOR));
    let largest = max(max(change.x, change.y), max(change.z, change.w));
    atomicMax(&changes[build.order], bitcast<u32>(largest));
    let layer = 6u * build.body;
    textureStore(moments_out, id.xy, layer, log_of(total[0]));
    for (var m = 1u; m < 6u; m++) {
        textureStore(moments_out, id.xy, layer + m, ratio_of(total[m], total[0]));
    }
    if id.y == 0u {
        textureStore(ground_out, vec2u(id.x, build.body), log_of(total[6]));
    }
}
