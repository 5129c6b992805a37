//! What stars are to the renderer, and the f64 twins of `psf.wgsl`: same names, order and units.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::cells::{Cell, cell_of, cells_of};
use super::params::{Glare, StarsParams};

/// A star of a catalogue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarPoint {
    /// Unit vector at J2000.0, ICRS.
    pub place: DVec3,
    /// Its change per Julian year.
    pub velocity_per_year: DVec3,
    /// Annual parallax, rad.
    pub parallax_rad: f64,
    /// V above the air.
    pub v_magnitude: f64,
    /// Illuminance above the air, lx.
    pub illuminance_lx: f64,
    /// Temperature of the black body of its colour, K.
    pub temperature_k: f64,
}

/// Stars, by cells of the sky, brightest first in each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StarList {
    stars: Vec<StarPoint>,
    ranks: Vec<u32>,
    cells: Vec<Cell>,
}

impl StarList {
    /// Sorts them; leaves out what is not finite.
    pub fn new(mut stars: Vec<StarPoint>) -> Self {
        let finite = |star: &StarPoint| {
            let numbers = [star.parallax_rad, star.v_magnitude, star.illuminance_lx, star.temperature_k];
            star.place.is_finite() && star.velocity_per_year.is_finite() && numbers.iter().all(|n| n.is_finite())
        };
        stars.retain(finite);
        stars.sort_by(|a, b| a.v_magnitude.total_cmp(&b.v_magnitude));
        let mut ranked: Vec<(u32, StarPoint)> = (0..).zip(stars).collect();
        ranked.sort_by_key(|(_, star)| cell_of(star.place));
        let (ranks, stars): (Vec<u32>, Vec<StarPoint>) = ranked.into_iter().unzip();
        let cells = cells_of(&stars);
        Self { stars, ranks, cells }
    }

    /// All of them.
    pub fn stars(&self) -> &[StarPoint] {
        &self.stars
    }

    /// How many are brighter, of each.
    pub(super) fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// How many of a cell are at least as bright as a magnitude.
    pub(super) fn count_in(&self, cell: &Cell, magnitude: f64) -> usize {
        let own = self.stars.get(cell.first..cell.first + cell.count).unwrap_or_default();
        own.partition_point(|star| star.v_magnitude <= magnitude)
    }

    /// How many are at least as bright as a magnitude.
    pub fn count_to(&self, magnitude: f64) -> usize {
        self.cells.iter().map(|cell| self.count_in(cell, magnitude)).sum()
    }
}

/// The stars of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct StarField {
    /// Uploaded when it is another one than before.
    pub list: std::sync::Arc<StarList>,
    /// How they are drawn.
    pub params: StarsParams,
    /// Julian years since J2000.0.
    pub years_since_j2000: f64,
    /// The observer's velocity by the speed of light, ICRS axes.
    pub beta: DVec3,
    /// The observer from the barycentre, au, ICRS axes.
    pub observer_au: DVec3,
    /// Rotation.
    pub enu_from_icrs: DMat3,
    /// What scintillation runs by, s.
    pub time_s: f64,
    /// No part of the sky above the horizon is darker, cd m⁻²; 0 where nobody knows. Stars that are lost in it are not moved.
    pub darkest_sky_cd_m2: f64,
}

/// A disc that hides points behind it: Sun, Moon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hider {
    /// Unit vector to its centre, without refraction, east-north-up.
    pub direction: DVec3,
    /// Apparent radius, rad.
    pub radius_rad: f64,
}

/// A point of light that is not a star: a planet, a moon of Jupiter, a satellite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointBody {
    /// Unit vector to it, without refraction, east-north-up.
    pub direction: DVec3,
    /// Irradiance above the air at the four wavelengths, relative to the preset's star at 1 au.
    pub irradiance: [f64; 4],
    /// Share of a star's scintillation.
    pub scintillation: f64,
    /// Full width of what is no point, rad: a comet's coma.
    pub width_rad: f64,
}

/// The core: a cubic B-spline, 4 pixels wide   [unser1999]
///
/// Laws tested: its samples at x, x + 1, … sum to 1 for every x, their centroid is the point itself, and their spread does
/// not depend on x: a star that moves by parts of a pixel flickers nowhere.
pub fn core_weight(x: f64) -> f64 {
    let a = x.abs();
    if a < 1.0 { 2.0 / 3.0 - a * a * (1.0 - 0.5 * a) } else { (2.0 - a).max(0.0).powi(3) / 6.0 }
}

/// Coefficients of glare: inverse cube (rad³/sr), inverse square (rad²/sr).
///
/// Eye: 0.478 · 20.91/θ³ + 0.138 · 72.37/θ², θ in degrees   [spencer1995, photopic; without its core and its red halo]. A lens:
/// 3 % within 30° by the inverse square, 2.5/θ², as veiling glare of good lenses is measured   [king1971].
pub fn glare_coefficients(glare: Glare) -> [f64; 2] {
    let degree = PI / 180.0;
    match glare {
        Glare::None => [0.0, 0.0],
        Glare::Eye => [0.478 * 20.91 * degree.powi(3), 0.138 * 72.37 * degree.powi(2)],
        Glare::Lens => [0.0, 2.5 * degree.powi(2)],
    }
}

/// Angle within which glare is softened, rad: Spencer's 0.02°.
pub const GLARE_SOFT_RAD: f64 = 0.02 * PI / 180.0;
/// Glare is drawn no farther from a point than this, rad.
pub const GLARE_FARTHEST_RAD: f64 = 5.0 * PI / 180.0;
/// Exposed value at which glare ends: 2 % of middle grey.
pub const GLARE_FLOOR: f64 = 0.0036;

/// Glare per steradian at an angle from the point.
pub fn glare_per_sr(glare: [f64; 2], theta_rad: f64, soft_rad: f64) -> f64 {
    let u = 1.0 / (theta_rad + soft_rad);
    u * u * (glare[0] * u + glare[1])
}

/// Share of the light in the glare within a radius, its value at the rim taken off. The core keeps the rest.
///
/// ∫ 2πθ (g(θ) − g(R)) dθ in closed form. Laws tested: the sum over rings.
pub fn glare_share(glare: [f64; 2], radius_rad: f64, soft_rad: f64) -> f64 {
    let end = radius_rad + soft_rad;
    let cube = glare[0] * (0.5 / soft_rad - (radius_rad + 0.5 * soft_rad) / (end * end));
    let square = glare[1] * ((end / soft_rad).ln() + soft_rad / end - 1.0);
    TAU * (cube + square) - PI * radius_rad * radius_rad * glare_per_sr(glare, radius_rad, soft_rad)
}

/// Air mass to a direction by the sine of its elevation: 1/(s + 0.025 e^(−11 s))   [rozenberg1966]; 40 at the horizon.
pub fn air_mass(sine: f64) -> f64 {
    let s = sine.max(0.0);
    1.0 / (s + 0.025 * (-11.0 * s).exp())
}

/// Size of the pattern of light that flies over the ground, √(λ h) at 550 nm from 10 km: a pupil smaller than this sees
/// all of its contrast, m.
const PATTERN_M: f64 = 0.074;
/// Height of the layer that makes stars twinkle, m.
const LAYER_M: f64 = 10_000.0;

/// Standard deviation of a star's light at the zenith, relative.
///
/// σ = 0.09 D^(−2/3) X^1.75 e^(−h/8 km) / √(2t)   [young1967; dravins1998], D in cm, at least the size of the pattern
///
/// `aperture_m`: of pupil or telescope.  `integration_s`: t.  `altitude_m`: of the observer.
/// Laws tested: the published 1.5 mmag of a metre in a second near the zenith; falls with each argument.
pub fn scintillation_at_zenith(aperture_m: f64, integration_s: f64, altitude_m: f64) -> f64 {
    let centimetres = 100.0 * aperture_m.max(PATTERN_M);
    0.09 * centimetres.powf(-2.0 / 3.0) * (-altitude_m.max(0.0) / 8000.0).exp() / (2.0 * integration_s).sqrt()
}

/// How far the ways of the wavelengths lie apart in the twinkling layer, in sizes of the pattern over sec² z tan z… the
/// shader multiplies by the air mass: h sec z · R₀ tan z (κ_λ − 1) / √(λ h).
///
/// `refraction_rad`: R₀, the deviation at 45°.  `ratio`: κ, of each wavelength to the second.
pub fn wavelength_shift(refraction_rad: f64, ratio: [f64; 4]) -> [f64; 4] {
    ratio.map(|k| LAYER_M * refraction_rad * (k - 1.0) / PATTERN_M)
}

/// Strength of scintillation at a wavelength: λ^(−7/12) relative to 550 nm   [dravins1997], for small apertures.
pub fn wavelength_strength(wavelengths_nm: [f64; 4]) -> [f64; 4] {
    wavelengths_nm.map(|nm| (nm / 550.0).powf(-7.0 / 12.0))
}

/// Phases of the eight waves of which scintillation is made, in turns, at a time. The waves have 0.5 … 1.4 times the
/// frequency that the integration time passes.
pub fn wave_phases(time_s: f64, integration_s: f64) -> [f64; 8] {
    const RATIOS: [f64; 8] = [0.5, 0.6180, 0.7321, 0.8284, 0.9439, 1.0631, 1.2361, std::f64::consts::SQRT_2];
    RATIOS.map(|ratio| (time_s * ratio / (2.0 * integration_s)).rem_euclid(1.0))
}

/// What scintillation makes of each wavelength's light: log-normal, mean 1. Twin of the shader's.
pub fn twinkle(seed: f64, sine: f64, sigma: f64, phases: &[f64; 8], shift: [f64; 4], strength: [f64; 4]) -> [f64; 4] {
    let mass = air_mass(sine);
    let across = (1.0 - sine * sine).max(0.0).sqrt();
    std::array::from_fn(|k| {
        let apart = shift[k] * mass * mass * across;
        let wave: f64 = (0..8)
            .map(|i| {
                let own = (seed * (0.754_877_666_2 + 0.569_840_291 * i as f64)).fract();
                (TAU * (phases[i] + own) + (0.5 + 0.125 * i as f64) * TAU * apart).cos()
            })
            .sum();
        // Saturation: strong scintillation does not pass 1.
        let deviation = (sigma * mass.powf(1.75)).min(1.0) * strength[k];
        let log_variance = (deviation * deviation).ln_1p();
        (0.5 * wave * log_variance.sqrt() - 0.5 * log_variance).exp()
    })
}

/// The thesis' core: T(l) = 2l³ − 3l² + 1   [mueller2012, §4.3.2].
pub fn thesis_core(l: f64) -> f64 {
    let x = l.min(1.0);
    1.0 + x * x * (2.0 * x - 3.0)
}

/// Its volume as a solid of revolution, 2π ∫ T(l) l dl. The thesis prints 1.167; it is 0.3π = 0.942.
pub const THESIS_CORE_VOLUME: f64 = 0.3 * PI;
/// c_q of the thesis, found by comparing pictures with photographs at m_a = 4.
const THESIS_CORE_SCALE: f64 = 4e-7;

/// Intensity I_T of the thesis' core for Δ_m = 1: c_q / (V_T q²), q = 2√2 tan(γ/2) / rows   [mueller2012, eqs. 4.22–4.23].
pub fn thesis_core_scale(tangent_per_row: f64) -> f64 {
    let q = 2.0 * 2f64.sqrt() * tangent_per_row;
    THESIS_CORE_SCALE / (THESIS_CORE_VOLUME * q * q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_core_keeps_flux_place_and_spread_wherever_it_lies() {
        for i in 0..40 {
            let x = f64::from(i) / 40.0;
            let moment =
                |power: i32| (-4..=4).map(|p| core_weight(f64::from(p) - x) * f64::from(p).powi(power)).sum::<f64>();
            assert!((moment(0) - 1.0).abs() < 1e-12 && (moment(1) - x).abs() < 1e-12);
            assert!((moment(2) - x * x - 1.0 / 3.0).abs() < 1e-12);
        }
    }

    /// Widened by s ≥ 1 its samples sum to 1 within 2 sinc⁴ s, at most 0.45 % (the first side lobe, s = 1.43).
    #[test]
    fn a_widened_core_keeps_its_flux() {
        for widen in [1.0, 1.1, 1.3, 1.5, 2.0, 2.7, 10.0] {
            for i in 0..20 {
                let x = f64::from(i) / 20.0;
                let sum: f64 = (-40..=40).map(|p| core_weight((f64::from(p) - x) / widen) / widen).sum();
                assert!((sum - 1.0).abs() < 4.6e-3, "{widen} {x}: {sum}");
            }
        }
    }

    #[test]
    fn glare_is_what_its_rings_sum_to() {
        for kind in [Glare::Eye, Glare::Lens] {
            let glare = glare_coefficients(kind);
            for (radius, soft) in [(0.08, 0.0015), (0.01, 0.0015), (0.003, 0.0004)] {
                let rings = 200_000;
                let sum: f64 = (0..rings)
                    .map(|i| {
                        let theta = radius * (f64::from(i) + 0.5) / f64::from(rings);
                        let value = glare_per_sr(glare, theta, soft) - glare_per_sr(glare, radius, soft);
                        TAU * theta * value * radius / f64::from(rings)
                    })
                    .sum();
                let closed = glare_share(glare, radius, soft);
                assert!((sum / closed - 1.0).abs() < 1e-4, "{kind:?} {radius}: {sum} {closed}");
                assert!((0.0..0.6).contains(&closed), "{kind:?} {radius}: {closed}");
            }
        }
        // The CIE's veil of a young eye: 10/θ² cd/m² a lux between 3° and 30° [vos1999].
        let veil = glare_per_sr(glare_coefficients(Glare::Eye), 10f64.to_radians(), GLARE_SOFT_RAD);
        assert!((veil / (10.0 / 100.0) - 1.0).abs() < 0.15, "{veil}");
    }

    /// Young's law for 1 m, 1 s at the zenith at sea level: 0.09 · 100^(−2/3) / √2 = 2.95e-3.
    #[test]
    fn scintillation_is_youngs() {
        assert!((scintillation_at_zenith(1.0, 1.0, 0.0) - 2.95e-3).abs() < 1e-5);
        let eye = scintillation_at_zenith(0.007, 0.05, 0.0);
        assert!((0.05..0.12).contains(&eye), "{eye}");
        assert!(scintillation_at_zenith(0.007, 0.05, 8000.0) < 0.4 * eye);
        assert_eq!(scintillation_at_zenith(0.007, 0.05, 4e5), eye * (-50f64).exp());
    }

    #[test]
    fn twinkling_has_mean_one_and_its_own_deviation() {
        let strength = wavelength_strength([630.0, 560.0, 490.0, 430.0]);
        for (sine, expected) in [(1.0f64, 0.1), (0.5, 0.1 * air_mass(0.5).powf(1.75))] {
            let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
            for star in 0..50 {
                let seed = (f64::from(star) * 0.618_033_988 + 0.5).fract();
                for step in 0..200 {
                    let phases = wave_phases(f64::from(step) * 0.083, 0.05);
                    let value = twinkle(seed, sine, 0.1, &phases, [0.0; 4], strength)[1];
                    assert!(value > 0.0);
                    (sum, squares, n) = (sum + value, squares + value * value, n + 1.0);
                }
            }
            let mean = sum / n;
            let deviation = (squares / n - mean * mean).sqrt();
            assert!((mean - 1.0).abs() < 0.02, "{mean}");
            assert!((deviation / expected - 1.0).abs() < 0.1, "{deviation} {expected}");
        }
    }

    #[test]
    fn the_thesis_core_has_its_volume() {
        let sum: f64 = (0..10_000).map(|i| (f64::from(i) + 0.5) / 1e4).map(|l| TAU * l * thesis_core(l) * 1e-4).sum();
        assert!((sum - THESIS_CORE_VOLUME).abs() < 1e-6, "{sum}");
    }
}
