//! What eyes do with light: rods and cones, thresholds, acuity, glare, adaptation. f64 twins of `output/eye.wgsl`.
//!
//! Photopic luminance is what cones see, scotopic luminance what rods see; both in cd m⁻², equal for light of 555 nm.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::{DMat3, DVec3};

use crate::colour::{Observer, rec709_from_xyz};
use crate::constants::{BOLTZMANN_J_K, PLANCK_J_S, SPEED_OF_LIGHT_M_S};
use crate::interpolate;
use crate::spectrum::read_columns;

/// Largest luminous efficacy of rods, lm/W: 683 / V′(555 nm) [cie1951].
pub const SCOTOPIC_EFFICACY_LM_W: f64 = 1700.0;

/// V′ at 555 nm, where both efficacies are 683 lm/W [cie191].
pub const SCOTOPIC_AT_555: f64 = 683.0 / 1699.0;

/// The retina's own light: below this luminance thresholds no longer fall, cd m⁻² [crumey2014, from Blackwell's data].
pub const EIGENGRAU_CD_M2: f64 = 1e-5;

/// V′(λ), the spectral luminous efficiency of rods [cie1951]; zero outside 380–780 nm.
pub fn scotopic_efficiency(wavelength_nm: f64) -> f64 {
    static TABLE: OnceLock<(Vec<f64>, Vec<f64>)> = OnceLock::new();
    let (nm, value) =
        TABLE.get_or_init(|| read_columns(include_str!("../../../assets/colour/cie1951_scotopic.csv"), 0, 1));
    if !(380.0..=780.0).contains(&wavelength_nm) {
        return 0.0;
    }
    interpolate::linear(nm, value, wavelength_nm)
}

/// Scotopic luminance (or illuminance) of a spectrum: 1700 lm/W · ∫ S(λ) V′(λ) dλ, every 5 nm.
pub fn scotopic_of(spectrum: impl Fn(f64) -> f64) -> f64 {
    let sum: f64 = (0..=80)
        .map(|i| {
            let nm = 380.0 + 5.0 * f64::from(i);
            let half = if i == 0 || i == 80 { 0.5 } else { 1.0 };
            half * scotopic_efficiency(nm) * spectrum(nm)
        })
        .sum();
    5.0 * SCOTOPIC_EFFICACY_LM_W * sum
}

/// Spectral radiance of a black body, without its constant factor.
fn planck(wavelength_nm: f64, temperature_k: f64) -> f64 {
    let metres = wavelength_nm * 1e-9;
    let x = PLANCK_J_S * SPEED_OF_LIGHT_M_S / (metres * BOLTZMANN_J_K * temperature_k);
    wavelength_nm.powi(-5) / x.exp_m1()
}

/// The row that gives scotopic luminance from linear Rec. 709 in cd m⁻².
///
/// Least squares of the relative error over black bodies of 1,500 to 40,000 K: no three numbers hold a spectrum, but
/// daylight, dusk, moonlight and stars are near that family. Errors: 0.3 % for illuminant A, −2.7 % for D65, 3 % for skies by
/// day, 6 % at sunset, up to 17 % in twilight, tens of per cent for lamps with lines (sodium: 67 %).
pub fn scotopic_from_rec709() -> DVec3 {
    static ROW: OnceLock<DVec3> = OnceLock::new();
    *ROW.get_or_init(|| {
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for i in 0..25 {
            let temperature_k = 1500.0 * (40_000.0f64 / 1500.0).powf(f64::from(i) / 24.0);
            let spectrum = |nm: f64| planck(nm, temperature_k);
            let rgb = rec709_from_xyz() * Observer::cie1931().xyz_of(spectrum) / scotopic_of(spectrum);
            normal += DMat3::from_cols(rgb * rgb.x, rgb * rgb.y, rgb * rgb.z);
            right += rgb;
        }
        normal.inverse() * right
    })
}

/// CIE 191's adaptation coefficient m and mesopic luminance: 1 for cones alone, 0 for rods alone [cie191].
///
/// m = 0.7670 + 0.3334 lg L_mes in 0..=1,
/// L_mes = (m L_p + (1 − m) L_s V′(555)) / (m + (1 − m) V′(555)), solved together from m = 0.5.
///
/// `photopic`, `scotopic`: luminances in cd m⁻². Of a pixel itself: adaptation is mostly local [uchida2017].
/// Laws tested: 1 from 5 cd m⁻² up, 0 from 0.005 down, rises between; the worked
/// values of the method.
pub fn mesopic(photopic: f64, scotopic: f64) -> (f64, f64) {
    let (p, s) = (photopic.max(0.0), scotopic.max(0.0));
    let mut m = 0.5;
    let luminance = |m: f64| (m * p + (1.0 - m) * s * SCOTOPIC_AT_555) / (m + (1.0 - m) * SCOTOPIC_AT_555);
    for _ in 0..MESOPIC_STEPS {
        m = (0.7670 + 0.3334 * luminance(m).max(1e-12).log10()).clamp(0.0, 1.0);
    }
    (m, luminance(m))
}

/// Steps of that iteration: for twice as much scotopic light as photopic each takes off nine tenths of the error.
pub const MESOPIC_STEPS: usize = 6;

/// The smallest luminance step that cones see on a background, cd m⁻² [ferwerda1996, from Ward's and Blackwell's data].
pub fn cone_threshold_cd_m2(background_cd_m2: f64) -> f64 {
    let x = background_cd_m2.max(1e-12).log10();
    10f64.powf(if x <= -2.6 {
        -0.72
    } else if x < 1.9 {
        (0.249 * x + 0.65).powf(2.7) - 0.72
    } else {
        x - 1.255
    })
}

/// The smallest step that rods see on a background, both scotopic, cd m⁻² [ferwerda1996].
pub fn rod_threshold_cd_m2(background_cd_m2: f64) -> f64 {
    let x = background_cd_m2.max(1e-12).log10();
    10f64.powf(if x <= -3.94 {
        -2.86
    } else if x < -1.44 {
        (0.405 * x + 1.6).powf(2.18) - 2.86
    } else {
        x - 0.395
    })
}

/// How many thresholds the background itself is bright, over what it is by day (18): the share of a display's middle grey
/// that it deserves. Rods and cones detect independently: their squares add.
///
/// Visibility is kept, not brightness: what can just be told apart in the world can just be told apart on the display, as in
/// [ferwerda1996]. Laws tested: 1 by day; falls with the light; 0 in the dark.
pub fn brightness(photopic: f64, scotopic: f64) -> f64 {
    let dark = EIGENGRAU_CD_M2;
    let (p, s) = (photopic.max(0.0), scotopic.max(0.0) + dark);
    let thresholds = f64::hypot(p / cone_threshold_cd_m2(p), s / rod_threshold_cd_m2(s));
    (thresholds / 10f64.powf(1.255)).min(1.0)
}

/// The finest grating that an eye resolves, cycles per degree: 17.25 arctan(1.4 lg L + 0.35) + 25.72
/// [ward1997, fitted to Shlaer's data].
///
/// Laws tested: rises; 50 by day, about 2 under the stars.
pub fn acuity_cycles_per_deg(background_cd_m2: f64) -> f64 {
    17.25 * (1.4 * background_cd_m2.max(1e-12).log10() + 0.35).atan() + 25.72
}

/// Light that a point of one lux at the eye spreads to an angle from it, sr⁻¹: the CIE's total glare function
/// [vos1999, cie146], its core included.
///
/// `angle_deg`: from the source, 0..=100.  `age_years`: of the eye; 25 is taken for the young.  `pigment`: 0 for the darkest
/// eyes, 0.5 for brown, 1 for blue, 1.2 for the palest.
/// Laws tested: integrates to 1 over the sphere within some per cent; falls; 10 θ⁻² between 3° and 30° [holladay1926].
pub fn glare_per_sr(angle_deg: f64, age_years: f64, pigment: f64) -> f64 {
    let age = (age_years / 70.0).powi(4);
    let t = angle_deg.max(0.0);
    let over = |width: f64| 1.0 + (t / width).powi(2);
    (1.0 - 0.08 * age) * (9.2e6 / over(0.0046).powf(1.5) + 1.5e5 / over(0.045).powf(1.5))
        + (1.0 + 1.6 * age)
            * (400.0 / over(0.1) + 3e-8 * t * t + pigment * (1300.0 / over(0.1).powf(1.5) + 0.8 / over(0.1).sqrt()))
        + 2.5e-3 * pigment
}

/// The share of a point's light that [`glare_per_sr`] keeps within an angle, of all that it spreads over 90°.
///
/// Laws tested: 0 at 0, 1 at 90°, rises.
pub fn encircled_glare(angle_deg: f64, age_years: f64, pigment: f64) -> f64 {
    let within = |to_deg: f64| -> f64 {
        // In the logarithm of the angle: the function spans ten decades. Below 1e-5° it is flat.
        const STEPS: usize = 400;
        let (low, high) = (1e-5f64.ln(), to_deg.max(1e-5).ln());
        let step = (high - low) / STEPS as f64;
        (0..STEPS)
            .map(|i| {
                let t = (low + (i as f64 + 0.5) * step).exp();
                glare_per_sr(t, age_years, pigment) * 2.0 * PI * t.to_radians().sin() * t.to_radians() * step
            })
            .sum()
    };
    if angle_deg <= 0.0 { 0.0 } else { (within(angle_deg.min(90.0)) / within(90.0)).clamp(0.0, 1.0) }
}

/// How fast an eye follows a change of light, s. `brighter`: whether the light has grown.
///
/// Rods and cones weigh as their sensitivity does, σ = 0.04 / (0.04 + L) [krawczyk2005]. Receptors and nerves follow within
/// 0.4 s and 0.1 s [durand2000]; `pigments`: in the dark, photopigments that light has bleached return within 400 s and 110 s
/// [pattanaik2000].
pub fn adaptation_seconds(luminance_cd_m2: f64, brighter: bool, pigments: bool) -> f64 {
    let rods = 0.04 / (0.04 + luminance_cd_m2.max(0.0));
    let [rod_s, cone_s] = if pigments && !brighter { [400.0, 110.0] } else { [0.4, 0.1] };
    rods * rod_s + (1.0 - rods) * cone_s
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Black bodies; illuminants by their tables are in tests/truth.
    #[test]
    fn scotopic_over_photopic() {
        let ratio = |temperature_k: f64| {
            let spectrum = |nm: f64| planck(nm, temperature_k);
            let photopic = Observer::cie1931().xyz_of(spectrum);
            let rods = scotopic_of(spectrum);
            let fitted = scotopic_from_rec709().dot(rec709_from_xyz() * photopic);
            println!("{temperature_k} K: S/P {:.3}, by Rec. 709 {:.3}", rods / photopic.y, fitted / photopic.y);
            assert!((fitted / rods - 1.0).abs() < 0.03);
            rods / photopic.y
        };
        assert!((ratio(2856.0) - 1.41).abs() < 0.01);
        assert!((ratio(6504.0) - 2.41).abs() < 0.06);
        assert!((SCOTOPIC_EFFICACY_LM_W * scotopic_efficiency(555.0) / 683.0 - 1.0).abs() < 2e-3);
    }

    #[test]
    fn mesopic_ends_where_cie_191_says() {
        assert!((mesopic(5.0, 5.0).0 - 1.0).abs() < 1e-4 && mesopic(0.005, 0.005).0 < 1e-3);
        assert_eq!(mesopic(100.0, 250.0), (1.0, 100.0));
        assert_eq!(mesopic(1e-4, 2e-4), (0.0, 2e-4));
        // Light of one colour keeps its luminance: m is the logarithm alone. 0.7670 at 1 cd m⁻², 0.4336 at 0.1.
        assert!((mesopic(1.0, 1.0).0 - 0.7670).abs() < 1e-9 && (mesopic(0.1, 0.1).0 - 0.4336).abs() < 1e-9);
        let mut last = -1.0;
        for i in 0..200 {
            let p = 1e-4 * 1.08f64.powi(i);
            let (m, seen) = mesopic(p, 2.3 * p);
            assert!(m >= last && seen >= p * 0.999 && seen <= 2.3 * p * 1.001);
            // The equation is solved.
            let again = (0.7670 + 0.3334 * seen.log10()).clamp(0.0, 1.0);
            assert!((again - m).abs() < 1e-4, "{p}: {m} {again}");
            last = m;
        }
        for bad in [f64::NAN, -1.0, 0.0] {
            assert!(mesopic(bad, bad).0 == 0.0);
        }
    }

    /// The branches of the published fits meet, brightness and acuity fall with the light.
    #[test]
    fn thresholds_and_acuity() {
        for (at, f) in [
            (-2.6, cone_threshold_cd_m2 as fn(f64) -> f64),
            (1.9, cone_threshold_cd_m2),
            (-3.94, rod_threshold_cd_m2),
            (-1.44, rod_threshold_cd_m2),
        ] {
            let (low, high) = (f(10f64.powf(at - 1e-6)), f(10f64.powf(at + 1e-6)));
            assert!((low / high).log10().abs() < 0.02, "{at}: {low} {high}");
        }
        let (mut bright, mut fine) = (0.0, 0.0);
        for i in 0..120 {
            let l = 1e-6 * 1.3f64.powi(i);
            let (b, a) = (brightness(l, 2.0 * l), acuity_cycles_per_deg(l));
            assert!(b >= bright * 0.999 && a >= fine && b <= 1.0, "{l}: {b} {bright}");
            (bright, fine) = (b, a);
        }
        assert_eq!(brightness(1000.0, 2400.0), 1.0);
        assert!((acuity_cycles_per_deg(1000.0) - 50.0).abs() < 2.0 && acuity_cycles_per_deg(1e-4) < 2.8);
        println!("brightness: moonlight {:.4}, stars {:.5}", brightness(0.01, 0.02), brightness(2e-4, 4e-4));
    }

    #[test]
    fn glare_keeps_all_light() {
        for pigment in [0.0, 0.5, 1.0] {
            let (mut sum, mut t) = (0.0, 1e-5f64);
            while t < 90.0 {
                let step = 1.01f64;
                let middle = t * step.sqrt();
                sum += glare_per_sr(middle, 25.0, pigment)
                    * 2.0
                    * PI
                    * middle.to_radians().sin()
                    * (t * (step - 1.0)).to_radians();
                t *= step;
            }
            println!("pigment {pigment}: {sum:.4}");
            assert!((sum - 1.0).abs() < 0.06, "pigment {pigment}: {sum}");
        }
        for degrees in [4.0, 10.0, 25.0] {
            let holladay = 10.0 / f64::powi(degrees, 2);
            assert!((glare_per_sr(degrees, 25.0, 0.5) / holladay - 1.0).abs() < 0.4, "{degrees}");
        }
        assert_eq!((encircled_glare(0.0, 25.0, 0.5), encircled_glare(90.0, 25.0, 0.5)), (0.0, 1.0));
        assert!(encircled_glare(0.1, 25.0, 0.5) < encircled_glare(1.0, 25.0, 0.5));
    }

    #[test]
    fn darkness_takes_longer_than_light() {
        assert!((adaptation_seconds(1000.0, true, true) - 0.1).abs() < 1e-3);
        assert!((adaptation_seconds(1e-4, false, true) - 400.0).abs() < 1.0);
        assert!((adaptation_seconds(1e-4, false, false) - 0.4).abs() < 1e-2);
    }
}
