//! Laws of whole atmospheres, and what each preset says about itself.

use himmel_air::light::{Surface, planck_w_m2_sr_nm};
use himmel_air::single::{Ray, march};
use himmel_air::{Columns, Medium, Preset, Profile, preset};
use himmel_core::constants::{ASTRONOMICAL_UNIT_M, SUN_RADIUS_M};
use himmel_core::spectrum::Spectrum;

fn scaled(spectrum: &Spectrum, factor: f64) -> Spectrum {
    match spectrum.clone() {
        Spectrum::Constant(value) => Spectrum::Constant(value * factor),
        Spectrum::Table { wavelength_nm, value } => {
            Spectrum::Table { wavelength_nm, value: value.iter().map(|v| v * factor).collect() }
        }
        Spectrum::PowerLaw { reference_nm, value, exponent } => {
            Spectrum::PowerLaw { reference_nm, value: value * factor, exponent }
        }
    }
}

/// The same atmosphere with every length `k` times as long.
fn enlarged(medium: &Medium, k: f64) -> Medium {
    let mut medium = medium.clone();
    medium.bottom_radius_m *= k;
    medium.top_altitude_m *= k;
    for component in &mut medium.components {
        component.scattering_per_m = scaled(&component.scattering_per_m, 1.0 / k);
        component.absorption_per_m = scaled(&component.absorption_per_m, 1.0 / k);
        component.profile = match &component.profile {
            Profile::Exponential { scale_height_m } => Profile::Exponential { scale_height_m: scale_height_m * k },
            Profile::Gaussian { centre_m, width_m } => {
                Profile::Gaussian { centre_m: centre_m * k, width_m: width_m * k }
            }
            Profile::Tent { bottom_m, peak_m, top_m } => {
                Profile::Tent { bottom_m: bottom_m * k, peak_m: peak_m * k, top_m: top_m * k }
            }
            other => other.clone(),
        };
    }
    medium
}

/// Metres to kilometres: radiance has no length in it. 1e-7: the floor of 1e-12 m in the table of columns is a length.
#[test]
fn a_larger_world_looks_the_same() {
    let medium = Preset::named("bruneton2017").unwrap().medium;
    let large = enlarged(&medium, 1000.0);
    let look = |medium: &Medium, altitude_m: f64| {
        let columns = Columns::new(medium);
        march(&medium.sampled(&[440.0, 680.0]), &columns, &Ray { altitude_m, mu: 0.1, mu_s: 0.05, nu: 0.6 }, 64)
            .radiance_per_sr
    };
    let (small, large) = (look(&medium, 20.0), look(&large, 20e3));
    for k in 0..2 {
        assert!((small[k] / large[k] - 1.0).abs() < 1e-7, "{small:?} {large:?}");
    }
}

/// Every phase function of every preset integrates to 1 at the renderer's wavelengths; every albedo lies in 0..=1.
#[test]
fn presets_obey_the_laws() {
    for name in preset::names() {
        let preset = Preset::named(name).unwrap();
        for component in &preset.medium.components {
            for nm in [430.0, 490.0, 560.0, 630.0] {
                assert!(component.scattering_per_m.at(nm) >= 0.0 && component.absorption_per_m.at(nm) >= 0.0);
                if let Some(phase) = &component.phase {
                    let moments = phase.legendre_moments(2, nm);
                    // 1e-6: the quadrature at g = 0.99 (`earth-mueller-clean`).
                    assert!(
                        (moments[0] - 1.0).abs() < 1e-6 && moments[1].abs() < 1.0,
                        "{name} {}: {moments:?}",
                        component.name
                    );
                }
            }
        }
        assert!(!preset.stars.is_empty() && !preset.title.is_empty(), "{name}");
    }
}

#[test]
fn presets_hold_what_they_say() {
    let depth = |preset: &str, component: &str, nm: f64| {
        let medium = Preset::named(preset).unwrap().medium;
        let c = medium.components.iter().find(|c| c.name == component).unwrap();
        (c.scattering_per_m.at(nm) + c.absorption_per_m.at(nm)) * c.profile.column_m(0.0, medium.top_altitude_m)
    };
    for (preset, component, stated, tolerance) in [
        ("mars", "dust", 0.5, 1e-3),
        ("mars-dusty", "dust", 2.0, 1e-3),
        ("venus", "clouds", 30.0, 1e-9),
        ("earth-urban", "aerosol", 0.643, 1e-3),
        ("earth-volcanic", "volcanic droplets", 0.15, 1e-9),
        ("earth-mueller-polluted", "aerosol", 20.0 * 2e-5 * 6e3, 1e-6),
        ("mars-collienne", "dust", 3e-6 * 3200.0, 1e-6),
    ] {
        let found = depth(preset, component, 550.0);
        assert!((found / stated - 1.0).abs() < tolerance, "{preset} {component}: {found}");
    }
    // The blue aureole: the forward peak of Martian dust is narrower in blue.
    let mars = Preset::named("mars").unwrap().medium;
    let dust = mars.components[1].phase.as_ref().unwrap();
    assert!(dust.mean_cosine(440.0) > dust.mean_cosine(640.0) + 0.1);
    // Less blue than red comes back from it: g(440) = 0.64 + 0.23 exp(-2.378e-5 130²).
    assert!((dust.mean_cosine(440.0) - (0.64 + 0.23 * (-2.378e-5f64 * 130.0 * 130.0).exp())).abs() < 1e-3);
}

/// The dwarf stands where it gives what the Sun gives the Earth, 1361 W/m² [iau2015b3]; 1 %: three digits of its distance.
#[test]
fn the_red_dwarf_warms_its_planet() {
    let star = &Preset::named("m-dwarf-ocean").unwrap().stars[0];
    let Surface::BlackBody { temperature_k } = star.surface else { panic!("{star:?}") };
    let (mut sum, mut nm) = (0.0, 100.0f64);
    while nm < 1e5 {
        sum += planck_w_m2_sr_nm(nm, temperature_k) * nm * 1e-3;
        nm *= 1.001;
    }
    let angle = star.radius_suns * SUN_RADIUS_M / (star.distance_au.unwrap() * ASTRONOMICAL_UNIT_M);
    let irradiance = std::f64::consts::PI * angle * angle * sum;
    assert!((irradiance / 1361.0 - 1.0).abs() < 0.01, "{irradiance}");
}
