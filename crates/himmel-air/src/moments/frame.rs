//! One ray through the air with all orders of scattering: what a pixel of the renderer evaluates.

use std::f64::consts::PI;

use himmel_core::quadrature::gauss_legendre_unit;

use crate::columns::Columns;
use crate::geometry::{altitude_along, ground_distance, horizon_cosine, shadow_interval, top_distance};
use crate::irradiance::Directions;
use crate::medium::Sampled;
use crate::single::{Ray, enter};

use super::Moments;
use super::build::add_scattered;
use super::rays::{Shares, crowded};

/// A ray within the air with what is known before the march.
struct View {
    ray: Ray,
    end: f64,
    ground: bool,
    /// Distances between which the ray runs in the planet's shadow; empty if equal.
    dark: (f64, f64),
    /// Whether it began above the air.
    from_space: bool,
}

/// What came of a march, per wavelength. S and U are two approximations of the same light: see [`radiance`].
struct Seen<const N: usize> {
    /// Peaks scaled away, their light put back.
    s: [f64; N],
    /// Nothing scaled.
    u: [f64; N],
    /// Share of S.
    beta: [f64; N],
}

/// Cells of the march that places the samples.
const PLACING: usize = 64;

/// Share of the cells that goes to the lit parts of a ray through the planet's shadow.
const LIT: f64 = 0.4;

/// How slant a ray must be (cosine to the vertical) for S and U to weigh the same.
const EVEN_SLANT: f64 = 0.1;

/// Radiance along a ray: sunlight scattered any number of times and what the lit ground sends up, per unit spectral
/// irradiance of the Sun, sr⁻¹. The Sun's disc is not in it.
///
/// From any altitude: within the air, or from space (0 if the ray misses the air). `steps`: cells, 32 for the recipe.
///
/// ```text
/// S:  L = ∫T′[ σ_R (p_R T′_s + M′_R) + (1−f) σ_M (p′ T′_s + M′_M) ] dt
///       + ∫T′ T′_s σ_M B_S(θ, τ_sun + τ_view) dt + T′ ground
/// U:  L = ∫T [ σ_R (p_R T′_s + M_R) + σ_M (B_U(θ, τ_sun) T′_s + M_M) ] dt + T ground
/// L = β S + (1−β) U,   β = ⟨|z|/(|z| + 0.1)⟩ over the ray with weight T σ_M
/// ```
///
/// R: molecules.  M: aerosols.  T: transmittance from the observer, T_s: to the Sun; primes: of the scaled medium.
/// p: phase function, p′ its polynomial.  M_X: what X scatters of the table's light.  B_S, B_U, τ: see `peak.rs`.
/// z: cosine of the ray to the vertical.  S is better through haze, U near the horizon of clear air, where the peak's
/// light has left the line of sight for good.
///
/// Laws tested: without aerosols order 1 is [`crate::single::march`]; no scattering gives 0; rays in space see nothing.
pub fn radiance<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    moments: &Moments<N>,
    ray: &Ray,
    steps: usize,
) -> [f64; N] {
    radiance_to(air, columns, moments, ray, steps, f64::INFINITY)
}

/// As [`radiance`] of the first `limit_m` metres of the ray alone: what the air before something there scatters towards the
/// viewer. The ground counts if it is nearer. β is that of the stretch.
///
/// Laws tested: nothing at 0; at infinity [`radiance`]; without aerosols stretches add up through the transmittance.
pub fn radiance_to<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    moments: &Moments<N>,
    ray: &Ray,
    steps: usize,
    limit_m: f64,
) -> [f64; N] {
    let Some(view) = view(air, ray, limit_m) else { return [0.0; N] };
    let seen = march(air, columns, moments, &view, steps, true);
    std::array::from_fn(|k| {
        // Their difference is small where it is sure; the polynomial's undershoot must not become negative light.
        (seen.beta[k] * seen.s[k] + (1.0 - seen.beta[k]) * seen.u[k]).max(0.0)
    })
}

/// As [`radiance`] without what aerosols scatter into their forward peaks, which counts as sunlight: smooth enough for
/// sums over few directions.
pub fn smooth_radiance<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    moments: &Moments<N>,
    ray: &Ray,
    steps: usize,
) -> [f64; N] {
    let Some(view) = view(air, ray, f64::INFINITY) else { return [0.0; N] };
    march(air, columns, moments, &view, steps, false).s.map(|light| light.max(0.0))
}

/// Irradiance of a level surface by Sun and sky, per unit spectral irradiance of the Sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Irradiance<const N: usize> {
    /// By the Sun, with what aerosols scatter into their forward peak around it.
    pub direct: [f64; N],
    /// By the rest of the sky, on a surface that faces up.
    pub down: [f64; N],
    /// By ground and air below, on a surface that faces down.
    pub up: [f64; N],
}

/// Irradiance at an altitude within the air (clamped to it) by sums over the two half spheres.
///
/// The sums take the scaled medium, whose sky is smooth; its forward peaks count as direct.
pub fn irradiance<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    moments: &Moments<N>,
    altitude_m: f64,
    mu_s: f64,
    directions: Directions,
) -> Irradiance<N> {
    let medium = air.medium;
    let altitude_m = altitude_m.clamp(0.0, medium.top_altitude_m);
    let horizon = horizon_cosine(medium.bottom_radius_m, altitude_m);
    let mut result = Irradiance { direct: [0.0; N], down: [0.0; N], up: [0.0; N] };
    if mu_s > horizon {
        // Between horizon and dip the Sun shines on what faces down.
        let (through, _) = moments.sun(columns, altitude_m, mu_s);
        result.direct = through.map(|through| through * mu_s.max(0.0));
    }
    let sin_s = (1.0 - mu_s * mu_s).max(0.0).sqrt();
    let rule = gauss_legendre_unit(directions.zenith.max(2));
    // Above the level, between level and horizon, below the horizon; crowded towards the horizon.
    for (from, to) in [(0.0, 1.0), (horizon, 0.0), (horizon, -1.0)] {
        for &(s, w) in &rule {
            let (mu, d_mu) = (from + (to - from) * s * s, (to - from).abs() * 2.0 * s * w);
            if d_mu == 0.0 {
                continue;
            }
            let sin = (1.0 - mu * mu).max(0.0).sqrt();
            for j in 0..directions.azimuth.max(1) {
                let azimuth = PI * (j as f64 + 0.5) / directions.azimuth.max(1) as f64;
                let nu = (mu * mu_s + sin * sin_s * azimuth.cos()).clamp(-1.0, 1.0);
                let Some(view) = view(air, &Ray { altitude_m, mu, mu_s, nu }, f64::INFINITY) else { continue };
                let light = march(air, columns, moments, &view, directions.steps, false).s;
                let sum = if mu > 0.0 { &mut result.down } else { &mut result.up };
                let weight = mu.abs() * d_mu * 2.0 * PI / directions.azimuth.max(1) as f64;
                for k in 0..N {
                    sum[k] += weight * light[k];
                }
            }
        }
    }
    result
}

/// Where the ray runs, at most to a distance from its start.
fn view<const N: usize>(air: &Sampled<'_, N>, from: &Ray, limit_m: f64) -> Option<View> {
    let (radius_m, top_m) = (air.medium.bottom_radius_m, air.medium.top_altitude_m);
    let from_space = from.altitude_m > top_m;
    let ray = enter(radius_m, top_m, &Ray { altitude_m: from.altitude_m.max(0.0), ..*from })?;
    let hit = ground_distance(radius_m, ray.altitude_m, ray.mu);
    let air_ends = if hit >= 0.0 { hit } else { top_distance(radius_m, top_m, ray.altitude_m, ray.mu) };
    let before_m = if from_space { (radius_m + top_m) * ray.mu - (radius_m + from.altitude_m) * from.mu } else { 0.0 };
    let end = air_ends.min(limit_m - before_m).max(0.0);
    let (from, to) = shadow_interval(radius_m, ray.altitude_m, ray.mu, ray.mu_s, ray.nu);
    Some(View { ray, end, ground: hit >= 0.0 && end == hit, dark: (from.min(end), to.min(end)), from_space })
}

/// Boundaries of the cells: 30 % by what each stretch scatters towards the viewer, 70 % by √t (from space: by nearness
/// to the ground). The edges of the planet's shadow are boundaries too; where the ray crosses it, [`LIT`] of the cells
/// go to the lit parts by themselves, which may be as short as a limb's upper edge.
fn edges<const N: usize>(air: &Sampled<'_, N>, moments: &Moments<N>, view: &View, steps: usize) -> Vec<f64> {
    let (radius_m, Ray { altitude_m, mu, .. }) = (air.medium.bottom_radius_m, view.ray);
    let mut fine: Vec<f64> = crowded(PLACING, -(radius_m + altitude_m) * mu, view.end).collect();
    let crossed: Vec<f64> = match view.dark.1 > view.dark.0 {
        true => [view.dark.0, view.dark.1].into_iter().filter(|&t| t > 0.0 && t < view.end).collect(),
        false => Vec::new(),
    };
    for &edge in &crossed {
        fine.insert(fine.partition_point(|&t| t <= edge), edge);
    }
    let cells = fine.len() - 1;
    let mut through = [1.0; N];
    let mut weights = vec![[0.0; N]; cells];
    for (weight, pair) in weights.iter_mut().zip(fine.windows(2)) {
        let (dt, t) = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
        let local = moments.optics.local(&air.medium.components, altitude_along(radius_m, altitude_m, mu, t));
        for k in 0..N {
            let cell = (-local.scaled_extinction_per_m[k] * dt).exp();
            weight[k] = through[k] * local.scaled[0][k] * dt * 0.5 * (1.0 + cell);
            through[k] *= cell;
        }
    }
    let total: [f64; N] = std::array::from_fn(|k| weights.iter().map(|w| w[k]).sum());
    let share = |w: &[f64; N]| -> f64 { (0..N).map(|k| if total[k] > 0.0 { w[k] / total[k] } else { 0.0 }).sum() };
    let weight = Shares::new(weights.iter().map(share));
    let spread = match view.from_space {
        true => Shares::new((0..cells).map(|_| 1.0)),
        false => Shares::new(fine.windows(2).map(|pair| pair[1].sqrt() - pair[0].sqrt())),
    };
    let mut shares = Shares::mixed(&spread, &weight, 0.3);
    if !crossed.is_empty() {
        let lit = |(pair, w): (&[f64], &[f64; N])| {
            let dt = pair[1] - pair[0];
            let dark = pair[0] >= view.dark.0 && pair[1] <= view.dark.1;
            if dark || dt <= 0.0 { 0.0 } else { (share(w) / dt).powf(0.25) * dt }
        };
        shares = Shares::mixed(&shares, &Shares::new(fine.windows(2).zip(&weights).map(lit)), LIT);
    }
    let steps = steps.clamp(1, 1_000_000);
    let place = |i: usize| {
        let (cell, x) = shares.at(i as f64 / steps as f64);
        fine[cell] + (fine[cell + 1] - fine[cell]) * x
    };
    let mut edges: Vec<f64> = (0..=steps).map(place).collect();
    for edge in crossed {
        edges.insert(edges.partition_point(|&t| t <= edge), edge);
    }
    edges
}

/// The march itself. `peaks`: whether the forward peaks' light is put back, and U is wanted at all.
fn march<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    moments: &Moments<N>,
    view: &View,
    steps: usize,
    peaks: bool,
) -> Seen<N> {
    let components = &air.medium.components;
    let scatterers = &moments.optics.scatterers;
    let both = peaks && moments.optics.aerosols;
    let (radius_m, Ray { altitude_m, mu, mu_s, nu }) = (air.medium.bottom_radius_m, view.ray);
    let r0 = radius_m + altitude_m;
    let second = 0.5 * (3.0 * nu * nu - 1.0);
    let corrections = moments.peaks.at_angle(nu);
    let exact = air.phases(nu);
    let smooth: Vec<[f64; N]> = scatterers
        .iter()
        .map(|s| {
            std::array::from_fn(|k| {
                (1.0 + 3.0 * s.scaled_chi[0][k] * nu + 5.0 * s.scaled_chi[1][k] * second) / (4.0 * PI)
            })
        })
        .collect();

    let mut seen = Seen { s: [0.0; N], u: [0.0; N], beta: [1.0; N] };
    let (mut through, mut through_unscaled, mut tau_view) = ([1.0; N], [1.0; N], [0.0; N]);
    let (mut slant, mut slant_weight) = ([0.0; N], [0.0; N]);
    for pair in edges(air, moments, view, steps).windows(2) {
        let (dt, t) = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
        if dt <= 0.0 {
            continue;
        }
        let h = altitude_along(radius_m, altitude_m, mu, t);
        let r = radius_m + h;
        let (mu_here, mu_s_here) = (((r0 * mu + t) / r).clamp(-1.0, 1.0), ((r0 * mu_s + t * nu) / r).clamp(-1.0, 1.0));
        let lit = t < view.dark.0 || t >= view.dark.1;
        let (sun, tau_sun) = if lit { moments.sun(columns, h, mu_s_here) } else { ([0.0; N], [0.0; N]) };

        let (mut extinction, mut peak, mut aerosol) = ([0.0; N], [0.0; N], [0.0; N]);
        let (mut scaled, mut unscaled) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        let (mut source_s, mut source_u) = ([0.0; N], [0.0; N]);
        let tau: [f64; N] = std::array::from_fn(|k| tau_sun[k] + tau_view[k]);
        for (c, (component, s)) in components.iter().zip(scatterers).enumerate() {
            let density = component.profile.at(h);
            if density <= 0.0 {
                continue;
            }
            for k in 0..N {
                let scattering = density * s.scattering_per_m[k];
                let smoothed = scattering - density * s.peak_per_m[k];
                extinction[k] += density * s.extinction_per_m[k];
                peak[k] += density * s.peak_per_m[k];
                for (m, (chi, scaled_chi)) in
                    [(1.0, 1.0), (s.chi[0][k], s.scaled_chi[0][k]), (s.chi[1][k], s.scaled_chi[1][k])]
                        .into_iter()
                        .enumerate()
                {
                    scaled[m][k] += smoothed * scaled_chi;
                    unscaled[m][k] += scattering * chi;
                }
                source_s[k] += smoothed * smooth[c][k] * sun[k];
                if s.is_aerosol() {
                    aerosol[k] += scattering;
                }
                if !both || !s.is_aerosol() {
                    source_u[k] += scattering * exact[c][k] * sun[k];
                } else if sun[k] > 0.0 && scattering > 0.0 {
                    // The half cell between its edge and its middle is left out of τ: it is small against the Sun's.
                    let rest = exact[c][k] * scattering - smooth[c][k] * smoothed;
                    source_s[k] += sun[k] * ((-tau[k]).exp() * rest + scattering * corrections.at(c, 0, k, tau[k]));
                    let turned = (-tau_sun[k]).exp() * exact[c][k] + corrections.at(c, 1, k, tau_sun[k]);
                    source_u[k] += sun[k] * scattering * turned;
                }
            }
        }
        let around = moments.at(h, mu_s_here);
        add_scattered(&mut source_s, &around, &scaled, mu_here, mu_s_here, nu);
        if both {
            add_scattered(&mut source_u, &around, &unscaled, mu_here, mu_s_here, nu);
        }
        let vertical = mu_here.abs() / (mu_here.abs() + EVEN_SLANT);
        for k in 0..N {
            let pass = |through: &mut f64, extinction: f64| {
                let lost = -(-extinction * dt).exp_m1();
                let length = if extinction * dt > 1e-9 { lost / extinction } else { dt };
                let weight = *through * length;
                *through *= 1.0 - lost;
                weight
            };
            seen.s[k] += pass(&mut through[k], extinction[k] - peak[k]) * source_s[k];
            if both {
                let weight = pass(&mut through_unscaled[k], extinction[k]);
                seen.u[k] += weight * source_u[k];
                slant_weight[k] += weight * aerosol[k];
                slant[k] += weight * aerosol[k] * vertical;
            }
            tau_view[k] += peak[k] * dt;
        }
    }
    if view.ground {
        let there = ((r0 * mu_s + view.end * nu) / radius_m).clamp(-1.0, 1.0);
        let irradiance = moments.ground_irradiance(columns, there);
        for k in 0..N {
            let ground = air.ground_albedo[k] / PI * irradiance[k];
            seen.s[k] += through[k] * ground;
            seen.u[k] += through_unscaled[k] * ground;
        }
    }
    for k in 0..N {
        if both && slant_weight[k] > 0.0 {
            seen.beta[k] = slant[k] / slant_weight[k];
        }
    }
    seen
}
