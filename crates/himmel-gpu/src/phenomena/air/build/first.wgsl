// Order 1 of the moment table: sunlight scattered once by the scaled medium, or reflected once by the ground. Only the
// lit part of each ray is sampled; the planet's shadow cylinder cuts it. Twin of `Scene::first` in himmel_air::moments.

//#include "phenomena/air/build/fill.wgsl"

// Distance and weights of the rays up to the entries of their cumulative tables.
@group(2) @binding(4) var<storage, read> cumulative: array<vec4f>;

struct UpTo {
    w_0: vec4f,
    w_1: vec4f,
    w_2: vec4f,
    t: f32,
}

fn up_to(table: u32, coordinate: f32) -> UpTo {
    let i = min(u32(coordinate), build.cumulative_cells - 1u);
    let x = coordinate - f32(i);
    let at = table + 4u * i;
    return UpTo(
        mix(cumulative[at], cumulative[at + 4u], x),
        mix(cumulative[at + 1u], cumulative[at + 5u], x),
        mix(cumulative[at + 2u], cumulative[at + 6u], x),
        mix(cumulative[at + 3u].x, cumulative[at + 7u].x, x),
    );
}

// Coordinate in the cumulative table of a distance.
fn coordinate_of(table: u32, t: f32) -> f32 {
    var low = 0u;
    var high = build.cumulative_cells;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if cumulative[table + 4u * middle + 3u].x <= t {
            low = middle;
        } else {
            high = middle;
        }
    }
    let a = cumulative[table + 4u * low + 3u].x;
    let b = cumulative[table + 4u * high + 3u].x;
    return f32(low) + clamp((t - a) / max(b - a, 1e-6), 0.0, 1.0);
}

fn lit_light(look: Look, table: u32, h0: f32, mu_s: f32, from_c: f32, to_c: f32, samples: u32) -> vec4f {
    var light = vec4f(0.0);
    if samples == 0u {
        return light;
    }
    let radius = airs[body].bottom_radius_m;
    let r0 = radius + h0;
    let second = 0.5 * (3.0 * look.nu * look.nu - 1.0);
    let step = (to_c - from_c) / f32(samples);
    var before = up_to(table, from_c);
    for (var i = 0u; i < samples; i++) {
        let t = up_to(table, from_c + (f32(i) + 0.5) * step).t;
        let after = up_to(table, from_c + f32(i + 1u) * step);
        let h = altitude_along(radius, h0, look.mu, t);
        let sun = scaled_to_space(h, (r0 * mu_s + t * look.nu) / (radius + h));
        let scattered_once = (after.w_0 - before.w_0) + 3.0 * look.nu * (after.w_1 - before.w_1)
            + 5.0 * second * (after.w_2 - before.w_2);
        light += sun * scattered_once / (4.0 * PI);
        before = after;
    }
    return light;
}

fn first_order(look: Look, row: u32, h0: f32, mu_s: f32) -> vec4f {
    var light = vec4f(0.0);
    if look.hits_ground && look.ground_mu_s > 0.0 {
        let irradiance = scaled_to_space(0.0, look.ground_mu_s) * look.ground_mu_s;
        light = look.through * airs[body].ground_albedo / PI * irradiance;
    }
    let table = cumulative_base(row, look.ray);
    let last = f32(build.cumulative_cells);
    let radius = airs[body].bottom_radius_m;
    let dark = min(shadow_interval(radius, h0, look.mu, mu_s, look.nu), vec2f(look.end));
    var near = last;
    var far = last;
    var in_near = build.lit_samples;
    if dark.y > dark.x {
        near = select(0.0, coordinate_of(table, dark.x), dark.x > 0.0);
        far = select(last, coordinate_of(table, dark.y), dark.y < look.end);
        let lit_amount = near + last - far;
        let least = min(build.lit_samples, 3u);
        let wanted = u32(round(f32(build.lit_samples) * near / max(lit_amount, 1e-6)));
        in_near = select(0u, build.lit_samples, near > 0.0);
        if near > 0.0 && far < last {
            in_near = clamp(wanted, least, build.lit_samples - least);
        }
        if lit_amount <= 0.0 {
            return light;
        }
    }
    // Before the shadow and behind it.
    for (var part = 0u; part < 2u; part++) {
        let begin = select(0.0, far, part == 1u);
        let finish = select(near, last, part == 1u);
        let samples = select(in_near, build.lit_samples - in_near, part == 1u);
        light += lit_light(look, table, h0, mu_s, begin, finish, samples);
    }
    return light;
}

@compute @workgroup_size(64)
fn fill_first(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    body = build.body;
    let row = build.first_row + group.y;
    let h0 = row_altitude(row);
    let mu_s = column_mu_s(group.x, density_row(SUNS_ROW, altitude_coordinate(h0)));
    let directions = directions_of(mu_s);
    for (var i = lane; i < directions.y * directions.z; i += WIDTH) {
        let look = look_of(row, directions, i, h0, mu_s);
        add_light(first_order(look, row, h0, mu_s), look.weight, look.x, look.mu);
    }
    write_texel(lane, row, group.x);
}
