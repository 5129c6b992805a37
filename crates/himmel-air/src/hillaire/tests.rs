//! Laws of the approximation; what its model costs is measured against the tracer elsewhere.

use himmel_core::spectrum::Spectrum;

use super::*;
use crate::medium::Component;
use crate::single::march;
use crate::{Phase, Preset, Profile};

/// Converged enough for laws, in a tenth of the time.
const QUICK: Settings = Settings { suns: 32, altitudes: 16, azimuths: 2, ..Settings::CONVERGED };

/// A ray and Sun by angles in degrees.
fn ray(altitude_m: f64, view_zenith_deg: f64, sun_zenith_deg: f64, azimuth_deg: f64) -> Ray {
    let (z, s) = (view_zenith_deg.to_radians(), sun_zenith_deg.to_radians());
    let nu = z.sin() * s.sin() * azimuth_deg.to_radians().cos() + z.cos() * s.cos();
    Ray { altitude_m, mu: z.cos(), mu_s: s.cos(), nu }
}

const THICKNESS_M: f64 = 10_000.0;

/// Even air over black ground on a planet so large that it is flat.
fn slab(optical_thickness: f64, albedo: f64) -> Medium {
    let extinction = optical_thickness / THICKNESS_M;
    Medium {
        bottom_radius_m: 1e11,
        top_altitude_m: THICKNESS_M,
        components: vec![Component {
            name: "even".into(),
            profile: Profile::Table { altitude_m: vec![0.0, 2.0 * THICKNESS_M], value: vec![1.0, 1.0] },
            scattering_per_m: Spectrum::Constant(extinction * albedo),
            absorption_per_m: Spectrum::Constant(extinction * (1.0 - albedo)),
            refractivity: Spectrum::Constant(0.0),
            phase: Some(Phase::HenyeyGreenstein { g: Spectrum::Constant(0.0) }),
            amount: 1.0,
        }],
        ground_albedo: Spectrum::Constant(0.0),
    }
}

/// ∫ f(µ) dµ over 0..1 for functions with exp(−τ/µ) in them: µ = x² crowds nodes where they are steep.
fn over_mu(f: impl Fn(f64) -> f64) -> f64 {
    gauss_legendre_unit(400).iter().map(|(x, w)| w * 2.0 * x * f(x * x)).sum()
}

/// E₂(τ) = ∫ exp(−τ/µ) dµ.
fn e2(tau: f64) -> f64 {
    over_mu(|mu| (-tau / mu).exp())
}

#[test]
fn a_slab_has_its_closed_transfer_and_second_order() {
    for (tau_0, albedo) in [(0.3, 1.0), (2.0, 1.0), (2.0, 0.8), (20.0, 1.0)] {
        let medium = slab(tau_0, albedo);
        let air = medium.sampled(&[550.0]);
        let columns = Columns::new(&medium);
        // 1500 steps: what is left of steps must not hide a wrong formula. 4000 altitudes: the columns of even air end
        // in a cliff that the usual tables are not made for.
        let settings = Settings {
            transmittance: Some(TransmittanceTable { width: 2, height: 4000, steps: 1 }),
            direction_steps: 1500,
            suns: 2,
            altitudes: 9,
            zeniths: 64,
            azimuths: 1,
            ..Settings::CONVERGED
        };
        let table = Hillaire::build(&air, &columns, &settings);
        for v in [0.0, 0.5, 0.75, 1.0f64] {
            let altitude_m = v * v * THICKNESS_M;
            let tau = tau_0 * (1.0 - v * v);
            let expected = 0.5 * albedo * (2.0 - e2(tau) - e2(tau_0 - tau));
            let f_ms = table.transfer_at(altitude_m)[0];
            assert!((0.0..1.0).contains(&f_ms) && (f_ms / expected - 1.0).abs() < 2e-3, "{tau_0}: {f_ms} {expected}");

            // Light that the beam of a Sun overhead leaves along a ray up, and along one down. (Overhead, because the
            // tables' directions have no room for a planet so flat.)
            let mu_s = 1.0f64;
            let up = |mu: f64| mu_s / (mu_s - mu) * ((-tau / mu_s).exp() - (-tau / mu).exp());
            let down =
                |mu: f64| mu_s / (mu_s + mu) * ((-tau / mu_s).exp() - (-(tau_0 - tau) / mu - tau_0 / mu_s).exp());
            let second = albedo / (4.0 * PI) * 0.5 * over_mu(|mu| up(mu) + down(mu));
            let directions = directions(&medium, altitude_m, &settings);
            let ours = second_order(&air, &columns, &table.sun, altitude_m, mu_s, &directions, &settings)[0];
            assert!((ours / second - 1.0).abs() < 2e-3, "{tau_0} {albedo} at {tau}: {ours} {second}");
        }
    }
}

/// Ψ_ms at a node is the sum of its orders: L_2nd (1 + f + f² + …).
#[test]
fn orders_are_a_geometric_series() {
    let medium = slab(2.0, 1.0);
    let air = medium.sampled(&[550.0]);
    let columns = Columns::new(&medium);
    let table = Hillaire::build(&air, &columns, &QUICK);
    let mu_s = table.axes.mu_s(1.0, 0.0);
    let (mut order, mut sum) =
        (second_order(&air, &columns, &table.sun, 0.0, mu_s, &directions(&medium, 0.0, &QUICK), &QUICK)[0], 0.0);
    for _ in 0..200 {
        sum += order;
        order *= table.transfer_at(0.0)[0];
    }
    let psi = table.multiple_at(0.0, mu_s)[0];
    assert!((psi / sum - 1.0).abs() < 1e-9, "{psi} {sum}");
}

/// The table's coordinates invert; the axes of the Sun end at the zenith.
#[test]
fn coordinates_invert() {
    let medium = Preset::named("earth").unwrap().medium;
    for placement in [Placement::Paper, Placement::Crowded] {
        let axes = Axes::new(&medium, placement);
        for i in 0..=20 {
            for j in 0..=20 {
                let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let altitude_m = axes.altitude_m(v);
                let (u2, v2) = axes.coordinates(altitude_m, axes.mu_s(u, altitude_m));
                // At the zenith the sine is flat.
                let tolerance = if i == 20 { 1e-6 } else { 1e-9 };
                assert!((u - u2).abs() < tolerance && (v - v2).abs() < 1e-12, "{placement:?} {u} {v}: {u2} {v2}");
            }
        }
    }
}

#[test]
fn directions_weigh_one() {
    let medium = Preset::named("earth").unwrap().medium;
    for settings in [Settings::USUAL, Settings::CONVERGED] {
        for altitude_m in [0.0, 1000.0, medium.top_altitude_m] {
            let directions = directions(&medium, altitude_m, &settings);
            let (sum, mean) = directions.iter().fold((0.0, 0.0), |(a, b), (mu, w)| (a + w, b + w * mu));
            assert!((sum - 1.0).abs() < 1e-12 && mean.abs() < 1e-12 && directions.len() == settings.zeniths);
        }
    }
}

/// The first order is the march's, by day, in twilight and from space, and so is the air before the ground.
#[test]
fn single_scattering_is_the_march() {
    let preset = Preset::named("bruneton2017").unwrap();
    let columns = Columns::new(&preset.medium);
    let air = preset.medium.sampled(&[680.0, 440.0]);
    let tiny = Settings { suns: 2, altitudes: 2, zeniths: 2, azimuths: 1, direction_steps: 4, ..Settings::CONVERGED };
    let table = Hillaire::build(&air, &columns, &Settings { frame_steps: 3000, ..tiny });
    for (sun, altitude_m) in [(30.0, 0.0), (80.0, 2000.0), (94.0, 0.0), (97.0, 0.0), (60.0, 400_000.0)] {
        for view in [5.0, 75.0, 89.8, 100.0, 109.0] {
            for azimuth in [0.0, 180.0] {
                let ray = ray(altitude_m, view, sun, azimuth);
                let (ours, exact) = (table.parts(&air, &columns, &ray), march(&air, &columns, &ray, 3000));
                // The march takes 12 steps through the shadow, whatever it is asked for, which costs up to 1.6 % here;
                // with 1200 all these rays agree to 1e-4.
                let tolerance = if sun > 90.0 { 2e-2 } else { 1e-4 };
                for k in 0..2 {
                    let (a, b) = (ours.single[k], exact.radiance_per_sr[k]);
                    assert!((a - b).abs() < tolerance * b + 1e-9, "Sun {sun} view {view} from {altitude_m}: {a} {b}");
                    let ground = exact.ground_mu_s.map_or(0.0, |mu_s| {
                        let sun = sun_transmittance(&air, &columns, 0.0, mu_s)[k];
                        exact.transmittance[k] * 0.1 / PI * mu_s.max(0.0) * sun
                    });
                    assert!((ours.ground[k] - ground).abs() <= tolerance * ground, "{} {ground}", ours.ground[k]);
                }
            }
        }
    }
}

/// Air that only absorbs shows the ground through it and nothing else; no air at all shows albedo/π µ_s.
#[test]
fn where_nothing_scatters_nothing_is_multiple() {
    let mut medium = slab(0.5, 0.0);
    medium.ground_albedo = Spectrum::Constant(0.3);
    let down = Ray { altitude_m: THICKNESS_M, mu: -1.0, mu_s: 1.0, nu: -1.0 };
    for (amount, through) in [(1.0, (-0.5 - 0.5f64).exp()), (0.0, 1.0)] {
        medium.components[0].amount = amount;
        let air = medium.sampled(&[550.0]);
        let columns = Columns::new(&medium);
        for settings in [Settings::USUAL, QUICK] {
            let table = Hillaire::build(&air, &columns, &settings);
            let parts = table.parts(&air, &columns, &down);
            assert_eq!((parts.single[0], parts.multiple[0], table.transfer_at(0.0)[0]), (0.0, 0.0, 0.0));
            let expected = 0.3 / PI * through;
            if amount == 0.0 {
                // Half of what a point on the ground sees is lit ground.
                let psi = table.multiple_at(0.0, 1.0)[0];
                assert!((psi / (0.5 * expected) - 1.0).abs() < 1e-9, "{psi}");
            }
            assert!((parts.ground[0] / expected - 1.0).abs() < 1e-3, "{} {expected}", parts.ground[0]);
            assert_eq!(table.radiance(&air, &columns, &Ray { mu: 0.7, nu: 0.7, ..down })[0], 0.0);
        }
    }
}

#[test]
fn a_component_of_no_density_changes_nothing() {
    let preset = Preset::named("bruneton2017").unwrap();
    let mut more = preset.medium.clone();
    let mut nothing = more.components[1].clone();
    nothing.amount = 0.0;
    more.components.push(nothing);
    let look = |medium: &Medium| {
        let (air, columns) = (medium.sampled(&[440.0]), Columns::new(medium));
        let table = Hillaire::build(&air, &columns, &Settings { suns: 8, altitudes: 8, ..Settings::USUAL });
        table.parts(&air, &columns, &ray(10.0, 80.0, 70.0, 40.0))
    };
    assert_eq!(look(&preset.medium), look(&more));
}

/// Half of the table and of all steps changes nothing by 1 %; so the full settings, whose steps and interpolation are
/// of second order, are within a third of that. (Directions are few here, for speed. 28 zeniths instead of 14 changed
/// 0.23 % at worst, 8 azimuths instead of 4 0.05 %.)
#[test]
fn converged_has_converged() {
    let preset = Preset::named("bruneton2017").unwrap();
    let columns = Columns::new(&preset.medium);
    let air = preset.medium.sampled(&[550.0]);
    let full = Settings { zeniths: 10, azimuths: 2, ..Settings::CONVERGED };
    let half = Settings {
        suns: full.suns / 2,
        altitudes: full.altitudes / 2,
        direction_steps: full.direction_steps / 2,
        frame_steps: full.frame_steps / 2,
        ..full.clone()
    };
    let usual = Hillaire::build(&air, &columns, &Settings::USUAL);
    let full = Hillaire::build(&air, &columns, &full);
    let half = Hillaire::build(&air, &columns, &half);
    for (sun, bound, bound_usual) in
        [(0.0, 0.005, 0.06), (60.0, 0.005, 0.06), (85.0, 0.005, 0.1), (90.0, 0.01, 0.3), (94.0, 0.04, 3.0)]
    {
        let (mut worst, mut worst_usual) = (0.0f64, 0.0f64);
        for (altitude_m, view) in
            [(0.0, 10.0), (0.0, 60.0), (0.0, 89.0), (5000.0, 100.0), (100e3, 90.0), (100e3, 150.0)]
        {
            for azimuth in [0.0, 90.0, 180.0] {
                let ray = ray(altitude_m, view, sun, azimuth);
                let of = |table: &Hillaire<1>| table.radiance(&air, &columns, &ray)[0];
                let exact = of(&full);
                if exact > 1e-9 {
                    worst = worst.max((of(&half) / exact - 1.0).abs());
                    worst_usual = worst_usual.max((of(&usual) / exact - 1.0).abs());
                }
            }
        }
        println!("Sun {sun}° from the zenith: half {worst:.2e}, usual {worst_usual:.2e}");
        assert!(worst < bound, "Sun {sun}: {worst}");
        assert!(worst_usual < bound_usual, "usual, Sun {sun}: {worst_usual}");
    }
}
