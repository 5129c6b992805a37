// The sky view of a station, for pixels to look up: twice as fine as its rays, interpolated between them: by cubics, below
// the horizon from row to row by lines.

//#include "phenomena/air/sky_view_table.wgsl"

@group(2) @binding(0) var rays: texture_2d_array<f32>;
@group(2) @binding(1) var sky_view_out: texture_storage_2d_array<rgba16float, write>;

// Four rays in a row and what each weighs: Lagrange's polynomial through them.
struct Stencil {
    first: i32,
    weights: vec4f,
}

// At a place among the rays from..=last; at the ends the stencil is moved inwards.
fn stencil(place: f32, from_ray: i32, last: i32) -> Stencil {
    let first = clamp(i32(floor(place)) - 1, from_ray, last - 3);
    let t = place - f32(first);
    let a = t;
    let b = t - 1.0;
    let c = t - 2.0;
    let d = t - 3.0;
    return Stencil(first, vec4f(-b * c * d / 6.0, 0.5 * a * c * d, -0.5 * a * b * d, a * b * c / 6.0));
}

// The same with a straight line: it does not overshoot.
fn line_stencil(place: f32, from_ray: i32, last: i32) -> Stencil {
    let first = clamp(i32(floor(place)), from_ray, last - 1);
    let t = place - f32(first);
    let start = min(first, last - 3);
    var weights = vec4f(0.0);
    weights[first - start] = 1.0 - t;
    weights[first - start + 1] = t;
    return Stencil(start, weights);
}

fn between_rays(across: Stencil, up: Stencil, layer: u32) -> vec4f {
    var sum = vec4f(0.0);
    for (var y = 0; y < 4; y++) {
        var row = vec4f(0.0);
        for (var x = 0; x < 4; x++) {
            row += across.weights[x] * textureLoad(rays, vec2i(across.first + x, up.first + y), layer, 0);
        }
        sum += up.weights[y] * row;
    }
    return sum;
}

// z: the light.
@compute @workgroup_size(8, 8)
fn refine_sky_view(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(sky_view_out);
    if any(id.xy >= size) {
        return;
    }
    let coarse = vec2i(textureDimensions(rays));
    let below = i32(id.y) < rows_below(i32(size.y));
    let fine_lower = rows_below(i32(size.y));
    let lower = rows_below(coarse.y);
    // The same share of the rows on this side of the horizon.
    let last_fine = f32(select(i32(size.y) - fine_lower, fine_lower, below) - 1);
    let last_ray = f32(select(coarse.y - lower, lower, below) - 1);
    let in_side = f32(i32(id.y) - select(fine_lower, 0, below)) / last_fine * last_ray;
    var up = stencil(in_side + f32(lower), lower, coarse.y - 1);
    if below {
        // The nearest ground falls off the horizon too steeply for cubics.
        up = line_stencil(in_side, 0, lower - 1);
    }
    let across = stencil(f32(id.x) / f32(size.x - 1u) * f32(coarse.x - 1), 0, coarse.x - 1);

    let layer = sky_view_layer(id.z);
    let scale = sky_view_scale(id.z);
    var radiance = between_rays(across, up, layer);
    if aerosols > 0u {
        let peaks = between_rays(across, up, layer + 1u);
        let theta = sky_view_ray(id.xy, size, id.z).theta;
        let share = table_share(theta);
        radiance += share * peaks * mean_phase(theta_coordinate_of(theta));
        store(id.xy, layer + 1u, scale * (1.0 - share) * peaks);
    }
    store(id.xy, layer, scale * radiance);
}

// 65504 is the largest half float.
fn store(texel: vec2u, layer: u32, value: vec4f) {
    textureStore(sky_view_out, texel, layer, clamp(value, vec4f(-65504.0), vec4f(65504.0)));
}
