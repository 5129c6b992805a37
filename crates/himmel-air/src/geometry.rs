//! Rays among spherical shells. Twins of `sphere.wgsl`: same names, order and units.
//!
//! Altitudes are never differences of radii: `r² − R²` is carried as `h (2R + h)`, which keeps metres
//! where f32 radii would lose them.

/// r² − R² at altitude `h`.
pub fn excess(radius_m: f64, altitude_m: f64) -> f64 {
    altitude_m * (2.0 * radius_m + altitude_m)
}

/// Altitude after `t` metres along a ray that starts at `altitude_m` with zenith cosine `mu`.
pub fn altitude_along(radius_m: f64, altitude_m: f64, mu: f64, t: f64) -> f64 {
    let q = excess(radius_m, altitude_m) + t * (t + 2.0 * (radius_m + altitude_m) * mu);
    (q / (radius_m + (radius_m * radius_m + q).max(0.0).sqrt())).max(0.0)
}

/// Distance to the ground along the ray, or −1 where it misses.
pub fn ground_distance(radius_m: f64, altitude_m: f64, mu: f64) -> f64 {
    let b = (radius_m + altitude_m) * mu;
    let q = excess(radius_m, altitude_m);
    let discriminant = b * b - q;
    if mu >= 0.0 || discriminant < 0.0 {
        return -1.0;
    }
    q / (-b + discriminant.sqrt())
}

/// Distance to the upper end of the air at `top_m` for a ray that starts below it.
pub fn top_distance(radius_m: f64, top_m: f64, altitude_m: f64, mu: f64) -> f64 {
    let b = (radius_m + altitude_m) * mu;
    let gap = (top_m - altitude_m) * (2.0 * radius_m + top_m + altitude_m);
    let root = (b * b + gap).max(0.0).sqrt();
    // Of the two forms of the root, the one without cancellation.
    if b > 0.0 { gap / (b + root) } else { root - b }.max(0.0)
}

/// Cosine of the zenith angle of the horizon as seen from an altitude (zero or negative).
pub fn horizon_cosine(radius_m: f64, altitude_m: f64) -> f64 {
    -excess(radius_m, altitude_m.max(0.0)).sqrt() / (radius_m + altitude_m.max(0.0))
}

/// Coordinates 0..=1 of the optical-depth table for a ray that does not meet the ground: x from the distance to
/// the top, y from the altitude [bruneton2017, "Transmittance"].
pub fn depth_table_uv(radius_m: f64, top_m: f64, altitude_m: f64, mu: f64) -> (f64, f64) {
    let rho = excess(radius_m, altitude_m).max(0.0).sqrt();
    let rho_top = excess(radius_m, top_m).sqrt();
    let (nearest, farthest) = (top_m - altitude_m, rho + rho_top);
    let d = top_distance(radius_m, top_m, altitude_m, mu);
    (((d - nearest) / (farthest - nearest)).clamp(0.0, 1.0), (rho / rho_top).clamp(0.0, 1.0))
}

/// Inverse of [`depth_table_uv`]: altitude and zenith cosine.
pub fn depth_table_ray(radius_m: f64, top_m: f64, u: f64, v: f64) -> (f64, f64) {
    let rho_top = excess(radius_m, top_m).sqrt();
    let rho = v * rho_top;
    let altitude_m = rho * rho / (radius_m + (radius_m * radius_m + rho * rho).sqrt());
    let (nearest, farthest) = (top_m - altitude_m, rho + rho_top);
    let d = nearest + u * (farthest - nearest);
    if d <= 0.0 {
        return (altitude_m, 1.0);
    }
    let gap = (rho_top - rho) * (rho_top + rho);
    (altitude_m, ((gap - d * d) / (2.0 * d * (radius_m + altitude_m))).clamp(-1.0, 1.0))
}

/// Where the planet's cylinder of shadow cuts a ray: the interval of distances in shadow, empty (0, 0) if none.
///
/// `mu`, `mu_s`: zenith cosines of the ray and of the Sun at the start; `nu`: cosine between ray and Sun.
pub fn shadow_interval(radius_m: f64, altitude_m: f64, mu: f64, mu_s: f64, nu: f64) -> (f64, f64) {
    let r = radius_m + altitude_m;
    // Across the Sun's direction the ray is p + t w; in shadow where |p + t w| < R and behind the planet.
    let a = 1.0 - nu * nu;
    let b = r * (mu - mu_s * nu);
    let c = excess(radius_m, altitude_m) - r * r * mu_s * mu_s;
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 || a < 1e-12 {
        let within = a < 1e-12 && c < 0.0;
        if !within {
            return (0.0, 0.0);
        }
    }
    let (mut from, mut to) = if a < 1e-12 {
        (f64::MIN, f64::MAX)
    } else {
        let root = discriminant.sqrt();
        ((-b - root) / a, (-b + root) / a)
    };
    // Behind the planet: the Sun's direction component r mu_s + t nu is negative.
    if nu.abs() < 1e-9 {
        if mu_s >= 0.0 {
            return (0.0, 0.0);
        }
    } else {
        let plane = -r * mu_s / nu;
        if nu > 0.0 { to = to.min(plane) } else { from = from.max(plane) }
    }
    if to > from.max(0.0) { (from.max(0.0), to) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 6_360_000.0;
    const TOP: f64 = 60_000.0;

    #[test]
    fn table_mapping_inverts() {
        for i in 0..=16 {
            for j in 0..=16 {
                let (u, v) = (f64::from(i) / 16.0, f64::from(j) / 16.0);
                let (h, mu) = depth_table_ray(R, TOP, u, v);
                if h >= TOP - 1e-6 {
                    continue; // at the top every ray has left
                }
                let (u2, v2) = depth_table_uv(R, TOP, h, mu);
                assert!((u - u2).abs() < 1e-9 && (v - v2).abs() < 1e-9, "{u} {v}: {u2} {v2}");
            }
        }
    }

    #[test]
    fn altitude_is_a_fixed_point_at_boundaries() {
        for (h, mu) in [(0.0, 0.3), (2.0, -0.01), (1e4, -0.5), (3e4, 1.0), (59e3, -0.05)] {
            let d = top_distance(R, TOP, h, mu);
            assert!((altitude_along(R, h, mu, d) - TOP).abs() < 1e-4);
            let g = ground_distance(R, h, mu);
            if g > 0.0 {
                assert!(altitude_along(R, h, mu, g) < 1e-4);
                assert!(mu < horizon_cosine(R, h));
            }
        }
    }

    #[test]
    fn the_shadow_begins_overhead_at_the_right_height() {
        // Sun 4° below the horizon: at the zenith sunlight begins at R (1/cos 4° − 1).
        let sun = (-4f64).to_radians();
        let (from, to) = shadow_interval(R, 0.0, 1.0, sun.sin(), sun.sin());
        assert_eq!(from, 0.0);
        assert!((to - R * (1.0 / sun.cos() - 1.0)).abs() < 1.0, "{to}");
        // By day nothing above is in shadow.
        assert_eq!(shadow_interval(R, 0.0, 0.5, 0.5, 0.9), (0.0, 0.0));
    }
}
