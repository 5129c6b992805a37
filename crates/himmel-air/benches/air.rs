//! What the air costs on the CPU: `cargo bench -p himmel-air --profile dev` (the profile of the whole workspace).

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use himmel_air::colour::fit_xyz_from_four;
use himmel_air::irradiance::{Directions, sky_irradiance};
use himmel_air::mie::{Index, Mie};
use himmel_air::moments::{Moments, Quality};
use himmel_air::reference::{Effort, Source, Tracer};
use himmel_air::single::{Ray, march};
use himmel_air::{AirParams, Atmosphere, Columns, GroundParams, Preset, sun};

/// Wavelengths of a spectral picture, nm.
const SIXTEEN: [f64; 16] =
    [390.0, 412.0, 434.0, 456.0, 478.0, 500.0, 522.0, 544.0, 566.0, 588.0, 610.0, 632.0, 654.0, 676.0, 698.0, 720.0];

fn benches(c: &mut Criterion) {
    let preset = Preset::named("earth").expect("earth is compiled in");
    let medium = &preset.medium;
    let columns = Columns::new(medium);
    let four = [630.0, 560.0, 490.0, 430.0];
    let air = medium.sampled(&four);
    let ray = Ray { altitude_m: 2.0, mu: 0.2, mu_s: 0.1, nu: 0.9 };
    c.bench_function("march, 32 steps, 4 wavelengths", |b| b.iter(|| march(&air, &columns, black_box(&ray), 32)));
    c.bench_function("optical depth, table", |b| b.iter(|| columns.optical_depth(&air, black_box(100.0), 0.3)));
    // The bound: under a second for the thousand.
    c.bench_function("a thousand spheres of size parameter 0.1 to 100", |b| {
        b.iter(|| {
            (1..=1000)
                .map(|i| {
                    Mie::new(0.1 * f64::from(i), black_box(Index { n: 1.5, k: 0.01 })).map_or(0.0, |mie| mie.q_ext)
                })
                .sum::<f64>()
        })
    });
    let tracer = Tracer::new(&medium.sampled(&[550.0])).expect("earth is a medium");
    let spectral = Tracer::new(&medium.sampled(&SIXTEEN)).expect("earth is a medium");
    let up = DVec3::new(0.6, 0.3, 0.55).normalize();
    for zenith_deg in [60.0f64, 94.0] {
        let sun = [Source::at_zenith_angle(zenith_deg.to_radians())];
        let sun16 = [Source::at_zenith_angle(zenith_deg.to_radians())];
        c.bench_function(&format!("reference, first order, Sun at {zenith_deg}°"), |b| {
            b.iter(|| tracer.first_order(&sun, 0.0, black_box(up)))
        });
        let effort = Effort { samples: 1024, ..Effort::default() };
        c.bench_function(&format!("reference, 1,024 paths, Sun at {zenith_deg}°"), |b| {
            b.iter(|| tracer.radiance(&sun, 0.0, black_box(up), &effort, 0))
        });
        c.bench_function(&format!("reference, 1,024 paths, 16 wavelengths, Sun at {zenith_deg}°"), |b| {
            b.iter(|| spectral.radiance(&sun16, 0.0, black_box(up), &effort, 0))
        });
    }
    let mut group = c.benchmark_group("after an edit");
    group.sample_size(10);
    group.bench_function("columns", |b| b.iter(|| Columns::new(black_box(medium))));
    group.bench_function("colour matrix", |b| {
        b.iter(|| fit_xyz_from_four(medium, &columns, sun::irradiance_w_m2_nm(), black_box(&four)))
    });
    group.bench_function("moments, four wavelengths, recipe", |b| {
        b.iter(|| Moments::build(&air, &columns, black_box(&Quality::default())))
    });
    group.bench_function("reference, one wavelength", |b| b.iter(|| Tracer::new(&medium.sampled(&[black_box(550.0)]))));
    group.bench_function("sky irradiance, one Sun", |b| {
        b.iter(|| sky_irradiance(&air, &columns, 0.0, black_box(0.3), Directions::TABLE))
    });
    group.bench_function("atmosphere, all of it", |b| {
        b.iter(|| Atmosphere::new(black_box(&preset), &AirParams::default(), &GroundParams::default()))
    });
}

criterion_group!(all, benches);
criterion_main!(all);
