// Fills the cell table of a station: where the cells of its rays lie. Twin of `edges` in himmel_air::moments::frame.

//#include "frame/frame.wgsl"
//#include "phenomena/air/march.wgsl"

@group(2) @binding(0) var cells_out: texture_storage_2d_array<rg32float, write>;

// Stretches that are weighed.
const PLACING: u32 = 64u;
// Share of the cells that follows what each stretch scatters; the rest lies evenly in √t (from space: in t).
const BY_LIGHT: f32 = 0.3;

struct Placing {
    radius: f32,
    altitude_m: f32,
    mu: f32,
    end: f32,
    nearest: f32,
    before: f32,
    after: f32,
}

// Distance of the edge before stretch i.
fn placing_edge(p: Placing, i: u32) -> f32 {
    let s = -p.before + (p.before + p.after) * f32(i) / f32(PLACING);
    return clamp(p.nearest + s * abs(s), 0.0, p.end);
}

fn fill_row(out_row: u32, out_layer: u32, altitude_m: f32, mu: f32, from_space: bool) {
    var p: Placing;
    p.radius = airs[body].bottom_radius_m;
    p.altitude_m = altitude_m;
    p.mu = mu;
    p.end = ground_distance(p.radius, altitude_m, mu);
    if p.end < 0.0 {
        p.end = top_distance(p.radius, airs[body].top_altitude_m, altitude_m, mu);
    }
    p.nearest = clamp(-(p.radius + altitude_m) * mu, 0.0, p.end);
    p.before = sqrt(p.nearest);
    p.after = sqrt(p.end - p.nearest);

    // What each wavelength scatters in all …
    var through = vec4f(1.0);
    var total = vec4f(0.0);
    for (var i = 0u; i < PLACING; i++) {
        total += placed(p, i, &through);
    }
    let inverse = select(vec4f(0.0), vec4f(1.0) / total, total > vec4f(1e-30));
    let lit_total = dot(total * inverse, vec4f(1.0));
    // … the flattened sum …
    through = vec4f(1.0);
    var flat_total = 0.0;
    for (var i = 0u; i < PLACING; i++) {
        let share = dot(placed(p, i, &through) * inverse, vec4f(1.0));
        let dt = placing_edge(p, i + 1u) - placing_edge(p, i);
        flat_total += flattened(share, dt);
    }
    // … and where both reach their shares.
    through = vec4f(1.0);
    let columns = textureDimensions(cells_out).x;
    let by_light = select(0.0, BY_LIGHT, lit_total > 0.0);
    var sum = 0.0;
    var flat_sum = 0.0;
    var column = 0u;
    var flat_column = 0u;
    var even_places: array<f32, 65>;
    var flat_places: array<f32, 65>;
    for (var i = 0u; i < PLACING; i++) {
        let from_t = placing_edge(p, i);
        let to_t = placing_edge(p, i + 1u);
        let share = dot(placed(p, i, &through) * inverse, vec4f(1.0));
        let spread = select(sqrt(to_t / p.end) - sqrt(from_t / p.end), 1.0 / f32(PLACING), from_space);
        let next = sum + by_light * share / max(lit_total, 1e-30) + (1.0 - by_light) * spread;
        while column < columns && f32(column) / f32(columns - 1u) <= next {
            let x = clamp((f32(column) / f32(columns - 1u) - sum) / max(next - sum, 1e-12), 0.0, 1.0);
            even_places[column] = mix(from_t, to_t, x) / p.end;
            column += 1u;
        }
        sum = next;
        let flat_next = flat_sum + select(1.0 / f32(PLACING), flattened(share, to_t - from_t) / flat_total, flat_total > 0.0);
        while flat_column < columns && f32(flat_column) / f32(columns - 1u) <= flat_next {
            let x = clamp((f32(flat_column) / f32(columns - 1u) - flat_sum) / max(flat_next - flat_sum, 1e-12), 0.0, 1.0);
            flat_places[flat_column] = mix(from_t, to_t, x) / p.end;
            flat_column += 1u;
        }
        flat_sum = flat_next;
    }
    // The sums end at 1 but for rounding.
    for (var i = column; i < columns; i++) {
        even_places[i] = 1.0;
    }
    for (var i = flat_column; i < columns; i++) {
        flat_places[i] = 1.0;
    }
    for (var i = 0u; i < columns; i++) {
        textureStore(cells_out, vec2u(i, out_row), out_layer, vec4f(even_places[i], flat_places[i], 0.0, 0.0));
    }
}

// What a stretch scatters towards the viewer, per wavelength; `through` goes on behind it.
fn placed(p: Placing, i: u32, through: ptr<function, vec4f>) -> vec4f {
    let from_t = placing_edge(p, i);
    let dt = placing_edge(p, i + 1u) - from_t;
    let local = scaled_air(altitude_coordinate(altitude_along(p.radius, p.altitude_m, p.mu, from_t + 0.5 * dt)));
    let passed = exp(-local.extinction * dt);
    let light = *through * local.scaled_0 * dt * 0.5 * (vec4f(1.0) + passed);
    *through *= passed;
    return light;
}

fn flattened(share: f32, dt: f32) -> f32 {
    return select(0.0, pow(share / max(dt, 1e-30), 0.25) * dt, share > 0.0 && dt > 0.0);
}

// One invocation a row; the last row holds the scales of the sky view, a column for each light.
@compute @workgroup_size(8)
fn fill_cells(@builtin(global_invocation_id) id: vec3u) {
    if far_airs {
        body = view.body;
    }
    let rows = textureDimensions(cells_out).y - 1u;
    let altitude = min(view.altitude_m, airs[body].top_altitude_m);
    if id.x < rows {
        let mu = texel_mu(i32(id.x), i32(rows), altitude);
        fill_row(id.x, view.station, altitude, mu, view.altitude_m > airs[body].top_altitude_m);
    }
    if id.x < MOST_LIGHTS {
        // What the ground would reflect: it falls with the sky's light, which keeps half floats in their range.
        let light = ground_irradiance(view.lights[id.x].mu_s);
        let largest = max(max(light.x, light.y), max(light.z, light.w));
        // 1e-12: a sky that nobody sees.
        let scale = exp2(round(-log2(max(largest, 1e-12))));
        textureStore(cells_out, vec2u(id.x, rows), view.station, vec4f(scale, 0.0, 0.0, 0.0));
    }
}
