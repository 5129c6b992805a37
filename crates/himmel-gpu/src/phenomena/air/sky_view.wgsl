// The sky view of a station: what its rays see, over azimuth from each light and elevation, for pixels to look up.

//#include "phenomena/air/sky_view_table.wgsl"

@group(2) @binding(0) var sky_view_out: texture_storage_2d_array<rgba32float, write>;

// z: the light.
@compute @workgroup_size(8, 8)
fn fill_sky_view(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(sky_view_out);
    if any(id.xy >= size) {
        return;
    }
    let radius = airs[body].bottom_radius_m;
    let mu = texel_mu(i32(id.y), i32(size.y), view.altitude_m);
    let sine = sqrt(max(1.0 - mu * mu, 0.0));
    let azimuth = PI * f32(id.x) / f32(size.x - 1u);
    let mu_s = view.lights[id.z].mu_s;
    let sine_s = sqrt(max(1.0 - mu_s * mu_s, 0.0));
    // From the light's own frame: the chord keeps the digits of small angles.
    let ray = vec3f(sine * cos(azimuth), sine * sin(azimuth), mu);
    let sun = vec3f(sine_s, 0.0, mu_s);
    let theta = angle_between(ray, sun);
    let start = enter(view.altitude_m, mu, sine, mu_s, clamp(dot(ray, sun), -1.0, 1.0), theta);
    let row = elevation_texel(
        asin(mu), asin(horizon_cosine(radius, view.altitude_m)), i32(id.y) < rows_below(i32(size.y)),
        i32(textureDimensions(cell_table).y));
    // Rays to the ground are short, or seen through thin air from above.
    let steps = select(frame.steps, max(frame.steps / 2u, 4u), i32(id.y) < rows_below(i32(size.y)));
    let air = march_air(start, row, steps, 1e30);
    let layer = sky_view_layer(id.z);
    let peaks = peaks_of(air.weights, air.depths, theta, start.nu);
    textureStore(sky_view_out, id.xy, layer, air.radiance + table_share(theta) * peaks);
    textureStore(sky_view_out, id.xy, layer + 1u, vec4f(air.depths, 0.0, 0.0));
    for (var a = 0u; a < aerosols; a++) {
        textureStore(sky_view_out, id.xy, layer + 2u + 2u * a, air.weights[2u * a]);
        textureStore(sky_view_out, id.xy, layer + 3u + 2u * a, air.weights[2u * a + 1u]);
    }
}
