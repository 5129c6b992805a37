// The sky view of a station: what its rays see, over azimuth from each light and elevation, for pixels to look up.

//#include "phenomena/air/sky_view_table.wgsl"

@group(2) @binding(0) var sky_view_out: texture_storage_2d_array<rgba16float, write>;

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
    let azimuth = 2.0 * asin(f32(id.x) / f32(size.x - 1u));
    let mu_s = view.lights[id.z].mu_s;
    let sine_s = sqrt(max(1.0 - mu_s * mu_s, 0.0));
    // From the light's own frame: the chord keeps the digits of small angles.
    let ray = vec3f(sine * cos(azimuth), sine * sin(azimuth), mu);
    let sun = vec3f(sine_s, 0.0, mu_s);
    let theta = angle_between(ray, sun);
    let start = enter(view.altitude_m, mu, sine, mu_s, clamp(dot(ray, sun), -1.0, 1.0), theta);
    let row = elevation_texel(
        asin(mu), asin(horizon_cosine(radius, view.altitude_m)), i32(id.y) < rows_below(i32(size.y)),
        cell_rows());
    // Rays to the ground are short, or seen through thin air from above.
    let steps = select(frame.steps, max(frame.steps / 2u, 4u), i32(id.y) < rows_below(i32(size.y)));
    let air = march_air(start, row, steps, 1e30);
    let layer = sky_view_layer(id.z);
    let scale = sky_view_scale(id.z);
    if aerosols == 0u {
        store(id.xy, layer, scale * air.radiance);
        return;
    }
    let coordinate = theta_coordinate_of(theta);
    let peaks = peaks_of(air.weights, air.depths, coordinate, start.nu);
    let share = table_share(theta);
    store(id.xy, layer, scale * (air.radiance + share * peaks));
    store(id.xy, layer + 1u, scale * (1.0 - share) * peaks / mean_phase(coordinate));
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

// 65504 is the largest half float.
fn store(texel: vec2u, layer: u32, value: vec4f) {
    textureStore(sky_view_out, texel, layer, clamp(value, vec4f(-65504.0), vec4f(65504.0)));
}
