//! First-order scattering along a ray: the f64 twin of the march in `air.wgsl`.
//!
//! Multiple scattering belongs at the line marked "orders ≥ 2" below and in the shader: the moment table of the issue
//! "The air on the GPU" adds its source there.

use crate::columns::Columns;
use crate::geometry::{altitude_along, ground_distance, shadow_interval, top_distance};
use crate::medium::Sampled;

/// A ray and the Sun, at a point within the air.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Altitude of the start, m.
    pub altitude_m: f64,
    /// Cosine of the ray's zenith angle there.
    pub mu: f64,
    /// Cosine of the Sun's zenith angle there.
    pub mu_s: f64,
    /// Cosine between the ray and the Sun: the scattering angle.
    pub nu: f64,
}

/// What a march found.
#[derive(Clone, Copy, Debug)]
pub struct March<const N: usize> {
    /// Scattered radiance per unit spectral irradiance of the Sun, sr⁻¹.
    pub radiance_per_sr: [f64; N],
    /// Transmittance from the start to the end of the ray.
    pub transmittance: [f64; N],
    /// Cosine of the Sun's zenith angle where the ray meets the ground, if it does.
    pub ground_mu_s: Option<f64>,
}

/// Steps through the part of a ray that lies in the planet's shadow: only extinction happens there.
pub const DARK_STEPS: usize = 12;

/// Moves a ray that starts above the air to where it enters; `None` if it misses.
pub fn enter(radius_m: f64, top_m: f64, ray: &Ray) -> Option<Ray> {
    if ray.altitude_m <= top_m {
        return Some(*ray);
    }
    let (r, r_top) = (radius_m + ray.altitude_m, radius_m + top_m);
    let impact = r * (1.0 - ray.mu * ray.mu).max(0.0).sqrt();
    if ray.mu >= 0.0 || impact >= r_top {
        return None;
    }
    let root = ((r_top - impact) * (r_top + impact)).sqrt();
    let t = -r * ray.mu - root;
    Some(Ray {
        altitude_m: top_m,
        mu: -root / r_top,
        mu_s: ((r * ray.mu_s + t * ray.nu) / r_top).clamp(-1.0, 1.0),
        nu: ray.nu,
    })
}

/// Transmittance from a point to the Sun; 0 in the planet's shadow.
pub fn sun_transmittance<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    altitude_m: f64,
    mu_s: f64,
) -> [f64; N] {
    if mu_s < crate::geometry::horizon_cosine(air.medium.bottom_radius_m, altitude_m) {
        return [0.0; N];
    }
    columns.optical_depth(air, altitude_m, mu_s).map(|depth| (-depth).exp())
}

/// Marches a ray through the air: sunlight scattered once, and what is left of the light behind.
///
/// `steps`: samples on the lit part. Cells are equal in s where t = t_c + s|s| and t_c is the point nearest to the
/// ground; within a cell extinction is integrated analytically.
pub fn march<const N: usize>(air: &Sampled<'_, N>, columns: &Columns, ray: &Ray, steps: usize) -> March<N> {
    let (radius_m, top_m) = (air.medium.bottom_radius_m, air.medium.top_altitude_m);
    let mut result = March { radiance_per_sr: [0.0; N], transmittance: [1.0; N], ground_mu_s: None };
    let Some(ray) = enter(radius_m, top_m, ray) else { return result };
    let Ray { altitude_m, mu, mu_s, nu } = ray;
    let r = radius_m + altitude_m;
    let ground = ground_distance(radius_m, altitude_m, mu);
    let end = if ground >= 0.0 { ground } else { top_distance(radius_m, top_m, altitude_m, mu) };
    if ground >= 0.0 {
        result.ground_mu_s = Some(((r * mu_s + ground * nu) / radius_m).clamp(-1.0, 1.0));
    }
    let phases = air.phases(nu);
    let (dark_from, dark_to) = shadow_interval(radius_m, altitude_m, mu, mu_s, nu);
    let (dark_from, dark_to) = (dark_from.min(end), dark_to.min(end));
    let nearest = -r * mu;
    let extent = |from: f64, to: f64| {
        let t_c = nearest.clamp(from, to);
        (t_c, (t_c - from).sqrt(), (to - t_c).sqrt())
    };
    let lit_extent: f64 = [(0.0, dark_from), (dark_to, end)]
        .iter()
        .map(|&(from, to)| extent(from, to))
        .map(|(_, before, after)| before + after)
        .sum();
    for (from, to, lit) in [(0.0, dark_from, true), (dark_from, dark_to, false), (dark_to, end, true)] {
        if to <= from {
            continue;
        }
        let (t_c, before, after) = extent(from, to);
        let share = (before + after) / lit_extent.max(1e-30);
        let n = if lit { ((steps as f64 * share).round() as usize).max(4) } else { DARK_STEPS };
        let at = |s: f64| t_c + s * s.abs();
        let ds = (before + after) / n as f64;
        for i in 0..n {
            let s = -before + i as f64 * ds;
            let dt = at(s + ds) - at(s);
            let t = at(s + 0.5 * ds);
            let h = altitude_along(radius_m, altitude_m, mu, t);
            let extinction = air.extinction_per_m(h);
            let cell: [f64; N] = std::array::from_fn(|k| (-extinction[k] * dt).exp());
            if lit {
                let depth = columns.optical_depth(air, h, (r * mu_s + t * nu) / (radius_m + h));
                let sun = depth.map(|depth| (-depth).exp());
                let mut source = [0.0; N];
                for (c, (component, sampled)) in air.medium.components.iter().zip(&air.components).enumerate() {
                    let density = component.profile.at(h);
                    for k in 0..N {
                        source[k] += density * sampled.scattering_per_m[k] * phases[c][k] * sun[k];
                    }
                }
                // Orders ≥ 2 add their source here.
                for k in 0..N {
                    let length = if extinction[k] * dt > 1e-5 { (1.0 - cell[k]) / extinction[k] } else { dt };
                    result.radiance_per_sr[k] += result.transmittance[k] * source[k] * length;
                }
            }
            for k in 0..N {
                result.transmittance[k] *= cell[k];
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    /// Few steps against many: what the renderer's 32 samples cost.
    #[test]
    fn march_converges() {
        let preset = Preset::named("bruneton2017").unwrap();
        let columns = Columns::new(&preset.medium);
        let air = preset.medium.sampled(&[680.0, 550.0, 440.0]);
        for (sun_zenith_deg, altitude_m, tolerance) in
            [(30.0, 0.0, 0.01), (80.0, 2000.0, 0.01), (94.0, 0.0, 0.03), (60.0, 400_000.0, 0.02)]
        {
            for view_zenith_deg in [5.0, 45.0, 75.0, 88.0, 89.8, 100.0, 109.0] {
                for azimuth_deg in [0.0f64, 90.0, 180.0] {
                    let (z, s) = (f64::to_radians(view_zenith_deg), f64::to_radians(sun_zenith_deg));
                    let nu = z.sin() * s.sin() * azimuth_deg.to_radians().cos() + z.cos() * s.cos();
                    let ray = Ray { altitude_m, mu: z.cos(), mu_s: s.cos(), nu };
                    let (coarse, fine) = (march(&air, &columns, &ray, 32), march(&air, &columns, &ray, 4000));
                    for k in 0..3 {
                        let (a, b) = (coarse.radiance_per_sr[k], fine.radiance_per_sr[k]);
                        let error = (a - b).abs() / b.max(1e-7);
                        assert!(
                            error < tolerance,
                            "sun {sun_zenith_deg} view {view_zenith_deg} az {azimuth_deg} band {k}: {a} {b}"
                        );
                    }
                }
            }
        }
    }

    /// In the single-scattering limit of thin air, L = σ p / µ · column: no geometry, no table, no extinction.
    #[test]
    fn thin_air_has_a_closed_form() {
        let mut preset = Preset::named("bruneton2017").unwrap();
        for component in &mut preset.medium.components {
            component.amount = if component.name == "air" { 1e-6 } else { 0.0 };
        }
        let columns = Columns::new(&preset.medium);
        let air = preset.medium.sampled(&[550.0]);
        let ray = Ray { altitude_m: 0.0, mu: 1.0, mu_s: 0.5, nu: 0.5 };
        let column = preset.medium.components[0].profile.column_m(0.0, 60e3);
        let expected = air.components[0].scattering_per_m[0] * column * crate::phase::rayleigh_phase(0.5, 0.0);
        let ours = march(&air, &columns, &ray, 200).radiance_per_sr[0];
        assert!((ours / expected - 1.0).abs() < 1e-3, "{ours} {expected}");
    }

    /// T(a, c) = T(a, b) T(b, c) along a ray.
    #[test]
    fn transmittance_multiplies() {
        let preset = Preset::named("earth").unwrap();
        let columns = Columns::new(&preset.medium);
        let air = preset.medium.sampled(&[430.0, 630.0]);
        let (radius, mu) = (preset.medium.bottom_radius_m, 0.1);
        let whole = march(&air, &columns, &Ray { altitude_m: 0.0, mu, mu_s: 0.5, nu: 0.2 }, 2000).transmittance;
        let t = 30e3;
        let h = altitude_along(radius, 0.0, mu, t);
        let mu_there = (radius * mu + t) / (radius + h);
        let rest = columns.optical_depth(&air, h, mu_there);
        let table = columns.optical_depth(&air, 0.0, mu);
        for k in 0..2 {
            assert!(((-table[k]).exp() / whole[k] - 1.0).abs() < 2e-3, "{table:?} {whole:?}");
            assert!(rest[k] < table[k]);
        }
    }
}
