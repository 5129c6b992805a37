//! The usual approximation of multiple scattering, for comparison: Hillaire's table over altitude and Sun.
//!
//! All light that was scattered at least twice is replaced by one number for each altitude and height of the Sun
//! [hillaire2020]. In the paper's letters:
//!
//! ```text
//! L_2nd = ∫ L′(ω) p_u dω           sunlight scattered or reflected once: L′(ω) = T L_o + ∫ T σ_s S p_u dt    [eq. 5–6]
//! f_ms  = ∫ L_f(ω) p_u dω          the share of an even glow that returns: L_f(ω) = ∫ T σ_s dt               [eq. 7–8]
//! F_ms  = 1 + f_ms + f_ms² + … = 1 / (1 − f_ms)                                                              [eq. 9]
//! Ψ_ms  = L_2nd F_ms                                                                                         [eq. 10]
//! L     = ∫ T σ_s (p S + Ψ_ms) dt + T L_o                                                                    [eq. 11]
//! ```
//!
//! p_u = 1/(4π) sr⁻¹, the isotropic phase function; S: transmittance to the Sun, 0 in the planet's shadow; T:
//! transmittance along the ray; L_o = albedo/π · S µ_s on the ground where the ray meets it. Everything is per unit
//! irradiance of a parallel Sun above the air, so Ψ_ms is in sr⁻¹.
//!
//! **The ground.** L_o is direct sunlight only. The paper's table reflects nothing else, and the code that its author
//! published (github.com/sebh/UnrealEngineSkyAtmosphere) marches its frame without a ground and lights the terrain
//! that it draws there by S µ_s alone; light of the sky on the ground is left to the host. So it is here.
//!
//! # What it leaves out
//!
//! - **The direction of light from the second order on.** The light that arrives at a point is replaced by its mean,
//!   and aerosols scatter it evenly too: their forward peak acts on the first order alone.
//! - **The place of later orders.** The third order is taken to be f_ms of the second *at the same point*: light does
//!   not move from bright air to dark air, or down into the lowest kilometres, but stays where it was scattered.
//! - **Ground that is lit by the sky**, and ground lit by light that it reflected: in the table and in the frame.
//!
//! # When it is good and when it is bad
//!
//! Good where the second order is small beside the first, or nearly even: clear air by day, from the ground to space.
//! Bad where later orders have a direction or travel far: haze, dust and thick air (the forward peak carries light
//! down, an even glow leaves upwards), twilight (light arrives from the bright side of the sky), bright ground.
//! Errors against a tracer, median and 95th percentile, from the experiments that preceded this crate: 1.5 and 6 % for
//! the clear Earth by day, 2 and 22 % with the Sun at −4°, 34 and 75 % in haze of optical depth 1, 85 and 98 % for
//! air like Titan's.
//!
//! # Two settings
//!
//! [`Settings::USUAL`] has the sizes and steps of the paper, [`Settings::CONVERGED`] so many that what is wrong is the
//! model. The paper's tables of the sky as seen by one camera and of aerial perspective are not here: every ray is
//! marched, so that `USUAL` is what the paper is at best. Nor does the paper say where in a step it samples: here in
//! the middle. (The published code builds its tables from samples at 0.3 of a step, weighed with the distance between
//! samples, which loses the last 0.7 of a step.)
//!
//! What the usual sizes cost, besides the model: `USUAL` against `CONVERGED`, and in brackets `CONVERGED` against half
//! of its table and steps (its own error is about a third of that). Median and 95th percentile in %, from the ground,
//! 6 zenith angles × 3 azimuths × 4 wavelengths:
//!
//! | preset | Sun 0–80° from the zenith | 88–92° | 94° |
//! |---|---|---|---|
//! | `bruneton2017` | 1.5 and 2.3 (0.01 and 0.03) | 1.5 and 19 (0.08 and 0.2) | 38 and 177 (0.03 and 0.3) |
//! | `earth` | 2.4 and 4.8 (0.01 and 0.1) | 2.6 and 26 (0.1 and 0.2) | 55 and 187 (0.08 and 0.4) |
//! | `mars` | 0.8 and 2.5 (0.05 and 0.2) | 3.0 and 11 (0.1 and 0.2) | 19 and 26 (0.1 and 0.2) |
//! | `earth-haze` | 9 and 52 (0.3 and 1.7) | 19 and 58 (0.4 and 1.5) | 159 and 268 (0.5 and 0.8) |
//! | `titan` | 51 and 361 (0.8 and 7.6) | 29 and 244 (0.5 and 8.8) | 30 and 250 (0.4 and 1.5) |
//!
//! In twilight it is the table: its Suns are 3.7° apart, and it is linear between them where light falls to a tenth.
//! In haze it is the altitudes, 2 km apart (19 km on Titan).
//!
//! At four wavelengths on one core `USUAL` takes 0.15 s to build and 10 µs a ray, `CONVERGED` 6 s and 0.3 ms.
//!
//! ```
//! use himmel_air::hillaire::{Hillaire, Settings};
//! use himmel_air::{Columns, Preset, single};
//! let earth = Preset::named("earth")?;
//! let columns = Columns::new(&earth.medium);
//! let air = earth.medium.sampled(&[440.0]);
//! let approximation = Hillaire::build(&air, &columns, &Settings::USUAL);
//! let ray = single::Ray { altitude_m: 0.0, mu: 0.5, mu_s: 0.7, nu: 0.35 };
//! let [once] = single::march(&air, &columns, &ray, 200).radiance_per_sr;
//! let [all] = approximation.radiance(&air, &columns, &ray);
//! assert!((1.8..2.2).contains(&(all / once))); // half of the blue was scattered more than once
//! # Ok::<(), himmel_air::AirError>(())
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

use himmel_core::interpolate::lerp;
use himmel_core::quadrature::gauss_legendre_unit;

use crate::columns::Columns;
use crate::geometry::{
    altitude_along, depth_table_ray, depth_table_uv, ground_distance, horizon_cosine, shadow_interval, top_distance,
};
use crate::medium::{Medium, Sampled};
use crate::single::{Ray, enter, sun_transmittance};

/// How finely everything is resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The table of transmittances to the Sun; `None`: ask [`Columns`], which is finer and stores logarithms.
    pub transmittance: Option<TransmittanceTable>,
    /// Where nodes, directions and steps lie.
    pub placement: Placement,
    /// Heights of the Sun in the table of Ψ_ms; at least 2.
    pub suns: usize,
    /// Altitudes in the table of Ψ_ms; at least 2.
    pub altitudes: usize,
    /// Zenith angles over which light is gathered for a node of the table.
    pub zeniths: usize,
    /// Azimuths over half a circle (the light is symmetric about the Sun) for each zenith angle.
    pub azimuths: usize,
    /// Steps along each of these directions.
    pub direction_steps: usize,
    /// Steps along a ray of the frame.
    pub frame_steps: usize,
}

/// Size of a table of transmittances, and the steps along each of its rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransmittanceTable {
    /// Directions; at least 2.
    pub width: usize,
    /// Altitudes; at least 2.
    pub height: usize,
    /// Even steps.
    pub steps: usize,
}

/// Where nodes, directions and steps lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// As the paper has them: the table even in µ_s and altitude, directions in even cells of µ, even steps for the
    /// table, steps that grow with the distance (t = L u²) for the frame; the planet's shadow is tested at each sample.
    Paper,
    /// Crowded where light changes fastest: the table by h = H v² and around sunrise, and in logarithms; directions by
    /// Gauss's rule on either side of the horizon; steps around the point nearest to the ground, split where the
    /// planet's shadow begins and ends.
    Crowded,
}

impl Settings {
    /// The paper's sizes: transmittance 256 × 64 with 40 steps, Ψ_ms 32 × 32 from 64 directions of 20 steps, 30 steps
    /// for the frame.
    pub const USUAL: Self = Self {
        transmittance: Some(TransmittanceTable { width: 256, height: 64, steps: 40 }),
        placement: Placement::Paper,
        suns: 32,
        altitudes: 32,
        zeniths: 8,
        azimuths: 4,
        direction_steps: 20,
        frame_steps: 30,
    };

    /// So fine that only the model's error remains: the table of the module's page has what is left.
    pub const CONVERGED: Self = Self {
        transmittance: None,
        placement: Placement::Crowded,
        suns: 96,
        altitudes: 72,
        zeniths: 16,
        azimuths: 4,
        direction_steps: 64,
        frame_steps: 400,
    };
}

/// The approximation for one medium at N wavelengths.
pub struct Hillaire<const N: usize> {
    sun: Sun<N>,
    axes: Axes,
    /// Ψ_ms, sr⁻¹, or its logarithm where nodes are crowded.
    multiple: Grid<N>,
    /// f_ms at the altitudes of the table.
    transfer: Vec<[f64; N]>,
    frame_steps: usize,
}

/// Radiance along a ray by origin, per unit irradiance of the Sun above the air, sr⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts<const N: usize> {
    /// Sunlight scattered once: exact but for the steps.
    pub single: [f64; N],
    /// Light scattered at least twice, or once after the ground: the approximation.
    pub multiple: [f64; N],
    /// Sunlight that the ground reflects to the eye, after the air between.
    pub ground: [f64; N],
}

impl<const N: usize> Hillaire<N> {
    /// Integrates the tables. They depend on the air and its ground alone; no later change of the Sun needs new ones.
    ///
    /// Sizes in `settings` that are too small are taken as the smallest that work.
    pub fn build(air: &Sampled<'_, N>, columns: &Columns, settings: &Settings) -> Self {
        let sun = match settings.transmittance {
            Some(size) => Sun::Table(transmittance_table(air, size)),
            None => Sun::Columns,
        };
        let axes = Axes::new(air.medium, settings.placement);
        let mut multiple = Grid::new(settings.suns, settings.altitudes);
        let mut transfer = Vec::with_capacity(multiple.height);
        for y in 0..multiple.height {
            let (_, v) = multiple.coordinates(0, y);
            let altitude_m = axes.altitude_m(v);
            let directions = directions(air.medium, altitude_m, settings);
            let f_ms = transfer_at(air, altitude_m, &directions, settings);
            for x in 0..multiple.width {
                let (u, _) = multiple.coordinates(x, y);
                let mu_s = axes.mu_s(u, altitude_m);
                let second = second_order(air, columns, &sun, altitude_m, mu_s, &directions, settings);
                let psi = std::array::from_fn(|k| second[k] * geometric_sum(f_ms[k]));
                multiple.values[y * multiple.width + x] = axes.store(psi);
            }
            transfer.push(f_ms);
        }
        Self { sun, axes, multiple, transfer, frame_steps: settings.frame_steps.max(1) }
    }

    /// Radiance along a ray from any altitude, space included, per unit spectral irradiance of a parallel Sun above the
    /// air, sr⁻¹. The Sun's disc is not in it; the lit ground is.
    ///
    /// `air`, `columns`: those that the tables were built from.
    pub fn radiance(&self, air: &Sampled<'_, N>, columns: &Columns, ray: &Ray) -> [f64; N] {
        let parts = self.parts(air, columns, ray);
        std::array::from_fn(|k| parts.single[k] + parts.multiple[k] + parts.ground[k])
    }

    /// [`Hillaire::radiance`] by origin.
    ///
    /// Laws tested: the single part is [`crate::single::march`]'s; nothing is multiple where nothing scatters; a
    /// component of no density changes nothing.
    pub fn parts(&self, air: &Sampled<'_, N>, columns: &Columns, ray: &Ray) -> Parts<N> {
        let mut parts = Parts { single: [0.0; N], multiple: [0.0; N], ground: [0.0; N] };
        let medium = air.medium;
        let Some(ray) = enter(medium.bottom_radius_m, medium.top_altitude_m, ray) else { return parts };
        let phases = air.phases(ray.nu);
        let spacing = match self.axes.placement {
            Placement::Paper => Spacing::Squared,
            Placement::Crowded => Spacing::Nearest,
        };
        let mut transmittance = [1.0; N];
        let ground_mu_s = walk(medium, &ray, spacing, self.frame_steps, |cell| {
            let here = Local::new(air, cell.altitude_m, Some(&phases));
            let weight = here.weight(&mut transmittance, cell.length_m);
            let psi = self.multiple_at(cell.altitude_m, cell.mu_s);
            let sun = if cell.lit { self.sun.at(air, columns, cell.altitude_m, cell.mu_s) } else { [0.0; N] };
            for k in 0..N {
                parts.single[k] += weight[k] * here.phased_per_m_sr[k] * sun[k];
                parts.multiple[k] += weight[k] * here.scattering_per_m[k] * psi[k];
            }
        });
        if let Some(mu_s) = ground_mu_s {
            let reflected = reflected(air, columns, &self.sun, mu_s);
            parts.ground = std::array::from_fn(|k| transmittance[k] * reflected[k]);
        }
        parts
    }

    /// Ψ_ms: mean radiance of the light at an altitude that was scattered or reflected at least once, per unit
    /// irradiance of the Sun above the air, sr⁻¹. σ_s Ψ_ms is what the air there adds to any ray.
    ///
    /// `mu_s`: cosine of the Sun's zenith angle.
    pub fn multiple_at(&self, altitude_m: f64, mu_s: f64) -> [f64; N] {
        let (u, v) = self.axes.coordinates(altitude_m, mu_s);
        self.axes.load(self.multiple.at(u, v))
    }

    /// f_ms at an altitude: the share of light that is scattered again where it was scattered, 0..1.
    pub fn transfer_at(&self, altitude_m: f64) -> [f64; N] {
        let (_, v) = self.axes.coordinates(altitude_m, 0.0);
        let (y, fraction) = split(v, self.transfer.len());
        std::array::from_fn(|k| lerp(self.transfer[y][k], self.transfer[y + 1][k], fraction))
    }
}

/// 1 + f + f² + … = 1 / (1 − f).
///
/// f is 1 only where nothing is absorbed and nothing escapes, which no air of finite depth is; 1e-9 keeps rounding
/// from making infinity of it.
fn geometric_sum(f: f64) -> f64 {
    1.0 / (1.0 - f).max(1e-9)
}

/// L_o: direct sunlight that level ground reflects, sr⁻¹.
fn reflected<const N: usize>(air: &Sampled<'_, N>, columns: &Columns, sun: &Sun<N>, mu_s: f64) -> [f64; N] {
    if mu_s <= 0.0 {
        return [0.0; N];
    }
    let through = sun.at(air, columns, 0.0, mu_s);
    std::array::from_fn(|k| air.ground_albedo[k] / PI * mu_s * through[k])
}

/// Directions around a point: zenith cosine and weight; the weights sum to 1.
fn directions(medium: &Medium, altitude_m: f64, settings: &Settings) -> Vec<(f64, f64)> {
    let n = settings.zeniths.max(2);
    match settings.placement {
        Placement::Paper => (0..n).map(|j| (1.0 - 2.0 * (j as f64 + 0.5) / n as f64, 1.0 / n as f64)).collect(),
        Placement::Crowded => {
            let horizon = horizon_cosine(medium.bottom_radius_m, altitude_m);
            let below = (2 * n / 5).max(1);
            // µ = µ_h ± extent s²: light changes fastest at the horizon.
            [(1.0, 1.0 - horizon, n - below), (-1.0, 1.0 + horizon, below)]
                .into_iter()
                .flat_map(|(side, extent, count)| {
                    gauss_legendre_unit(count)
                        .into_iter()
                        .map(move |(s, w)| (horizon + side * extent * s * s, extent * s * w))
                })
                .collect()
        }
    }
}

/// f_ms = ∫ L_f p_u dω: how much of an even glow of radiance 1 is scattered into a point, if only the air glows.
///
/// Laws tested: in a slab of optical thickness τ₀ and albedo ϖ it is ϖ/2 (2 − E₂(τ) − E₂(τ₀ − τ)); 0..1.
fn transfer_at<const N: usize>(
    air: &Sampled<'_, N>,
    altitude_m: f64,
    directions: &[(f64, f64)],
    settings: &Settings,
) -> [f64; N] {
    let mut sum = [0.0; N];
    for &(mu, share) in directions {
        let mut transmittance = [1.0; N];
        // The Sun overhead: wherever it is, the glow has no shadow.
        let ray = Ray { altitude_m, mu, mu_s: 1.0, nu: mu };
        walk(air.medium, &ray, table_spacing(settings), settings.direction_steps, |cell| {
            let here = Local::new(air, cell.altitude_m, None);
            let weight = here.weight(&mut transmittance, cell.length_m);
            for k in 0..N {
                sum[k] += share * weight[k] * here.scattering_per_m[k];
            }
        });
    }
    sum
}

/// L_2nd = ∫ L′ p_u dω: mean radiance at a point of sunlight that was scattered (evenly) or reflected once, sr⁻¹.
fn second_order<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    sun: &Sun<N>,
    altitude_m: f64,
    mu_s: f64,
    directions: &[(f64, f64)],
    settings: &Settings,
) -> [f64; N] {
    let sin_s = (1.0 - mu_s * mu_s).max(0.0).sqrt();
    let azimuths = settings.azimuths.max(1);
    let mut sum = [0.0; N];
    for &(mu, share) in directions {
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        for j in 0..azimuths {
            let azimuth = PI * (j as f64 + 0.5) / azimuths as f64;
            let nu = (mu * mu_s + sin * sin_s * azimuth.cos()).clamp(-1.0, 1.0);
            let share = share / azimuths as f64;
            let mut transmittance = [1.0; N];
            let ray = Ray { altitude_m, mu, mu_s, nu };
            let ground_mu_s = walk(air.medium, &ray, table_spacing(settings), settings.direction_steps, |cell| {
                let here = Local::new(air, cell.altitude_m, None);
                let weight = here.weight(&mut transmittance, cell.length_m);
                if cell.lit {
                    let through = sun.at(air, columns, cell.altitude_m, cell.mu_s);
                    for k in 0..N {
                        sum[k] += share * weight[k] * here.scattering_per_m[k] * through[k] / (4.0 * PI);
                    }
                }
            });
            if let Some(mu_s) = ground_mu_s {
                let reflected = reflected(air, columns, sun, mu_s);
                for k in 0..N {
                    sum[k] += share * transmittance[k] * reflected[k];
                }
            }
        }
    }
    sum
}

/// What the air is at one altitude.
struct Local<const N: usize> {
    scattering_per_m: [f64; N],
    extinction_per_m: [f64; N],
    /// Σ σ_s p of all components; zero where no phase functions were given.
    phased_per_m_sr: [f64; N],
}

impl<const N: usize> Local<N> {
    fn new(air: &Sampled<'_, N>, altitude_m: f64, phases: Option<&[[f64; N]]>) -> Self {
        let zero = [0.0; N];
        let mut local = Self { scattering_per_m: zero, extinction_per_m: zero, phased_per_m_sr: zero };
        for (c, (component, sampled)) in air.medium.components.iter().zip(&air.components).enumerate() {
            let density = component.profile.at(altitude_m);
            let phase = phases.map_or(zero, |phases| phases[c]);
            for k in 0..N {
                let scattering = density * sampled.scattering_per_m[k];
                local.scattering_per_m[k] += scattering;
                local.extinction_per_m[k] += density * sampled.extinction_per_m[k];
                local.phased_per_m_sr[k] += scattering * phase[k];
            }
        }
        local
    }

    /// ∫ T dt over a cell of even air, m; `transmittance` is that to its begin, and to its end thereafter.
    fn weight(&self, transmittance: &mut [f64; N], length_m: f64) -> [f64; N] {
        std::array::from_fn(|k| {
            let depth = self.extinction_per_m[k] * length_m;
            let through = (-depth).exp();
            // Below 1e-5 the difference cancels, and the length is right to 5e-6.
            let effective_m = if depth > 1e-5 { (1.0 - through) / self.extinction_per_m[k] } else { length_m };
            let weight = transmittance[k] * effective_m;
            transmittance[k] *= through;
            weight
        })
    }
}

/// Where cells along a ray lie.
#[derive(Clone, Copy)]
enum Spacing {
    /// t = L u.
    Even,
    /// t = L u².
    Squared,
    /// t = t_c + s|s| around the point nearest to the ground, split at the planet's shadow.
    Nearest,
}

fn table_spacing(settings: &Settings) -> Spacing {
    match settings.placement {
        Placement::Paper => Spacing::Even,
        Placement::Crowded => Spacing::Nearest,
    }
}

/// A piece of a ray, and where it is sampled.
struct Cell {
    length_m: f64,
    altitude_m: f64,
    mu_s: f64,
    /// Outside the planet's shadow.
    lit: bool,
}

/// Calls `visit` for each cell from the start of a ray within the air to its end; the Sun's zenith cosine on the ground
/// where it ends there.
fn walk(medium: &Medium, ray: &Ray, spacing: Spacing, steps: usize, mut visit: impl FnMut(&Cell)) -> Option<f64> {
    let (radius_m, steps) = (medium.bottom_radius_m, steps.max(1));
    let Ray { altitude_m, mu, mu_s, nu } = *ray;
    let r = radius_m + altitude_m;
    let ground = ground_distance(radius_m, altitude_m, mu);
    let end = if ground >= 0.0 { ground } else { top_distance(radius_m, medium.top_altitude_m, altitude_m, mu) };
    let mut cell = |from: f64, to: f64, at: f64, lit: Option<bool>| {
        let h = altitude_along(radius_m, altitude_m, mu, at);
        let mu_s = ((r * mu_s + at * nu) / (radius_m + h)).clamp(-1.0, 1.0);
        let lit = lit.unwrap_or_else(|| mu_s >= horizon_cosine(radius_m, h));
        visit(&Cell { length_m: to - from, altitude_m: h, mu_s, lit });
    };
    let power = match spacing {
        Spacing::Even => Some(1),
        Spacing::Squared => Some(2),
        Spacing::Nearest => None,
    };
    if end <= 0.0 {
        // On the ground looking down, or at the top looking up: no air between.
    } else if let Some(power) = power {
        let at = |i: f64| end * (i / steps as f64).powi(power);
        for i in 0..steps {
            let i = i as f64;
            cell(at(i), at(i + 1.0), at(i + 0.5), None);
        }
    } else {
        let (dark_from, dark_to) = shadow_interval(radius_m, altitude_m, mu, mu_s, nu);
        let (dark_from, dark_to) = (dark_from.min(end), dark_to.min(end));
        let nearest = -r * mu;
        let stretches = [(0.0, dark_from, true), (dark_from, dark_to, false), (dark_to, end, true)].map(
            |(from, to, lit): (f64, f64, bool)| {
                let t_c = nearest.clamp(from, to.max(from));
                (t_c, (t_c - from).sqrt(), (to - t_c).max(0.0).sqrt(), lit)
            },
        );
        let whole: f64 = stretches.iter().map(|(_, before, after, _)| before + after).sum();
        for (t_c, before, after, lit) in stretches {
            if before + after <= 0.0 {
                continue;
            }
            // Four steps at least: a short lit stretch may be all the light there is.
            let n = ((steps as f64 * (before + after) / whole).round() as usize).max(4);
            let (at, ds) = (|s: f64| t_c + s * s.abs(), (before + after) / n as f64);
            for i in 0..n {
                let s = i as f64 * ds - before;
                cell(at(s), at(s + ds), at(s + 0.5 * ds), Some(lit));
            }
        }
    }
    (ground >= 0.0).then(|| ((r * mu_s + ground * nu) / radius_m).clamp(-1.0, 1.0))
}

/// Where transmittances to the Sun come from.
enum Sun<const N: usize> {
    Table(Grid<N>),
    Columns,
}

impl<const N: usize> Sun<N> {
    /// Transmittance to the Sun, 0 in the planet's shadow.
    fn at(&self, air: &Sampled<'_, N>, columns: &Columns, altitude_m: f64, mu_s: f64) -> [f64; N] {
        let Self::Table(grid) = self else { return sun_transmittance(air, columns, altitude_m, mu_s) };
        let (radius_m, top_m) = (air.medium.bottom_radius_m, air.medium.top_altitude_m);
        let altitude_m = altitude_m.clamp(0.0, top_m);
        if mu_s < horizon_cosine(radius_m, altitude_m) {
            return [0.0; N];
        }
        let (u, v) = depth_table_uv(radius_m, top_m, altitude_m, mu_s);
        grid.at(u, v)
    }
}

/// Transmittances to space over [bruneton2017]'s coordinates, stored as they are.
fn transmittance_table<const N: usize>(air: &Sampled<'_, N>, size: TransmittanceTable) -> Grid<N> {
    let mut grid = Grid::new(size.width, size.height);
    for y in 0..grid.height {
        for x in 0..grid.width {
            let (u, v) = grid.coordinates(x, y);
            let (altitude_m, mu) = depth_table_ray(air.medium.bottom_radius_m, air.medium.top_altitude_m, u, v);
            // The last column grazes the ground: rounding must not make it end there.
            let mu = mu.max(horizon_cosine(air.medium.bottom_radius_m, altitude_m));
            let length_m = top_distance(air.medium.bottom_radius_m, air.medium.top_altitude_m, altitude_m, mu);
            let mut depth = [0.0; N];
            let steps = size.steps.max(1);
            for i in 0..steps {
                let t = length_m * (i as f64 + 0.5) / steps as f64;
                let extinction = air.extinction_per_m(altitude_along(air.medium.bottom_radius_m, altitude_m, mu, t));
                for k in 0..N {
                    depth[k] += extinction[k] * length_m / steps as f64;
                }
            }
            grid.values[y * grid.width + x] = depth.map(|depth| (-depth).exp());
        }
    }
    grid
}

/// A table whose first and last nodes lie at coordinates 0 and 1.
struct Grid<const N: usize> {
    width: usize,
    height: usize,
    /// `[y][x]`
    values: Vec<[f64; N]>,
}

impl<const N: usize> Grid<N> {
    fn new(width: usize, height: usize) -> Self {
        let (width, height) = (width.max(2), height.max(2));
        Self { width, height, values: vec![[0.0; N]; width * height] }
    }

    fn coordinates(&self, x: usize, y: usize) -> (f64, f64) {
        (x as f64 / (self.width - 1) as f64, y as f64 / (self.height - 1) as f64)
    }

    /// Bilinear.
    fn at(&self, u: f64, v: f64) -> [f64; N] {
        let ((x, fx), (y, fy)) = (split(u, self.width), split(v, self.height));
        let (low, high) = (&self.values[y * self.width + x..], &self.values[(y + 1) * self.width + x..]);
        std::array::from_fn(|k| lerp(lerp(low[0][k], low[1][k], fx), lerp(high[0][k], high[1][k], fx), fy))
    }
}

/// The node below a coordinate 0..=1 among `count` nodes, and the fraction to the next.
fn split(coordinate: f64, count: usize) -> (usize, f64) {
    let x = coordinate.clamp(0.0, 1.0) * (count - 1) as f64;
    let i = (x as usize).min(count - 2);
    (i, x - i as f64)
}

/// Where the nodes of the table of Ψ_ms lie, and in what form it holds its values.
struct Axes {
    radius_m: f64,
    top_m: f64,
    placement: Placement,
}

/// Heights of the Sun crowd within about this angle …
const CROWD_RAD: f64 = 5.0 * PI / 180.0;
/// … of this one, relative to the local horizon: Ψ_ms falls fastest where the Sun has set.
const CENTRE_RAD: f64 = -3.0 * PI / 180.0;
/// Below this Ψ_ms, sr⁻¹, there is nothing to see: keeps the logarithm finite.
const FLOOR_PER_SR: f64 = 1e-30;

impl Axes {
    fn new(medium: &Medium, placement: Placement) -> Self {
        Self { radius_m: medium.bottom_radius_m, top_m: medium.top_altitude_m, placement }
    }

    /// Dip of the horizon, and the ends of the crowded axis of Suns: asinh((x − centre) / width) of its lowest and its
    /// highest Sun, x being the Sun's elevation above the local horizon.
    ///
    /// The lowest is where even the second order is dark: two tangents from the top of the air and back.
    fn suns(&self, altitude_m: f64) -> (f64, f64, f64) {
        let dip = (-horizon_cosine(self.radius_m, altitude_m)).asin();
        let tangent = (self.radius_m / (self.radius_m + self.top_m)).acos();
        let lowest = (2.5 * tangent).min(FRAC_PI_2 - dip);
        let coordinate = |x: f64| ((x - CENTRE_RAD) / CROWD_RAD).asinh();
        (dip, coordinate(-lowest), coordinate(FRAC_PI_2 + dip))
    }

    fn altitude_m(&self, v: f64) -> f64 {
        match self.placement {
            Placement::Paper => v * self.top_m,
            Placement::Crowded => v * v * self.top_m,
        }
    }

    fn mu_s(&self, u: f64, altitude_m: f64) -> f64 {
        match self.placement {
            Placement::Paper => 2.0 * u - 1.0,
            Placement::Crowded => {
                let (dip, a, b) = self.suns(altitude_m);
                (CENTRE_RAD + CROWD_RAD * lerp(a, b, u).sinh() - dip).sin()
            }
        }
    }

    /// Inverse of [`Axes::mu_s`] and [`Axes::altitude_m`].
    fn coordinates(&self, altitude_m: f64, mu_s: f64) -> (f64, f64) {
        let altitude_m = altitude_m.clamp(0.0, self.top_m);
        let mu_s = mu_s.clamp(-1.0, 1.0);
        match self.placement {
            Placement::Paper => (0.5 * (mu_s + 1.0), altitude_m / self.top_m),
            Placement::Crowded => {
                let (dip, a, b) = self.suns(altitude_m);
                let x = mu_s.asin() + dip;
                ((((x - CENTRE_RAD) / CROWD_RAD).asinh() - a) / (b - a), (altitude_m / self.top_m).sqrt())
            }
        }
    }

    fn store<const N: usize>(&self, psi: [f64; N]) -> [f64; N] {
        match self.placement {
            Placement::Paper => psi,
            Placement::Crowded => psi.map(|psi| psi.max(FLOOR_PER_SR).ln()),
        }
    }

    /// What was floored is nothing.
    fn load<const N: usize>(&self, stored: [f64; N]) -> [f64; N] {
        match self.placement {
            Placement::Paper => stored,
            Placement::Crowded => stored.map(|ln| if ln > FLOOR_PER_SR.ln() { ln.exp() } else { 0.0 }),
        }
    }
}

#[cfg(test)]
mod tests;
