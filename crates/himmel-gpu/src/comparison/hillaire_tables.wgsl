// The four tables of [hillaire2020], one invocation for each texel (for each column of the froxels).

//#include "comparison/hillaire.wgsl"

@group(0) @binding(7) var written: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var written_scattered: texture_storage_3d<rgba16float, write>;
@group(0) @binding(9) var written_transmittance: texture_storage_3d<rgba16float, write>;

const TRANSMITTANCE_STEPS: u32 = 40u;
// 8 zenith angles × 8 azimuths are 64 directions; the light is the same on both sides of the Sun, so four are summed.
const ZENITHS: u32 = 8u;
const AZIMUTHS: u32 = 4u;
const DIRECTION_STEPS: u32 = 20u;
const SKY_VIEW_STEPS: u32 = 30u;
const FROXELS: u32 = 32u;
const FROXEL_STEPS: u32 = 2u;
const FROXEL_LENGTH_M: f32 = 1000.0;

const NO_PHASE: PhaseValues = PhaseValues(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));

@compute @workgroup_size(8, 8)
fn transmittance_pass(@builtin(global_invocation_id) id: vec3u) {
    if any(vec2f(id.xy) >= TRANSMITTANCE_SIZE) {
        return;
    }
    // Inverse of depth_table_uv.
    let radius = hillaire.bottom_radius_m;
    let top = hillaire.top_altitude_m;
    let uv = node_coordinate(id.xy, TRANSMITTANCE_SIZE);
    let rho_top = sqrt(excess(radius, top));
    let rho = uv.y * rho_top;
    let altitude = rho * rho / (radius + sqrt(radius * radius + rho * rho));
    let nearest = top - altitude;
    let d = nearest + uv.x * (rho + rho_top - nearest);
    let gap = (top - altitude) * (2.0 * radius + top + altitude);
    var mu = 1.0;
    if d > 0.0 {
        mu = (gap - d * d) / (2.0 * (radius + altitude) * d);
    }
    // The last column grazes the ground: rounding must not make it end there.
    mu = clamp(mu, horizon_cosine(radius, altitude), 1.0);
    let dt = top_distance(radius, top, altitude, mu) / f32(TRANSMITTANCE_STEPS);
    var depth = vec4f(0.0);
    for (var i = 0u; i < TRANSMITTANCE_STEPS; i++) {
        let h = altitude_along(radius, altitude, mu, dt * (f32(i) + 0.5));
        depth += local_air(h, NO_PHASE).extinction * dt;
    }
    textureStore(written, id.xy, exp(-depth));
}

@compute @workgroup_size(8, 8)
fn multiple_pass(@builtin(global_invocation_id) id: vec3u) {
    if any(vec2f(id.xy) >= MULTIPLE_SIZE) {
        return;
    }
    let radius = hillaire.bottom_radius_m;
    let uv = node_coordinate(id.xy, MULTIPLE_SIZE);
    let altitude = uv.y * hillaire.top_altitude_m;
    let r = radius + altitude;
    let mu_s = 2.0 * uv.x - 1.0;
    let sin_s = sqrt(max(1.0 - mu_s * mu_s, 0.0));
    // L_2nd and f_ms, sums over directions.
    var second = vec4f(0.0);
    var again = vec4f(0.0);
    for (var j = 0u; j < ZENITHS; j++) {
        let mu = 1.0 - 2.0 * (f32(j) + 0.5) / f32(ZENITHS);
        let across = sqrt(1.0 - mu * mu) * sin_s;
        // ν at the four azimuths: cos 22.5° and cos 67.5° on either side.
        let nu = mu * mu_s + across * vec4f(0.92387953, 0.38268343, -0.38268343, -0.92387953);
        let ground = ground_distance(radius, altitude, mu);
        let end = select(top_distance(radius, hillaire.top_altitude_m, altitude, mu), ground, ground >= 0.0);
        let dt = end / f32(DIRECTION_STEPS);
        var transmittance = vec4f(1.0);
        // What the air weighs is the same at every azimuth; only the Sun is not.
        for (var i = 0u; i < DIRECTION_STEPS; i++) {
            let t = dt * (f32(i) + 0.5);
            let h = altitude_along(radius, altitude, mu, t);
            let here = local_air(h, NO_PHASE);
            let through = exp(-here.extinction * dt);
            let weight = transmittance * here.scattering * effective_length(here.extinction, through, dt);
            let sun = clamp((r * mu_s + t * nu) / (radius + h), vec4f(-1.0), vec4f(1.0));
            second += weight * (sun_transmittance(h, sun.x) + sun_transmittance(h, sun.y)
                + sun_transmittance(h, sun.z) + sun_transmittance(h, sun.w)) / (4.0 * PI);
            again += weight;
            transmittance *= through;
        }
        if ground >= 0.0 {
            let sun = clamp((r * mu_s + ground * nu) / radius, vec4f(-1.0), vec4f(1.0));
            second += transmittance * (ground_reflected(sun.x) + ground_reflected(sun.y)
                + ground_reflected(sun.z) + ground_reflected(sun.w));
        }
    }
    second /= f32(ZENITHS * AZIMUTHS);
    again /= f32(ZENITHS);
    // 1e-4 keeps rounding from making infinity of air that loses nothing.
    let psi = second / max(vec4f(1.0) - again, vec4f(1e-4));
    textureStore(written, id.xy, min(psi * TABLE_SCALE, vec4f(HALF_LARGEST)));
}

@compute @workgroup_size(8, 8)
fn sky_view_pass(@builtin(global_invocation_id) id: vec3u) {
    if any(vec2f(id.xy) >= SKY_VIEW_SIZE) {
        return;
    }
    let radius = hillaire.bottom_radius_m;
    let altitude = hillaire.altitude_m;
    let horizon = hillaire.horizon;
    // Inverse of sky_view_uv in hillaire_sky.wgsl.
    let half_rows = u32(0.5 * SKY_VIEW_SIZE.y);
    let below = id.y >= half_rows;
    let s = f32(select(id.y, id.y - half_rows, below)) / f32(half_rows - 1u);
    let u = f32(id.x) / (SKY_VIEW_SIZE.x - 1.0);
    let horizon_angle = acos(horizon);
    // 1e-6 tells the two sides of the horizon apart in f32.
    let mu = select(
        max(cos(horizon_angle * (1.0 - s * s)), horizon + 1e-6),
        min(cos(horizon_angle + (PI - horizon_angle) * s * s), horizon - 1e-6),
        below,
    );
    let mu_s = hillaire.mu_s;
    let across = sqrt(max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 0.0));
    let nu = clamp(mu * mu_s + across * (1.0 - 2.0 * u * u), -1.0, 1.0);
    let phase = phases_at(nu);
    let r = radius + altitude;
    let ground = ground_distance(radius, altitude, mu);
    let end = select(top_distance(radius, hillaire.top_altitude_m, altitude, mu), ground, ground >= 0.0);
    var radiance = vec4f(0.0);
    var transmittance = vec4f(1.0);
    for (var i = 0u; i < SKY_VIEW_STEPS; i++) {
        // Steps grow with the distance: t = L u².
        let x = f32(i) / f32(SKY_VIEW_STEPS);
        let middle = x + 0.5 / f32(SKY_VIEW_STEPS);
        let next = x + 1.0 / f32(SKY_VIEW_STEPS);
        let dt = end * (next * next - x * x);
        add_cell(&radiance, &transmittance, r, mu, mu_s, nu, end * middle * middle, dt, phase);
    }
    if ground >= 0.0 {
        radiance += transmittance * ground_reflected(clamp((r * mu_s + ground * nu) / radius, -1.0, 1.0));
    }
    textureStore(written, id.xy, min(radiance * TABLE_SCALE, vec4f(HALF_LARGEST)));
}

// Light that one cell of a ray from the camera sends there. `t`: where it is sampled; `dt`: its length, m.
fn add_cell(
    radiance: ptr<function, vec4f>,
    transmittance: ptr<function, vec4f>,
    r: f32,
    mu: f32,
    mu_s: f32,
    nu: f32,
    t: f32,
    dt: f32,
    phase: PhaseValues,
) {
    let h = min(altitude_along(hillaire.bottom_radius_m, hillaire.altitude_m, mu, t), hillaire.top_altitude_m);
    let sun = clamp((r * mu_s + t * nu) / (hillaire.bottom_radius_m + h), -1.0, 1.0);
    let here = local_air(h, phase);
    let through = exp(-here.extinction * dt);
    let source = here.phased * sun_transmittance(h, sun) + here.scattering * multiple_at(h, sun);
    *radiance += *transmittance * source * effective_length(here.extinction, through, dt);
    *transmittance *= through;
}

// 32 froxels of 1 km behind each other, which one march fills.
@compute @workgroup_size(8, 8)
fn aerial_pass(@builtin(global_invocation_id) id: vec3u) {
    let ndc = vec2f(2.0, -2.0) * (vec2f(id.xy) + 0.5) / f32(FROXELS) + vec2f(-1.0, 1.0);
    let ray = normalize(hillaire.ray_origin + hillaire.ray_x * ndc.x + hillaire.ray_y * ndc.y);
    let sin_s = sqrt(max(1.0 - hillaire.mu_s * hillaire.mu_s, 0.0));
    let nu = clamp(ray.x * sin_s + ray.z * hillaire.mu_s, -1.0, 1.0);
    let phase = phases_at(nu);
    let r = hillaire.bottom_radius_m + hillaire.altitude_m;
    let dt = FROXEL_LENGTH_M / f32(FROXEL_STEPS);
    var radiance = vec4f(0.0);
    var transmittance = vec4f(1.0);
    for (var slice = 0u; slice < FROXELS; slice++) {
        for (var i = 0u; i < FROXEL_STEPS; i++) {
            let t = dt * (f32(slice * FROXEL_STEPS + i) + 0.5);
            add_cell(&radiance, &transmittance, r, ray.z, hillaire.mu_s, nu, t, dt, phase);
        }
        textureStore(written_scattered, vec3u(id.xy, slice), min(radiance * TABLE_SCALE, vec4f(HALF_LARGEST)));
        textureStore(written_transmittance, vec3u(id.xy, slice), transmittance);
    }
}
