//! How bright the Moon's ground is over the phase: Allen's law, and the laws of Hapke, Lommel and Seeliger that Müller 2012
//! writes down. φ is the phase angle everywhere: Sun–Moon–observer, 0 at full Moon.

use std::f64::consts::{FRAC_PI_2, PI};

use super::illuminance_lx;
use super::magnitude::{Circumstances, planet_magnitude};
use crate::body::Body;
use crate::constants::AU_M;

/// Surface density of the Moon's ground, g of [`opposition_surge`]   [hapke1966]
pub const SURFACE_DENSITY: f64 = 0.6;
/// Strength of forward scattering, t of [`forward_scattering`]   [hapke1966]
pub const FORWARD: f64 = 0.1;
/// Largest phase angle of Allen's law that is used: beyond, few crescents were measured, and its polynomial falls more slowly
/// than the lit part of the disc.
pub const LAST_PHASE_RAD: f64 = 150.0 * PI / 180.0;

/// sin x tan x ln cot(x/2), continued to 0 at 0 and to 1 at π/2.
fn crescent(x: f64) -> f64 {
    if x < 1e-9 {
        return 0.0;
    }
    if FRAC_PI_2 - x < 1e-6 {
        return 1.0;
    }
    x.sin() * x.tan() * (1.0 / (0.5 * x).tan()).ln()
}

/// Light of a sphere whose ground shines as µ₀/(µ₀ + µ), relative to the full one.
///
/// 1 − sin(φ/2) tan(φ/2) ln cot(φ/4)   [seeliger1887]
///
/// Laws tested: 1 at 0, 0 at π; the sum over the disc.
pub fn lommel_seeliger_disc(phase_rad: f64) -> f64 {
    1.0 - crescent(0.5 * phase_rad.clamp(0.0, PI))
}

/// Extra brightness near full: shadows hide behind the grains that cast them.
///
/// B(φ, g) = 2 − tan φ/(2g) · (1 − e^(−g/tan φ)) (3 − e^(−g/tan φ)) for φ < π/2, else 1   [hapke1966; mueller2012, eq. 4.6]
///
/// Laws tested: B(0) = 2; continuous at π/2; falls.
pub fn opposition_surge(phase_rad: f64, density: f64) -> f64 {
    let tangent = phase_rad.abs().tan();
    if phase_rad.abs() >= FRAC_PI_2 || !(tangent > 0.0 && density > 0.0) {
        return if phase_rad == 0.0 { 2.0 } else { 1.0 };
    }
    let e = (-density / tangent).exp();
    2.0 - tangent / (2.0 * density) * (1.0 - e) * (3.0 - e)
}

/// How a patch of ground scatters over the phase.
///
/// S(φ) = ½ (1 − sin(φ/2) tan(φ/2) ln cot(φ/4) + t (1 − cos φ)²),   S(π) = 2t   [hapke1966; mueller2012, eq. 4.7]
///
/// Laws tested: ½ at 0; the limit at π.
pub fn forward_scattering(phase_rad: f64, forward: f64) -> f64 {
    let phase_rad = phase_rad.clamp(0.0, PI);
    0.5 * (lommel_seeliger_disc(phase_rad) + forward * (1.0 - phase_rad.cos()).powi(2))
}

/// Irradiance of the Moon by the Earth, W m⁻².
///
/// E_em(φ) = 0.19/2 · (1 − sin x tan x ln cot(x/2)), x = (π − φ)/2   [hulst1980; mueller2012, eq. 4.9]
///
/// Laws tested: 0 at φ = 0, where x = π/2; 0.095 at φ = π.
pub fn earthshine_w_m2(phase_rad: f64) -> f64 {
    0.095 * (1.0 - crescent(0.5 * (PI - phase_rad.clamp(0.0, PI))))
}

/// Its short form: −0.0061 φ³ + 0.0289 φ² − 0.0105 sin φ   [mueller2012, eq. 4.10], 0 where that is negative (φ < 22°).
pub fn earthshine_short_w_m2(phase_rad: f64) -> f64 {
    let p = phase_rad.clamp(0.0, PI);
    (-0.0061 * p.powi(3) + 0.0289 * p * p - 0.0105 * p.sin()).max(0.0)
}

/// Colour of the Moon's ground: k_r(λ) = −0.27063 + 2.6175e-3 λ − 1.2673e-6 λ²   [pieters1999; mueller2012, eq. 4.11]; λ in nm.
pub fn thesis_reflectance(wavelength_nm: f64) -> f64 {
    (-0.27063 + 2.6175e-3 * wavelength_nm - 1.2673e-6 * wavelength_nm * wavelength_nm).max(0.0)
}

/// B − V of the Moon, and of the Sun   [allen1973; ramirez2012]
pub const MOON_B_V: f64 = 0.92;
const SUN_B_V: f64 = 0.653;

/// Colour of the Moon's ground: reflectance relative to that at 550 nm, so that sunlight reddens from the Sun's B − V to the
/// Moon's: 10^(0.4 · 0.267 (λ − 550 nm)/110 nm), which stays straight in the logarithm from 400 to 700 nm as measured
/// (slope within 15 %) [kieffer2005].
pub fn moon_reflectance(wavelength_nm: f64) -> f64 {
    10f64.powf(0.4 * (MOON_B_V - SUN_B_V) * (wavelength_nm.clamp(380.0, 780.0) - 550.0) / 110.0)
}

/// Colour of the Earth's light on the Moon relative to sunlight: 0.88, 0.96, 1.00 at 680, 550, 440 nm   [mueller2012, §4.1.2]
pub fn earthlight_colour(wavelength_nm: f64) -> f64 {
    let x = wavelength_nm.clamp(440.0, 680.0);
    if x < 550.0 { 1.0 - 0.04 * (x - 440.0) / 110.0 } else { 0.96 - 0.08 * (x - 550.0) / 130.0 }
}

/// Illuminance of the Moon's ground by the Earth in its zenith, lx   [mallama2018]. `phase_rad`: Sun–Earth–Moon.
pub fn earthlight_lx(phase_rad: f64, sun_distance_m: f64, moon_distance_m: f64) -> f64 {
    magnitude_lx(Body::Earth, phase_rad, sun_distance_m, moon_distance_m)
}

/// Illuminance by the Sun on the scale of magnitudes, lx: what the other illuminances here are to be compared with.
pub fn sunlight_lx(sun_distance_m: f64) -> f64 {
    magnitude_lx(Body::Sun, 0.0, 0.0, sun_distance_m)
}

/// The Sun's irradiance at 1 au, W m⁻²: the IAU's nominal value of 2015.
pub const SOLAR_CONSTANT_W_M2: f64 = 1361.0;

fn allen_lx(phase_rad: f64, sun_distance_m: f64, distance_m: f64) -> f64 {
    magnitude_lx(Body::Moon, phase_rad, sun_distance_m, distance_m)
}

fn magnitude_lx(body: Body, phase_rad: f64, sun_distance_m: f64, distance_m: f64) -> f64 {
    illuminance_lx(planet_magnitude(
        body,
        &Circumstances {
            sun_distance_au: sun_distance_m / AU_M,
            distance_au: distance_m / AU_M,
            phase_angle_deg: phase_rad.to_degrees(),
            sun_latitude_deg: 0.0,
            observer_latitude_deg: 0.0,
            year: 2000.0,
        },
    ))
}

/// Illuminance by the Moon above the air, lx: Allen's law with the opposition surge, as [`Body::Moon`]'s magnitude; beyond
/// [`LAST_PHASE_RAD`] it follows the shape of [`lommel_seeliger_disc`] times [`forward_scattering`].
///
/// Laws tested: continuous; 0 at π; within 10 % of Allen's from 5° to 150°; full Moons are 0.32 lx within 5 %.
pub fn moon_illuminance_lx(phase_rad: f64, sun_distance_m: f64, distance_m: f64) -> f64 {
    let phase_rad = phase_rad.clamp(0.0, PI);
    let measured = phase_rad.min(LAST_PHASE_RAD);
    let shape = |phase_rad: f64| lommel_seeliger_disc(phase_rad) * forward_scattering(phase_rad, FORWARD);
    allen_lx(measured, sun_distance_m, distance_m) * shape(phase_rad) / shape(measured)
}

/// The same by the thesis: B S over the disc of [`lommel_seeliger_disc`], as bright at φ = 0 as Allen's law without surge.
///
/// It is 10 % below Allen's law at 40° and twice as bright at 150°.
pub fn thesis_illuminance_lx(phase_rad: f64, sun_distance_m: f64, distance_m: f64) -> f64 {
    let phase_rad = phase_rad.clamp(0.0, PI);
    let full = allen_lx(0.0, sun_distance_m, distance_m) / super::moon_surge(0.0);
    // B(0) S(0) = 1.
    full * opposition_surge(phase_rad, SURFACE_DENSITY)
        * forward_scattering(phase_rad, FORWARD)
        * lommel_seeliger_disc(phase_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEAN: (f64, f64) = (AU_M, 384_400e3);

    fn degrees(x: f64) -> f64 {
        x.to_radians()
    }

    #[test]
    fn the_thesis_functions_and_their_limits() {
        let b = |phase: f64| opposition_surge(phase, SURFACE_DENSITY);
        assert_eq!(b(0.0), 2.0);
        assert!(
            (b(1e-7) - 2.0).abs() < 1e-6
                && (b(FRAC_PI_2 - 1e-7) - 1.0).abs() < 1e-6
                && b(FRAC_PI_2) == 1.0
                && b(3.0) == 1.0
        );
        // By hand at 40°: tan = 0.8391, e^(−0.6/0.8391) = 0.4892.
        assert!((b(degrees(40.0)) - (2.0 - 0.8391 / 1.2 * 0.5108 * 2.5108)).abs() < 1e-3);
        let s = |phase: f64| forward_scattering(phase, FORWARD);
        assert!((s(0.0) - 0.5).abs() < 1e-15 && (s(PI) - 0.2).abs() < 1e-12 && (s(PI - 1e-5) - 0.2).abs() < 1e-6);
        // By hand at 150°: sin 75° tan 75° ln cot 37.5° = 0.9546.
        assert!((s(degrees(150.0)) - 0.5 * (0.0454 + 0.3482)).abs() < 1e-3);
        assert_eq!(earthshine_w_m2(0.0), 0.0);
        assert!((earthshine_w_m2(PI) - 0.095).abs() < 1e-15 && earthshine_w_m2(1e-7).abs() < 1e-6);
        assert_eq!(earthshine_short_w_m2(0.2), 0.0);
        let mut worst: f64 = 0.0;
        for i in 0..=180 {
            let phase = degrees(f64::from(i));
            worst = worst.max((earthshine_w_m2(phase) - earthshine_short_w_m2(phase)).abs());
            if i > 0 {
                let before = degrees(f64::from(i - 1));
                assert!(b(phase) <= b(before) && earthshine_w_m2(phase) >= earthshine_w_m2(before));
            }
        }
        // The thesis says 3 % (of the largest).
        assert!(worst < 0.03 * 0.095 + 1e-4, "{worst}");
        let [r, g, bl] = [680.0, 550.0, 440.0].map(thesis_reflectance);
        assert!((r - 0.92).abs() < 0.01 && (g - 0.79).abs() < 0.01 && (bl - 0.64).abs() < 0.01, "{r} {g} {bl}");
    }

    /// The closed form against the sum over the disc, 1e-4 of the full one.
    #[test]
    fn the_disc_is_the_sum_of_its_ground() {
        for phase_deg in [0.0, 30.0, 90.0, 150.0] {
            let (sin, cos) = degrees(phase_deg).sin_cos();
            let n = 1500;
            let mut sum = 0.0;
            for i in 0..n * n {
                let [x, y] = [i % n, i / n].map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
                let mu_2 = 1.0 - x * x - y * y;
                if mu_2 > 0.0 {
                    let mu = mu_2.sqrt();
                    let mu_0 = (x * sin + mu * cos).max(0.0);
                    sum += mu_0 / (mu_0 + mu) * 4.0 / f64::from(n * n);
                }
            }
            assert!((sum / FRAC_PI_2 - lommel_seeliger_disc(degrees(phase_deg))).abs() < 3e-4, "{phase_deg}");
        }
    }

    #[test]
    fn the_law_is_allens() {
        for phase_deg in (5..=150).map(f64::from) {
            let allen = illuminance_lx(-12.73 + 0.026 * phase_deg + 4e-9 * f64::powi(phase_deg, 4));
            let ours = moon_illuminance_lx(degrees(phase_deg), MEAN.0, MEAN.1);
            assert!((ours / allen - 1.0).abs() < 0.1 + 1e-9, "{phase_deg}: {}", ours / allen);
        }
        let at = |phase_deg: f64| moon_illuminance_lx(degrees(phase_deg), MEAN.0, MEAN.1);
        assert!((at(150.1) / at(149.9) - 1.0).abs() < 0.02 && at(180.0) < 1e-12);
        let thesis = |phase_deg: f64| {
            let allen = illuminance_lx(-12.73 + 0.026 * phase_deg + 4e-9 * f64::powi(phase_deg, 4));
            thesis_illuminance_lx(degrees(phase_deg), MEAN.0, MEAN.1) / allen
        };
        println!("thesis over Allen: 40° {:.3}, 150° {:.2}", thesis(40.0), thesis(150.0));
        assert!(
            (thesis(0.0) - 1.0).abs() < 1e-9 && (thesis(40.0) - 0.9).abs() < 0.01 && (thesis(150.0) - 2.1).abs() < 0.1
        );
    }

    /// Oppositions that are no eclipses have the Moon 1.5° to 5.1° off the ecliptic, evenly over its node's angle: the mean
    /// full Moon at mean distance is 0.32 lx (Allen's −12.74) within 5 %.
    #[test]
    fn full_moons_have_their_light() {
        let angles: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.09 + 0.045).collect();
        let phases = angles.iter().map(|f| 5.145 * degrees(*f).sin()).filter(|phase| *phase > 1.5);
        let light: Vec<f64> = phases.map(|phase| moon_illuminance_lx(degrees(phase), MEAN.0, MEAN.1)).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        println!("mean full Moon {mean:.4} lx");
        assert!((mean / 0.32 - 1.0).abs() < 0.05, "{mean}");
    }
}
