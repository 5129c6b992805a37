// Order k + 1 of the moment table from the moments of order k and the irradiance that it brings to the ground.
// Twin of `Scene::next` in himmel_air::moments.

//#include "phenomena/air/build/fill.wgsl"

// The moments of order k at a row coordinate.
fn stored_at(row: f32, column: vec2f) -> Moments {
    let p = column.x * f32(build.columns - 1u);
    let i = min(u32(row), build.rows - 2u);
    let j = min(u32(p), build.columns - 2u);
    let y = row - f32(i);
    let x = p - f32(j);
    let a = (i * build.columns + j) * SEVEN;
    let c = a + build.columns * SEVEN;
    var six: array<vec4f, 6>;
    for (var m = 0u; m < 6u; m++) {
        let low = mix(stored[a + m], stored[a + SEVEN + m], x);
        let high = mix(stored[c + m], stored[c + SEVEN + m], x);
        six[m] = mix(low, high, y);
    }
    let g = lit(exp(six[0]) * column.y);
    return Moments(g, g * six[1], g * six[2], g * six[3], g * six[4], g * six[5]);
}

fn stored_ground(mu_s: f32) -> vec4f {
    let column = suns_coordinate(density_row(SUNS_ROW, 0.0), mu_s);
    let p = column.x * f32(build.columns - 1u);
    let j = min(u32(p), build.columns - 2u);
    let log_e = mix(stored[j * SEVEN + 6u], stored[(j + 1u) * SEVEN + 6u], p - f32(j));
    return lit(exp(log_e) * column.y);
}

@compute @workgroup_size(64)
fn fill_next(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    body = build.body;
    if converged() {
        return;
    }
    let row = build.first_row + group.y;
    let h0 = row_altitude(row);
    let r0 = airs[body].bottom_radius_m + h0;
    let mu_s = column_mu_s(group.x, density_row(SUNS_ROW, altitude_coordinate(h0)));
    let directions = directions_of(mu_s);
    for (var i = lane; i < directions.y * directions.z; i += WIDTH) {
        let look = look_of(row, directions, i, h0, mu_s);
        var light = vec4f(0.0);
        if look.hits_ground {
            light = look.through * airs[body].ground_albedo / PI * stored_ground(look.ground_mu_s);
        }
        for (var c = 0u; c < build.cells; c++) {
            let at = look.base + HEAD + CELL * c;
            let place = rays[at + 3u];
            let mu_s_there = clamp((r0 * mu_s + place.x * look.nu) / place.y, -1.0, 1.0);
            let around = stored_at(place.w, suns_coordinate(rays[at + 4u], mu_s_there));
            let axes = frame_of_sun(place.z, mu_s_there, look.nu);
            light += scattered(around, rays[at], rays[at + 1u], rays[at + 2u], place.z, axes);
        }
        add_light(light, look.weight, look.x, look.mu);
    }
    write_texel(lane, row, group.x);
}
