// Radiance along single rays, as `himmel radiance --solver gpu` asks: what a pixel that marches its ray shows.

//#include "frame/frame.wgsl"
//#include "phenomena/air/cells.wgsl"

struct Query {
    altitude_m: f32,
    mu: f32,
    // Sine of the ray's zenith angle, from the angle itself.
    sine: f32,
    mu_s: f32,
    nu: f32,
    theta: f32,
    padding_0: f32,
    padding_1: f32,
}

@group(2) @binding(1) var<storage, read> queries: array<Query>;
@group(2) @binding(2) var<storage, read_write> answers: array<vec4f>;

fn query_ray(query: Query) -> AirRay {
    return enter(query.altitude_m, query.mu, query.sine, query.mu_s, query.nu, query.theta);
}

// Each query has a row of the cell table to itself.
@compute @workgroup_size(64)
fn place_queries(@builtin(global_invocation_id) id: vec3u) {
    let rows = textureDimensions(cells_out).y - 1u;
    if id.x >= min(rows, arrayLength(&queries)) {
        return;
    }
    let ray = query_ray(queries[id.x]);
    if ray.misses {
        return;
    }
    fill_row(id.x, 0u, ray.altitude_m, ray.mu, queries[id.x].altitude_m > airs[body].top_altitude_m);
}

@compute @workgroup_size(64)
fn answer_queries(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let ray = query_ray(queries[id.x]);
    let air = march_air(ray, f32(id.x), frame.steps, 1e30);
    answers[2u * id.x] = air.radiance;
    // Towards space; nothing where the ground is in the way.
    var through = vec4f(1.0);
    if !ray.misses {
        through = select(transmittance_to_space(ray.altitude_m, ray.mu), vec4f(0.0), air.hits_ground);
    }
    answers[2u * id.x + 1u] = through;
}
