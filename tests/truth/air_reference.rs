//! Truth for the reference tracer: tables that other programs made (`SOURCE.md`), a sample of each here; the whole of them
//! by `cargo xtask accuracy reference`, whose output stands in `docs/accuracy.md`.

use glam::DVec3;
use himmel_air::Preset;
use himmel_air::reference::{Effort, Side, Source, Tracer, for_each_parallel};

fn rows(csv: &str, every: usize) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split(',').map(|field| field.parse().expect("a number")).collect();
    csv.lines().skip(1).step_by(every).map(numbers).collect()
}

fn view(zenith_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (zenith, azimuth) = (zenith_deg.to_radians(), azimuth_deg.to_radians());
    DVec3::new(zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos())
}

/// Tracers at the tables' wavelengths; `flat`: of a planet a thousand times as large, which is plane-parallel.
fn tracers(preset: &str, flat: bool) -> Vec<(f64, Tracer<1>)> {
    let mut medium = Preset::named(preset).expect("a preset").medium;
    if flat {
        medium.bottom_radius_m *= 1000.0;
    }
    [680.0, 550.0, 440.0].map(|nm| (nm, Tracer::new(&medium.sampled(&[nm])).expect("a medium"))).into()
}

fn at(tracers: &[(f64, Tracer<1>)], nm: f64) -> &Tracer<1> {
    &tracers.iter().find(|(known, _)| *known == nm).expect("a wavelength of the table").1
}

/// Mean relative difference, its error, χ² per point.
fn against(preset: &str, flat: bool, rows: &[Vec<f64>], samples: u64) -> (f64, f64, f64) {
    let tracers = tracers(preset, flat);
    let (mut sum, mut variance, mut chi2) = (0.0, 0.0, 0.0);
    let effort = Effort { samples, ..Effort::default() };
    for_each_parallel(
        rows.len(),
        |i| {
            let row = &rows[i];
            let sources = [Source::at_zenith_angle(row[1].to_radians())];
            let tracer = at(&tracers, row[4]);
            let answer =
                tracer.radiance(&sources, row[0], view(row[2], row[3]), &effort, i as u64).expect("a radiance");
            let sigma = answer.standard_error[0].hypot(row.get(6).copied().unwrap_or(0.0)) / row[5];
            (answer.value[0] / row[5] - 1.0, sigma)
        },
        |_, (difference, sigma)| {
            sum += difference;
            variance += sigma * sigma;
            chi2 += (difference / sigma).powi(2);
            true
        },
    );
    let n = rows.len() as f64;
    println!(
        "{preset}: {n} points, mean {:+.3} ± {:.3} %, χ² {:.2}",
        100.0 * sum / n,
        100.0 * variance.sqrt() / n,
        chi2 / n
    );
    (sum / n, variance.sqrt() / n, chi2 / n)
}

/// The bounds: a mean difference below 0.2 % over hundreds of points (the sample's own error is 0.03 %); χ² of one
/// where errors are honest, up to 1.6 for the heavy tails of few paths.
#[test]
fn plane_parallel_radiance_is_that_of_discrete_ordinates() {
    for (preset, csv) in [
        ("bruneton2017", include_str!("air_disort_bruneton2017.csv")),
        ("mars-reference", include_str!("air_disort_mars_reference.csv")),
    ] {
        let (mean, error, chi2) = against(preset, true, &rows(csv, 5), 4096);
        assert!(mean.abs() < 2e-3 && mean.abs() < 4.0 * error && chi2 < 1.6, "{preset}: {mean} {error} {chi2}");
    }
}

/// Spherical twilight by a Monte Carlo of another kind (null collisions, analogue flights), Sun at 80–96°.
#[test]
fn twilight_is_that_of_null_collisions() {
    let (mean, error, chi2) = against("bruneton2017", false, &rows(include_str!("air_numba_mc.csv"), 2), 8192);
    assert!(mean.abs() < 2e-3 + 3.0 * error && chi2 < 1.8, "{mean} {error} {chi2}");
}

/// Flux on level surfaces, up and down, diffuse and direct: 0.3 % and the error of 32,768 paths.
#[test]
fn plane_parallel_fluxes_are_those_of_discrete_ordinates() {
    for (preset, csv) in [
        ("bruneton2017", include_str!("air_disort_bruneton2017_flux.csv")),
        ("mars-reference", include_str!("air_disort_mars_reference_flux.csv")),
    ] {
        let (rows, tracers) = (rows(csv, 1), tracers(preset, true));
        let effort = Effort { samples: 16_384, ..Effort::default() };
        let answers = |i: usize| {
            let row = &rows[i];
            let (tracer, sources) = (at(&tracers, row[2]), [Source::at_zenith_angle(row[1].to_radians())]);
            let ask = |side| tracer.irradiance(&sources, row[0], side, &effort, i as u64).expect("an irradiance");
            let direct = tracer.direct_irradiance(&sources, row[0], DVec3::Z).expect("a beam")[0];
            (ask(Side::Below), ask(Side::Above), direct)
        };
        for_each_parallel(rows.len(), answers, |i, (up, down, direct)| {
            let row = &rows[i];
            for (ours, theirs) in [(&up, row[3]), (&down, row[4])] {
                let error = (ours.value[0] - theirs).abs();
                assert!(error <= 4.0 * ours.standard_error[0] + 3e-3 * theirs, "{preset} {row:?}: {ours:?}");
            }
            assert!((direct / row[5] - 1.0).abs() < 1e-5, "{preset} {row:?}: {direct}");
            true
        });
    }
}
