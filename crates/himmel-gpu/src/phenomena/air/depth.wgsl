// Fills the table of optical depth to space from the densities. Twin of himmel_air::Columns.

//#include "phenomena/air/medium.wgsl"

@group(1) @binding(0) var<uniform> target_body: vec4u;
@group(1) @binding(1) var depth_out: texture_storage_2d_array<rgba32float, write>;

// Cells of a ray, crowded at its point nearest to the ground; two Gauss points in each: 1e-5 of the columns.
const DEPTH_CELLS: u32 = 48u;
// Thinner than any air that shows: keeps the logarithm finite.
const LEAST_DEPTH: f32 = 1e-20;

@compute @workgroup_size(8, 8)
fn fill_depth(@builtin(global_invocation_id) id: vec3u) {
    body = target_body.x;
    let size = textureDimensions(depth_out);
    if any(id.xy >= size) {
        return;
    }
    let radius = airs[body].bottom_radius_m;
    let top = airs[body].top_altitude_m;
    let uv = vec2f(id.xy) / vec2f(size - 1u);
    let ray = depth_table_ray(radius, top, uv.x, uv.y);
    let end = top_distance(radius, top, ray.x, ray.y);
    let nearest = clamp(-(radius + ray.x) * ray.y, 0.0, end);
    let before = sqrt(nearest);
    let after = sqrt(end - nearest);
    var scaled = vec4f(0.0);
    var peak = 0.0;
    let ds = (before + after) / f32(DEPTH_CELLS);
    for (var i = 0u; i < 2u * DEPTH_CELLS; i++) {
        // ±1/√3 of a cell's half.
        let place = f32(i / 2u) + 0.5 + (f32(i % 2u) - 0.5) * 0.57735027;
        let s = -before + place * ds;
        let h = altitude_along(radius, ray.x, ray.y, nearest + s * abs(s));
        let weight = abs(s) * ds;
        let coordinate = altitude_coordinate(h);
        let local = local_air(coordinate);
        scaled += weight * (local.extinction - local.peak);
        peak += weight * local.peak_reference;
    }
    textureStore(depth_out, id.xy, 2u * body, log2(max(scaled, vec4f(LEAST_DEPTH))));
    textureStore(depth_out, id.xy, 2u * body + 1u, vec4f(log2(max(peak, LEAST_DEPTH))));
}
