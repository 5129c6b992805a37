// Rays among spherical shells: twins of himmel_air::geometry, same names, order and units.
// r² − R² is carried as h (2R + h): f32 radii would lose metres.

const PI: f32 = 3.14159265358979;

fn excess(radius_m: f32, altitude_m: f32) -> f32 {
    return altitude_m * (2.0 * radius_m + altitude_m);
}

fn altitude_along(radius_m: f32, altitude_m: f32, mu: f32, t: f32) -> f32 {
    let q = excess(radius_m, altitude_m) + t * (t + 2.0 * (radius_m + altitude_m) * mu);
    return max(q / (radius_m + sqrt(max(radius_m * radius_m + q, 0.0))), 0.0);
}

fn ground_distance(radius_m: f32, altitude_m: f32, mu: f32) -> f32 {
    let b = (radius_m + altitude_m) * mu;
    let q = excess(radius_m, altitude_m);
    let discriminant = b * b - q;
    if mu >= 0.0 || discriminant < 0.0 {
        return -1.0;
    }
    return q / (-b + sqrt(discriminant));
}

fn top_distance(radius_m: f32, top_m: f32, altitude_m: f32, mu: f32) -> f32 {
    let b = (radius_m + altitude_m) * mu;
    let gap = (top_m - altitude_m) * (2.0 * radius_m + top_m + altitude_m);
    let root = sqrt(max(b * b + gap, 0.0));
    return max(select(root - b, gap / (b + root), b > 0.0), 0.0);
}

fn horizon_cosine(radius_m: f32, altitude_m: f32) -> f32 {
    let h = max(altitude_m, 0.0);
    return -sqrt(excess(radius_m, h)) / (radius_m + h);
}

fn depth_table_uv(radius_m: f32, top_m: f32, altitude_m: f32, mu: f32) -> vec2f {
    let rho = sqrt(max(excess(radius_m, altitude_m), 0.0));
    let rho_top = sqrt(excess(radius_m, top_m));
    let nearest = top_m - altitude_m;
    let farthest = rho + rho_top;
    let d = top_distance(radius_m, top_m, altitude_m, mu);
    return clamp(vec2f((d - nearest) / (farthest - nearest), rho / rho_top), vec2f(0.0), vec2f(1.0));
}

// Inverse of depth_table_uv: altitude and zenith cosine.
fn depth_table_ray(radius_m: f32, top_m: f32, u: f32, v: f32) -> vec2f {
    let rho_top = sqrt(excess(radius_m, top_m));
    let rho = v * rho_top;
    let altitude_m = rho * rho / (radius_m + sqrt(radius_m * radius_m + rho * rho));
    let nearest = top_m - altitude_m;
    let d = nearest + u * (rho + rho_top - nearest);
    if d <= 0.0 {
        return vec2f(altitude_m, 1.0);
    }
    let gap = (rho_top - rho) * (rho_top + rho);
    return vec2f(altitude_m, clamp((gap - d * d) / (2.0 * d * (radius_m + altitude_m)), -1.0, 1.0));
}

fn shadow_interval(radius_m: f32, altitude_m: f32, mu: f32, mu_s: f32, nu: f32) -> vec2f {
    let r = radius_m + altitude_m;
    let a = 1.0 - nu * nu;
    let b = r * (mu - mu_s * nu);
    let c = excess(radius_m, altitude_m) - r * r * mu_s * mu_s;
    let discriminant = b * b - a * c;
    var interval = vec2f(-1e30, 1e30);
    // Along the Sun's axis (f32 cannot tell 1 − ν² from 0) the ray stays within or without.
    if a < 1e-7 {
        if c >= 0.0 {
            return vec2f(0.0);
        }
    } else {
        if discriminant <= 0.0 {
            return vec2f(0.0);
        }
        let root = sqrt(discriminant);
        interval = vec2f(-b - root, -b + root) / a;
    }
    if abs(nu) < 1e-9 {
        if mu_s >= 0.0 {
            return vec2f(0.0);
        }
    } else {
        let plane = -r * mu_s / nu;
        if nu > 0.0 {
            interval.y = min(interval.y, plane);
        } else {
            interval.x = max(interval.x, plane);
        }
    }
    interval.x = max(interval.x, 0.0);
    return select(vec2f(0.0), interval, interval.y > interval.x);
}

// Where a unit vector of a body's frame (z to the north, x to longitude 0) lies in an equirectangular map: longitude −π..π,
// latitude from the north.
fn map_uv(own: vec3f) -> vec2f {
    return vec2f(atan2(own.y, own.x) * 0.15915494 + 0.5, acos(clamp(own.z, -1.0, 1.0)) * 0.31830989);
}

// Level of such a map whose texels are as wide as a pixel's footprint, in radii; half of what it is longer near the limb. `mu`:
// cosine to the observer.
fn map_level(width: u32, footprint: f32, mu: f32) -> f32 {
    let texel = 6.2831853 / f32(width);
    return max(log2(max(footprint / texel, 1e-3)) - 0.5 * log2(max(mu, 0.05)), 0.0);
}
