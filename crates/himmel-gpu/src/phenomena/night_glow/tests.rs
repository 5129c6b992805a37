//! Laws of the night's f64 model.

use std::sync::Arc;

use glam::{DMat3, DVec3, DVec4};
use himmel_air::{AirParams, Atmosphere, GroundParams, Preset};

use super::*;

fn earth() -> Atmosphere {
    atmosphere("earth", &AirParams::default())
}

fn atmosphere(preset: &str, air: &AirParams) -> Atmosphere {
    Atmosphere::new(&Preset::named(preset).unwrap(), air, &GroundParams::default())
}

fn night(atmosphere: &Atmosphere, settings: &NightSettings, altitude_m: f64) -> NightGlow {
    let table = Arc::new(zodiacal::four_table(atmosphere.wavelengths_nm()));
    // The Sun below the feet, the ecliptic along the meridian.
    let ecliptic = DMat3::from_cols(DVec3::NEG_Z, DVec3::Y, DVec3::X).transpose();
    NightGlow::new(atmosphere, settings, None, table, [DMat3::IDENTITY, ecliptic], [altitude_m, 0.0])
}

/// Colours come back as they are, and the Sun's own light is even.
#[test]
fn four_wavelengths_show_the_colour() {
    let air = earth();
    let rows = air.rec709_from_four();
    let columns = four_from_rec709(&rows);
    let four = |rgb: DVec3| (0..3).fold(DVec4::ZERO, |sum, c| sum + columns[c] * rgb[c]);
    for rgb in [DVec3::ONE, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.9, 0.5, 0.1)] {
        let back = DVec3::from_array(rows.map(|row| row.dot(four(rgb))));
        assert!((back - rgb).abs().max_element() < 1e-9, "{rgb} {back}");
    }
    let sun = DVec3::from_array(rows.map(|row| row.dot(DVec4::ONE)));
    assert!((four(sun) - DVec4::ONE).abs().max_element() < 1e-9);
    // Airglow and lamps: no wavelength is negative.
    for xyz in [airglow::xyz_cd_m2(), pollution::xyz(Lamp::Sodium), pollution::xyz(Lamp::Led)] {
        let rgb = himmel_core::colour::rec709_from_xyz() * xyz / xyz.y;
        let four = four_of_light(&rows, rgb);
        println!("{:.3}", four * rows[1].dot(DVec4::ONE));
        let back = DVec3::from_array(rows.map(|row| row.dot(four)));
        assert!((back - rgb).abs().max_element() < 1e-9 && four.min_element() >= 0.0, "{four}");
    }
}

/// By reciprocity an even sky shows on a line of sight what a Sun along it would send to the ground: the formula against the
/// moments of all orders of the same air.
#[test]
fn diffuse_transmission_is_that_of_the_moments() {
    let air = earth();
    let moments = air.scene_light().moments();
    let albedo = air.sampled().ground_albedo;
    let depth = air.extended_transmittance(0.0, 1.0).map(|t| -t.ln());
    for degrees in [90.0, 60.0, 40.0, 25.0, 15.0f64] {
        let mu = degrees.to_radians().sin();
        let through = air.extended_transmittance(0.0, mu);
        let law = moments.ground_irradiance(air.columns(), mu);
        for k in 0..4 {
            let ours = through[k] + diffuse_transmission(mu, through[k], depth[k], albedo[k]);
            let exact = law[k] / mu;
            println!("{degrees}° {k}: T′ {:.3}, with diffuse {ours:.3}, moments {exact:.3}", through[k]);
            // At the first two wavelengths ozone's absorption counts as scattering.
            let limit = if k < 2 { 0.08 } else { 0.03 };
            assert!((ours / exact - 1.0).abs() < limit, "{degrees}° {k}");
        }
    }
}

#[test]
fn without_air_nothing_is_scattered_and_nothing_lost() {
    let air = atmosphere("earth", &AirParams { enabled: false, ..AirParams::default() });
    let settings = NightSettings {
        light_pollution: LightPollutionParams { bortle: Some(9), ..Default::default() },
        ..NightSettings::default()
    };
    let parts = night(&air, &settings, 2.0).parts(&air, 2.0, DVec3::Z, 0);
    assert_eq!((parts.scattered, parts.pollution), ([0.0; 4], [0.0; 4]));
    let luminance = |four: [f64; 4]| air.xyz(four).y / S10_CD_M2;
    assert!((luminance(parts.airglow) - 145.0).abs() < 0.2, "{}", luminance(parts.airglow));
    // The gegenschein at the zenith: 180 S10 at 500 nm, 2 to 4 % more at the eye's wavelengths.
    assert!((180.0..190.0).contains(&luminance(parts.zodiacal)), "{}", luminance(parts.zodiacal));
}

/// Light of cities has the zenith luminance that was asked for, and is 2 to 4 times as bright at the horizon.
#[test]
fn cities_brighten_the_horizon() {
    let air = earth();
    let settings = NightSettings {
        light_pollution: LightPollutionParams { zenith_mcd_m2: 3.0, ..Default::default() },
        ..NightSettings::default()
    };
    let night = night(&air, &settings, 0.0);
    let at = |degrees: f64| {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        air.xyz(night.parts(&air, 0.0, DVec3::new(0.0, cos, sin), 0).pollution).y
    };
    println!("{:.2e} {:.2e} {:.2e} {:.2e}", at(90.0), at(30.0), at(10.0), at(1.0));
    assert!((at(90.0) / 3e-3 - 1.0).abs() < 1e-6);
    assert!((2.0..4.0).contains(&(at(10.0) / at(90.0))) && (2.0..4.0).contains(&(at(1.0) / at(90.0))));
}

/// Airglow of dark sites is brightest some 10° above the horizon: van Rhijn's increase against extinction [leinert1998, section 6].
#[test]
fn airglow_is_brightest_above_the_horizon() {
    let air = earth();
    let night = night(&air, &NightSettings::default(), 0.0);
    let at = |degrees: f64| {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        air.xyz(night.parts(&air, 0.0, DVec3::new(0.0, cos, sin), 0).airglow).y
    };
    let brightest = (1..90).max_by(|a, b| at(f64::from(*a)).total_cmp(&at(f64::from(*b)))).unwrap();
    println!("{brightest}°, {:.2} of the zenith", at(f64::from(brightest)) / at(90.0));
    assert!((8..30).contains(&brightest));
}

/// Nothing jumps on the way to orbit, and all is finite anywhere.
#[test]
fn from_the_ground_to_far_away() {
    let air = earth();
    for altitude_m in [0.0, 2e3, 3e4, 8.9e4, 9.1e4, 4e5, 4e7, 4e8] {
        let night = night(&air, &NightSettings::default(), altitude_m);
        for i in 0..=180 {
            let (sin, cos) = f64::from(i).to_radians().sin_cos();
            let sum = night.parts(&air, altitude_m, DVec3::new(sin, 0.0, cos), 0).sum();
            assert!(sum.iter().all(|s| s.is_finite() && *s > -1e-12), "{altitude_m} {i} {sum:?}");
        }
    }
    // Other planets have no lines of oxygen.
    let mars = atmosphere("mars", &AirParams::default());
    assert_eq!(self::night(&mars, &NightSettings::default(), 0.0).airglow, [0.0; 4]);
}
