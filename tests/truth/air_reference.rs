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
        assert!(mean.abs() < 2e-3 + 3.0 * error && chi2 < 1.6, "{preset}: {mean} {error} {chi2}");
    }
}

/// Spherical air, day and twilight, by a Monte Carlo of another kind (null collisions, analogue flights): Sun at 0–96°.
#[test]
fn spherical_radiance_is_that_of_null_collisions() {
    for (csv, every) in [(include_str!("air_numba_mc.csv"), 2), (include_str!("air_numba_mc_day.csv"), 6)] {
        let (mean, error, chi2) = against("bruneton2017", false, &rows(csv, every), 8192);
        assert!(mean.abs() < 2e-3 + 3.0 * error && chi2 < 1.8, "{mean} {error} {chi2}");
    }
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
            // A planet a thousand times as large is not quite flat at 85°: tan² θ H/R of the depth, 4e-4.
            let depth = (row[1].to_radians().cos() / row[5]).ln();
            assert!((direct / row[5] - 1.0).abs() < 6e-4 * depth.max(1.0), "{preset} {row:?}: {direct}");
            true
        });
    }
}

/// Light scattered once, or reflected once by the ground, in spherical air by `sasktran2`: no chance in it. The table is
/// good to 2e-4 (haze 5e-4) with the Sun above the horizon and to 2e-3 below it,
/// where single rays along the edge of the shadow differ by up to 1 %. (Ours is within 3e-6 of a plain sum of thousands of steps:
/// `the_first_order_is_that_of_a_long_march`; single rays through opaque haze differ by 0.2 % from the table.)
#[test]
fn the_first_order_is_that_of_sasktran() {
    for (preset, csv, tolerance) in [
        ("bruneton2017", include_str!("air_sasktran_bruneton2017.csv"), 1e-3),
        ("earth-haze", include_str!("air_sasktran_earth_haze.csv"), 5e-3),
    ] {
        let (mut rows, tracers) = (rows(csv, 4), tracers(preset, false));
        rows.retain(|row| row[5] > 0.0);
        let mut differences: Vec<(f64, usize)> = Vec::new();
        let ask = |i: usize| {
            let row = &rows[i];
            let sources = [Source::at_zenith_angle(row[1].to_radians())];
            at(&tracers, row[4]).first_order(&sources, row[0], view(row[2], row[3])).expect("a radiance")[0] / row[5]
                - 1.0
        };
        for_each_parallel(rows.len(), ask, |i, difference| {
            differences.push((difference.abs(), i));
            true
        });
        differences.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median, worst) = (differences[differences.len() / 2].0, differences[differences.len() - 1]);
        println!("{preset}: {} points, median {median:.1e}, worst {:.1e} at {:?}", rows.len(), worst.0, rows[worst.1]);
        assert!(median < 2e-4, "{preset}: {median}");
        // Opaque and dark rays, by which nobody sees, end in the other program's coarser shells.
        for (difference, i) in differences.into_iter().filter(|(_, i)| rows[*i][5] > 1e-4) {
            let bound = if rows[i][1] < 90.0 { tolerance } else { 1e-2 };
            assert!(difference < bound, "{preset}: {difference} at {:?}", rows[i]);
        }
    }
}
