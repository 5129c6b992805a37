// The night's glow over a view, on a grid: it is smoother than pixels are.

//#include "sky.wgsl"

@group(2) @binding(0) var grid_out: texture_storage_2d_array<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn fill_night_grid(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(grid_out);
    if any(id.xy >= size) {
        return;
    }
    let ndc = vec2f(id.xy) / vec2f(size - 1u) * 2.0 - 1.0;
    let ray = look_direction(view.tile.xy + view.tile.zw * ndc);
    let mu = dot(ray, view.up);
    let sine = length(cross(ray, view.up));
    let below = mu < view.horizon_mu;
    let glow = rec709_of(night_radiance(ray, mu, sine, below, true, 1.0));
    let before = rec709_of(night_radiance(ray, mu, sine, below, true, 0.0));
    let behind = clamp(1.0 - before.g / max(glow.g, 1e-20), 0.0, 1.0);
    textureStore(grid_out, id.xy, view.night_layer, vec4f(glow / view.night_unit, behind));
}
