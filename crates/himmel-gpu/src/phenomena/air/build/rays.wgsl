// Follows the rays of the moment table: what the air along each weighs. Twin of `Path::new` in himmel_air::moments.

//#include "phenomena/air/build/build.wgsl"

// Gauss nodes (x, weight) on 0..1: up, down, deep up, deep down.
@group(2) @binding(0) var<storage, read> nodes: array<vec2f>;
@group(2) @binding(1) var<storage, read_write> rays: array<vec4f>;
@group(2) @binding(2) var<storage, read_write> cumulative: array<vec4f>;

struct Fine {
    radius: f32,
    h0: f32,
    mu: f32,
    end: f32,
    nearest: f32,
    before: f32,
    after: f32,
}

fn fine_edge(p: Fine, i: u32) -> f32 {
    let s = -p.before + (p.before + p.after) * f32(i) / f32(build.fine_cells);
    return clamp(p.nearest + s * abs(s), 0.0, p.end);
}

struct Stretch {
    from_t: f32,
    dt: f32,
    middle: f32,
    w_0: vec4f,
    w_1: vec4f,
    w_2: vec4f,
    passed: vec4f,
}

fn stretch_of(p: Fine, i: u32, through: vec4f) -> Stretch {
    var s: Stretch;
    s.from_t = fine_edge(p, i);
    s.dt = fine_edge(p, i + 1u) - s.from_t;
    s.middle = s.from_t + 0.5 * s.dt;
    let local = scaled_air(altitude_coordinate(altitude_along(p.radius, p.h0, p.mu, s.middle)));
    let depth = local.extinction * s.dt;
    s.passed = exp(-depth);
    let closed = s.dt * (vec4f(1.0) - s.passed) / max(depth, vec4f(1e-30));
    let length = through * select(closed, s.dt * (vec4f(1.0) - 0.5 * depth), depth < vec4f(1e-3));
    s.w_0 = length * local.scaled_0;
    s.w_1 = length * local.scaled_1;
    s.w_2 = length * local.scaled_2;
    return s;
}

@compute @workgroup_size(16)
fn follow_rays(@builtin(global_invocation_id) id: vec3u) {
    body = build.body;
    let ray = id.x;
    if ray >= rays_per_row() || id.y >= build.row_count {
        return;
    }
    let row = build.first_row + id.y;
    var p: Fine;
    p.radius = airs[body].bottom_radius_m;
    let top = airs[body].top_altitude_m;
    p.h0 = row_altitude(row);
    let horizon = horizon_cosine(p.radius, p.h0);
    let node = nodes[ray];
    let day = build.up + build.down;
    let is_up = ray < build.up || (ray >= day && ray < day + build.deep_up);
    let reach = select(-1.0 - horizon, 1.0 - horizon, is_up);
    p.mu = horizon + reach * node.x * node.x;
    let weight = abs(reach) * 2.0 * node.x * node.y;
    var hit = -1.0;
    if !is_up {
        // Below the horizon by construction; f32 may not see it for the flattest.
        hit = ground_distance(p.radius, p.h0, min(p.mu, horizon - 1e-7));
    }
    p.end = select(top_distance(p.radius, top, p.h0, p.mu), hit, hit >= 0.0);
    let r0 = p.radius + p.h0;
    p.nearest = clamp(-r0 * p.mu, 0.0, p.end);
    p.before = sqrt(p.nearest);
    p.after = sqrt(p.end - p.nearest);

    // How much of each wavelength's scattered light the ray holds …
    var through = vec4f(1.0);
    var total = vec4f(0.0);
    for (var i = 0u; i < build.fine_cells; i++) {
        let s = stretch_of(p, i, through);
        total += s.w_0;
        through *= s.passed;
    }
    let base = ray_base(row, ray);
    rays[base] = vec4f(p.mu, sqrt(max(1.0 - p.mu * p.mu, 0.0)), weight, p.end);
    rays[base + 1u] = through;
    rays[base + 2u] = vec4f(select(0.0, 1.0, hit >= 0.0), 0.0, 0.0, 0.0);
    let inverse = select(vec4f(0.0), vec4f(1.0) / total, total > vec4f(1e-30));
    let all = max(dot(total * inverse, vec4f(1.0)), 1e-30);
    // … the sums of its powers …
    through = vec4f(1.0);
    var half_total = 1e-30;
    var quarter_total = 1e-30;
    for (var i = 0u; i < build.fine_cells; i++) {
        let s = stretch_of(p, i, through);
        through *= s.passed;
        let per_m = max(dot(s.w_0 * inverse, vec4f(1.0)), 0.0) / max(s.dt, 1e-30);
        half_total += select(0.0, sqrt(per_m) * s.dt, s.dt > 0.0);
        quarter_total += select(0.0, sqrt(sqrt(per_m)) * s.dt, s.dt > 0.0);
    }
    // … and its cells: equal steps of ½ CDF(w) + ½ CDF(√w), and for the cumulative table of CDF(w^¼).
    through = vec4f(1.0);
    var w_0 = vec4f(0.0);
    var w_1 = vec4f(0.0);
    var w_2 = vec4f(0.0);
    var turned = 0.0;
    var important = 0.0;
    var flat = 0.0;
    var cell = 1u;
    var entry = 0u;
    let out = cumulative_base(row, ray);
    // What the last finished cell left off at.
    var from_w_0 = vec4f(0.0);
    var from_w_1 = vec4f(0.0);
    var from_w_2 = vec4f(0.0);
    var from_turned = 0.0;
    var from_t = 0.0;
    for (var i = 0u; i < build.fine_cells; i++) {
        let s = stretch_of(p, i, through);
        through *= s.passed;
        let amount = max(dot(s.w_0 * inverse, vec4f(1.0)), 0.0);
        let per_m = amount / max(s.dt, 1e-30);
        let is_last = i + 1u == build.fine_cells;
        let here_turned = dot(s.w_0, vec4f(1.0)) * s.middle;
        var next = important + 0.5 * amount / all;
        next += select(0.0, 0.5 * sqrt(per_m) * s.dt / half_total, s.dt > 0.0);
        // The sums end at 1 but for rounding.
        next = select(next, 1.0, is_last);
        while cell <= build.cells && f32(cell) / f32(build.cells) <= next {
            let x = clamp((f32(cell) / f32(build.cells) - important) / max(next - important, 1e-20), 0.0, 1.0);
            let to_w_0 = w_0 + x * s.w_0;
            let to_w_1 = w_1 + x * s.w_1;
            let to_w_2 = w_2 + x * s.w_2;
            let to_turned = turned + x * here_turned;
            let to_t = s.from_t + x * s.dt;
            let sum = dot(to_w_0 - from_w_0, vec4f(1.0));
            let centre = clamp((to_turned - from_turned) / max(sum, 1e-30), from_t, to_t);
            let t = select(0.5 * (from_t + to_t), centre, sum > 1e-30);
            let h = altitude_along(p.radius, p.h0, p.mu, t);
            let r = p.radius + h;
            let at = base + HEAD + CELL * (cell - 1u);
            rays[at] = to_w_0 - from_w_0;
            rays[at + 1u] = to_w_1 - from_w_1;
            rays[at + 2u] = to_w_2 - from_w_2;
            let coordinate = altitude_coordinate(h);
            rays[at + 3u] = vec4f(t, r, clamp((r0 * p.mu + t) / r, -1.0, 1.0), coordinate * f32(build.rows - 1u));
            rays[at + 4u] = density_row(SUNS_ROW, coordinate);
            from_w_0 = to_w_0;
            from_w_1 = to_w_1;
            from_w_2 = to_w_2;
            from_turned = to_turned;
            from_t = to_t;
            cell += 1u;
        }
        important = next;
        var flat_next = flat + select(0.0, sqrt(sqrt(per_m)) * s.dt / quarter_total, s.dt > 0.0);
        flat_next = select(flat_next, 1.0, is_last);
        while entry <= build.cumulative_cells && f32(entry) / f32(build.cumulative_cells) <= flat_next {
            let share = f32(entry) / f32(build.cumulative_cells);
            let x = clamp((share - flat) / max(flat_next - flat, 1e-20), 0.0, 1.0);
            let at = out + 4u * entry;
            cumulative[at] = w_0 + x * s.w_0;
            cumulative[at + 1u] = w_1 + x * s.w_1;
            cumulative[at + 2u] = w_2 + x * s.w_2;
            cumulative[at + 3u] = vec4f(s.from_t + x * s.dt, 0.0, 0.0, 0.0);
            entry += 1u;
        }
        flat = flat_next;
        w_0 += s.w_0;
        w_1 += s.w_1;
        w_2 += s.w_2;
        turned += here_turned;
    }
}
