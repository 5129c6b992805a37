// Fills the aerial perspective of a view: light and transmittance over the picture and distance.

//#include "phenomena/air/aerial.wgsl"

@group(2) @binding(6) var froxel_light_out: texture_storage_3d<rgba32float, write>;
@group(2) @binding(7) var froxel_through_out: texture_storage_3d<rgba32float, write>;

// Cells of a slice.
const SLICE_CELLS: u32 = 2u;

// One invocation a column.
@compute @workgroup_size(8, 8)
fn fill_froxels(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(froxel_light_out);
    if any(id.xy >= size.xy) {
        return;
    }
    let ndc = vec2f(id.xy) / vec2f(size.xy - 1u) * 2.0 - 1.0;
    let sight = column_sight(ndc);
    var light_sum: array<vec3f, 64>;
    for (var light = 0u; light < frame.light_count; light++) {
        let ray = sight_ray(sight, light);
        let end = select(air_ends(ray), 0.0, ray.misses);
        let dark = dark_of(ray);
        var m = begin_march(ray);
        var t = 0.0;
        for (var slice = 0u; slice < size.z; slice++) {
            let to_t = min(slice_distance(f32(slice) / f32(size.z - 1u)), end);
            let from_t = t;
            for (var i = 0u; i < SLICE_CELLS; i++) {
                let next = mix(from_t, to_t, f32(i + 1u) / f32(SLICE_CELLS));
                add_cell(&m, 0.5 * (t + next), next - t, lit_part(dark, t, next));
                t = next;
            }
            let air = end_march(&m, vec4f(0.0));
            light_sum[slice] += rec709_of(view.lights[light].irradiance * max(air.radiance, vec4f(0.0)));
            if light + 1u == frame.light_count {
                textureStore(froxel_light_out, vec3u(id.xy, slice), vec4f(light_sum[slice], 0.0));
                textureStore(froxel_through_out, vec3u(id.xy, slice), vec4f(rec709_through(air.through_extended), 0.0));
            }
        }
    }
}
