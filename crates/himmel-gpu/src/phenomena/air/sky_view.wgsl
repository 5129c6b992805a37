// The rays of a station's sky view, over azimuth from each light and elevation: what the table is made of.

//#include "phenomena/air/sky_view_table.wgsl"

// Layers of a light: radiance without the aerosols' peaks; the peaks over their mean phase function. 1/sr.
@group(2) @binding(0) var rays_out: texture_storage_2d_array<rgba32float, write>;

// z: the light.
@compute @workgroup_size(8, 8)
fn march_sky_view(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(rays_out);
    if any(id.xy >= size) {
        return;
    }
    let ray = sky_view_ray(id.xy, size, id.z);
    let start = enter(view.altitude_m, ray.direction.z, ray.sine, view.lights[id.z].mu_s, ray.nu, ray.theta);
    let below = i32(id.y) < rows_below(i32(size.y));
    let horizon = asin(horizon_cosine(airs[body].bottom_radius_m, view.altitude_m));
    let row = elevation_texel(asin(ray.direction.z), horizon, below, cell_rows());
    // Rays to the ground are short, or seen through thin air from above.
    let steps = select(frame.steps, max(frame.steps / 2u, 4u), below);
    let air = march_air(start, row, steps, 1e30);
    let layer = sky_view_layer(id.z);
    textureStore(rays_out, id.xy, layer, air.radiance);
    if aerosols > 0u {
        let coordinate = theta_coordinate_of(ray.theta);
        let peaks = peaks_of(air.weights, air.depths, coordinate, start.nu);
        textureStore(rays_out, id.xy, layer + 1u, peaks / mean_phase(coordinate));
    }
}

// The aerosols' peaks from a ray's weights and mean depths, at an angle to the light.
fn peaks_of(weights: array<vec4f, 8>, depths: vec2f, coordinate: f32, nu: f32) -> vec4f {
    var sum = vec4f(0.0);
    for (var a = 0u; a < aerosols; a++) {
        let phase = aerosol_phase(airs[body].aerosols[a].layer, coordinate);
        sum += weights[2u * a] * peak_scaled(a, phase, coordinate, nu, depths.x);
        sum += weights[2u * a + 1u] * peak_unscaled(a, phase, coordinate, depths.y);
    }
    return sum;
}
