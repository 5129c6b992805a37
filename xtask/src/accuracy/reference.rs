//! The tracer against programs and laws that share nothing with it.

use std::fmt::Write as _;

use himmel_air::reference::{Effort, Side, Source, Tracer, for_each_parallel};
use himmel_air::{Medium, Phase, Preset, Profile};
use himmel_core::quadrature::gauss_legendre_unit;
use himmel_core::spectrum::Spectrum;

use super::{Work, view};

/// Tables by others: name, preset, text, whether the planet is flat in it.
const TABLES: [(&str, &str, &str, bool); 4] = [
    (
        "PythonicDISORT, flat planet",
        "bruneton2017",
        include_str!("../../../tests/truth/air_disort_bruneton2017.csv"),
        true,
    ),
    (
        "PythonicDISORT, flat planet",
        "mars-reference",
        include_str!("../../../tests/truth/air_disort_mars_reference.csv"),
        true,
    ),
    ("null collisions (numba), day", "bruneton2017", include_str!("../../../tests/truth/air_numba_mc_day.csv"), false),
    ("null collisions (numba), twilight", "bruneton2017", include_str!("../../../tests/truth/air_numba_mc.csv"), false),
];

pub fn table(work: Work) -> Result<String, String> {
    let mut text = String::new();
    against_tables(work, &mut text)?;
    slabs(work, &mut text)?;
    forwards(work, &mut text)?;
    speed(work, &mut text)?;
    Ok(text)
}

fn against_tables(work: Work, text: &mut String) -> Result<(), String> {
    text.push_str("### Radiance by other programs\n\n| program | preset | points | mean difference | its error | χ²/n | worst |\n|---|---|---|---|---|---|---|\n");
    let mut classes = String::new();
    for (program, name, csv, flat) in TABLES {
        let mut preset = Preset::named(name).map_err(|error| error.to_string())?;
        if flat {
            preset.medium.bottom_radius_m *= 1000.0;
        }
        let rows: Vec<Vec<f64>> = csv
            .lines()
            .skip(1)
            .map(|line| line.split(',').filter_map(|field| field.parse().ok()).collect::<Vec<f64>>())
            .filter(|row| row.len() >= 6)
            .step_by(if work.quick { 12 } else { 3 })
            .collect();
        let mut tracers: Vec<(f64, Tracer<1>)> = Vec::new();
        for row in &rows {
            if !tracers.iter().any(|(nm, _)| *nm == row[4]) {
                let air = preset.medium.sampled(&[row[4]]);
                tracers.push((row[4], Tracer::new(&air).map_err(|error| error.to_string())?));
            }
        }
        let effort =
            Effort { samples: 4096, target_relative_error: Some(0.003), most_samples: work.count(1 << 20), seed: 5 };
        let mut differences = Vec::new();
        for_each_parallel(
            rows.len(),
            |i| {
                let row = &rows[i];
                let (_, tracer) = tracers.iter().find(|(nm, _)| *nm == row[4])?;
                let sources = [Source::at_zenith_angle(row[1].to_radians())];
                let answer = tracer.radiance(&sources, row[0], view(row[2], row[3]), &effort, i as u64).ok()?;
                let sigma = answer.standard_error[0].hypot(row.get(6).copied().unwrap_or(0.0)) / row[5];
                Some((answer.value[0] / row[5] - 1.0, sigma, i))
            },
            |_, difference| {
                differences.extend(difference);
                true
            },
        );
        let line = |of: &[&(f64, f64, usize)], label: &str, text: &mut String| {
            let n = of.len() as f64;
            if n == 0.0 {
                return;
            }
            let mean = of.iter().map(|d| d.0).sum::<f64>() / n;
            let sigma = of.iter().map(|d| d.1 * d.1).sum::<f64>().sqrt() / n;
            let chi2 = of.iter().map(|d| (d.0 / d.1).powi(2)).sum::<f64>() / n;
            let worst = of.iter().map(|d| d.0.abs()).fold(0.0, f64::max);
            let _ = writeln!(
                text,
                "| {label} | `{name}` | {n} | {:+.3} % | {:.3} % | {chi2:.2} | {:.2} % |",
                100.0 * mean,
                100.0 * sigma,
                100.0 * worst
            );
        };
        let all: Vec<_> = differences.iter().collect();
        line(&all, program, text);
        eprintln!("{}", text.lines().last().unwrap_or_default());
        let mut suns: Vec<f64> = rows.iter().map(|row| row[1]).collect();
        suns.sort_by(f64::total_cmp);
        suns.dedup();
        for sun in &suns {
            let some: Vec<_> = differences.iter().filter(|d| rows[d.2][1] == *sun).collect();
            line(&some, &format!("{program}, Sun at {sun}°"), &mut classes);
        }
    }
    text.push_str("\nThe same by the Sun's zenith angle:\n\n| class | preset | points | mean difference | its error | χ²/n | worst |\n|---|---|---|---|---|---|---|\n");
    text.push_str(&classes);
    Ok(())
}

/// Conservative slabs on black ground: what goes in comes out.
fn slabs(work: Work, text: &mut String) -> Result<(), String> {
    text.push_str("\n### Energy of conservative slabs\n\n| optical depth | g | Sun zenith | up + down + direct, of 1 | error |\n|---|---|---|---|---|\n");
    for (depth, g) in [(0.3, 0.0), (1.0, 0.8), (5.0, 0.5), (20.0, 0.76)] {
        let medium = slab(depth, g)?;
        let tracer = Tracer::new(&medium.sampled(&[550.0])).map_err(|error| error.to_string())?;
        for zenith_deg in [0.0f64, 60.0, 80.0] {
            let sources = [Source::at_zenith_angle(zenith_deg.to_radians())];
            let effort = Effort { samples: work.count(1 << 18), ..Effort::default() };
            let ask = |i: usize| match i {
                0 => tracer.irradiance(&sources, medium.top_altitude_m, Side::Below, &effort, 0),
                _ => tracer.irradiance(&sources, 0.0, Side::Above, &effort, 1),
            };
            let (mut sum, mut variance) = (0.0, 0.0);
            for_each_parallel(2, ask, |_, answer| {
                if let Ok(answer) = answer {
                    sum += answer.value[0];
                    variance += answer.standard_error[0].powi(2);
                }
                true
            });
            sum += tracer.direct_irradiance(&sources, 0.0, glam::DVec3::Z).map_err(|error| error.to_string())?[0];
            let arrives = zenith_deg.to_radians().cos();
            let _ = writeln!(
                text,
                "| {depth} | {g} | {zenith_deg}° | {:.5} | {:.5} |",
                sum / arrives,
                variance.sqrt() / arrives
            );
            eprintln!("{}", text.lines().last().unwrap_or_default());
        }
    }
    Ok(())
}

fn slab(depth: f64, g: f64) -> Result<Medium, String> {
    let mut medium = Preset::named("bruneton2017").map_err(|error| error.to_string())?.medium;
    medium.components.truncate(1);
    for component in &mut medium.components {
        component.profile = Profile::Table { altitude_m: vec![0.0, 1000.0], value: vec![1.0, 1.0] };
        component.scattering_per_m = Spectrum::Constant(depth / 1000.0);
        component.absorption_per_m = Spectrum::Constant(0.0);
        component.phase = Some(Phase::HenyeyGreenstein { g: Spectrum::Constant(g) });
    }
    medium.top_altitude_m = 1000.0;
    medium.bottom_radius_m = 6.36e9;
    medium.ground_albedo = Spectrum::Constant(0.0);
    Ok(medium)
}

/// Photons forwards against paths backwards.
fn forwards(work: Work, text: &mut String) -> Result<(), String> {
    const BANDS_DEG: [f64; 8] = [60.0, 80.0, 88.0, 90.0, 92.0, 94.0, 96.0, 98.0];
    text.push_str("\n### Photons forwards: irradiance of the ground by scattered light\n\n| preset | nm | Sun zenith | forwards | backwards | difference | its error |\n|---|---|---|---|---|---|---|\n");
    let bands: Vec<f64> = BANDS_DEG.iter().map(|degrees| degrees.to_radians().cos()).collect();
    for (name, nm, photons) in
        [("bruneton2017", 550.0, 2_400_000), ("bruneton2017", 440.0, 2_400_000), ("mars-reference", 550.0, 2_000_000)]
    {
        let preset = Preset::named(name).map_err(|error| error.to_string())?;
        let tracer = Tracer::new(&preset.medium.sampled(&[nm])).map_err(|error| error.to_string())?;
        // Parts for the threads, each with a seed of its own.
        let parts = 8;
        let mut sums = vec![(0.0, 0.0); bands.len() - 1];
        let mut balance = 0.0;
        for_each_parallel(
            parts,
            |part| tracer.forward(&bands, work.count(photons) / parts as u64, part as u64 + 1),
            |_, photons| {
                balance += (photons.left + photons.absorbed_by_air + photons.absorbed_by_ground) / parts as f64;
                for (sum, band) in sums.iter_mut().zip(&photons.scattered) {
                    sum.0 += band.value[0] / parts as f64;
                    sum.1 += (band.standard_error[0] / parts as f64).powi(2);
                }
                true
            },
        );
        for (band, (forward, variance)) in sums.into_iter().enumerate() {
            let effort = Effort { samples: work.count(1 << 16).max(4096), ..Effort::default() };
            let rule = gauss_legendre_unit(6);
            let (mut backward, mut own) = (0.0, 0.0);
            for_each_parallel(
                rule.len(),
                |i| {
                    let cosine = bands[band] + rule[i].0 * (bands[band + 1] - bands[band]);
                    let sources = [Source::at_zenith_angle(cosine.acos())];
                    tracer.irradiance(&sources, 0.0, Side::Above, &effort, (100 * band + i) as u64)
                },
                |i, answer| {
                    if let Ok(answer) = answer {
                        backward += rule[i].1 * answer.value[0];
                        own += (rule[i].1 * answer.standard_error[0]).powi(2);
                    }
                    true
                },
            );
            let _ = writeln!(
                text,
                "| `{name}` | {nm} | {}–{}° | {forward:.4e} | {backward:.4e} | {:+.2} % | {:.2} % |",
                BANDS_DEG[band],
                BANDS_DEG[band + 1],
                100.0 * (forward / backward - 1.0),
                100.0 * (variance + own).sqrt() / backward
            );
            eprintln!("{}", text.lines().last().unwrap_or_default());
        }
        let _ = writeln!(text, "| `{name}` | {nm} | all light | {balance:.5} of 1 found again | | | |");
    }
    Ok(())
}

/// A thousand daytime questions at one wavelength to one percent.
fn speed(work: Work, text: &mut String) -> Result<(), String> {
    text.push_str("\n### Speed\n\n| preset | questions | paths | time | paths a second | error, median | error, worst |\n|---|---|---|---|---|---|---|\n");
    for name in ["bruneton2017", "earth", "earth-haze", "mars-reference", "titan-reference"] {
        let preset = Preset::named(name).map_err(|error| error.to_string())?;
        let tracer = Tracer::new(&preset.medium.sampled(&[550.0])).map_err(|error| error.to_string())?;
        let mut random = super::Random::new(3);
        let questions: Vec<_> = (0..work.count(1000))
            .map(|_| {
                (
                    random.within(0.0, 85.0),
                    view(random.within(0.0, 89.5), random.within(0.0, 180.0)),
                    random.within(0.0, 10e3),
                )
            })
            .collect();
        let effort = Effort { samples: 1024, target_relative_error: Some(0.01), most_samples: 1 << 20, seed: 1 };
        let (mut paths, mut errors) = (0, Vec::new());
        let started = std::time::Instant::now();
        for_each_parallel(
            questions.len(),
            |i| {
                let (sun_deg, direction, altitude_m) = questions[i];
                let sources = [Source::at_zenith_angle(f64::to_radians(sun_deg))];
                tracer.radiance(&sources, altitude_m, direction, &effort, i as u64)
            },
            |_, answer| {
                if let Ok(answer) = answer {
                    paths += answer.samples;
                    errors.push(answer.relative_error());
                }
                true
            },
        );
        let seconds = started.elapsed().as_secs_f64();
        let _ = writeln!(
            text,
            "| `{name}` | {} | {paths} | {seconds:.1} s | {:.0} | {:.2} % | {:.2} % |",
            errors.len(),
            paths as f64 / seconds,
            100.0 * super::quantile(&mut errors, 0.5),
            100.0 * super::quantile(&mut errors, 1.0)
        );
        eprintln!("{}", text.lines().last().unwrap_or_default());
    }
    Ok(())
}
