// Sunlight scattered once by the air, and what the air leaves of the light behind it.
// Twin of himmel_air::single::march.

//#include "phenomena/air/tables.wgsl"

const DARK_STEPS: u32 = 12u;

struct AirMarch {
    // Per unit irradiance of the Sun, 1/sr.
    radiance: vec4f,
    transmittance: vec4f,
    // Cosine of the Sun's zenith angle where the ray meets the ground.
    ground_mu_s: f32,
    hits_ground: bool,
}

// The start of a ray, moved to where it enters the air if it begins above.
struct AirRay {
    altitude_m: f32,
    mu: f32,
    mu_s: f32,
    nu: f32,
    misses: bool,
}

// sin_theta: sine of the ray's zenith angle, taken from vectors because 1 − µ² cancels far from the planet.
fn enter(altitude_m: f32, mu: f32, sin_theta: f32, mu_s: f32, nu: f32) -> AirRay {
    var ray = AirRay(altitude_m, mu, mu_s, nu, false);
    if altitude_m <= frame.top_altitude_m {
        return ray;
    }
    let r = frame.bottom_radius_m + altitude_m;
    let r_top = frame.bottom_radius_m + frame.top_altitude_m;
    let impact = r * sin_theta;
    if mu >= 0.0 || impact >= r_top {
        ray.misses = true;
        return ray;
    }
    let root = sqrt((r_top - impact) * (r_top + impact));
    let t = -r * mu - root;
    ray.altitude_m = frame.top_altitude_m;
    ray.mu = -root / r_top;
    ray.mu_s = clamp((r * mu_s + t * nu) / r_top, -1.0, 1.0);
    return ray;
}

// How far a stretch of the ray reaches before and after its point nearest to the ground, in the variable s of
// t = t_c + s|s|: (t_c, √before, √after).
fn stretch(nearest: f32, from_t: f32, to_t: f32) -> vec3f {
    let t_c = clamp(nearest, from_t, to_t);
    return vec3f(t_c, sqrt(max(t_c - from_t, 0.0)), sqrt(max(to_t - t_c, 0.0)));
}

fn march_air(start: AirRay, steps: u32) -> AirMarch {
    var result = AirMarch(vec4f(0.0), vec4f(1.0), 0.0, false);
    if start.misses {
        return result;
    }
    let radius = frame.bottom_radius_m;
    let r = radius + start.altitude_m;
    let ground = ground_distance(radius, start.altitude_m, start.mu);
    var end = ground;
    if ground >= 0.0 {
        result.hits_ground = true;
        result.ground_mu_s = clamp((r * start.mu_s + ground * start.nu) / radius, -1.0, 1.0);
    } else {
        end = top_distance(radius, frame.top_altitude_m, start.altitude_m, start.mu);
    }
    let theta_coordinate = sqrt(acos(clamp(start.nu, -1.0, 1.0)) / PI);
    let dark = min(shadow_interval(radius, start.altitude_m, start.mu, start.mu_s, start.nu), vec2f(end));
    let nearest = -r * start.mu;
    let first = stretch(nearest, 0.0, dark.x);
    let last = stretch(nearest, dark.y, end);
    let lit_extent = max(first.y + first.z + last.y + last.z, 1e-30);
    for (var part = 0u; part < 3u; part++) {
        // Lit, in the planet's shadow, lit again.
        let lit = part != 1u;
        let from_t = select(select(dark.y, dark.x, part == 1u), 0.0, part == 0u);
        let to_t = select(select(end, dark.y, part == 1u), dark.x, part == 0u);
        if to_t <= from_t {
            continue;
        }
        let s_range = stretch(nearest, from_t, to_t);
        let extent = s_range.y + s_range.z;
        let n = select(DARK_STEPS, max(u32(round(f32(steps) * extent / lit_extent)), 4u), lit);
        let ds = extent / f32(n);
        for (var i = 0u; i < n; i++) {
            let s = -s_range.y + f32(i) * ds;
            let s_end = s + ds;
            let s_middle = s + 0.5 * ds;
            let dt = s_end * abs(s_end) - s * abs(s);
            let t = s_range.x + s_middle * abs(s_middle);
            let h = altitude_along(radius, start.altitude_m, start.mu, t);
            let extinction = extinction_per_m(h);
            let cell = exp(-extinction * dt);
            if lit {
                let mu_s = (r * start.mu_s + t * start.nu) / (radius + h);
                let source = scattering_per_m_sr(theta_coordinate, h) * transmittance_to_space(h, mu_s);
                // Orders ≥ 2 add their source here: the moment table of the issue "The air on the GPU".
                // Below an optical depth of 1e-3 the closed form cancels in f32; the series is exact to 1e-7.
                let x = extinction * dt;
                let length = select((vec4f(1.0) - cell) / extinction, dt * (vec4f(1.0) - 0.5 * x), x < vec4f(1e-3));
                result.radiance += result.transmittance * source * length;
            }
            result.transmittance *= cell;
        }
    }
    return result;
}
