//! What the air costs on the CPU: `cargo bench -p himmel-air --profile dev` (the profile of the whole workspace).

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use himmel_air::colour::fit_xyz_from_four;
use himmel_air::irradiance::{Directions, sky_irradiance};
use himmel_air::mie::{Index, Mie};
use himmel_air::single::{Ray, march};
use himmel_air::{AirParams, Atmosphere, Columns, GroundParams, Preset, sun};

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
    let mut group = c.benchmark_group("after an edit");
    group.sample_size(10);
    group.bench_function("columns", |b| b.iter(|| Columns::new(black_box(medium))));
    group.bench_function("colour matrix", |b| {
        b.iter(|| fit_xyz_from_four(medium, &columns, sun::irradiance_w_m2_nm(), black_box(&four)))
    });
    group.bench_function("sky irradiance, one Sun", |b| {
        b.iter(|| sky_irradiance(&air, &columns, 0.0, black_box(0.3), Directions::TABLE))
    });
    group.bench_function("atmosphere, all of it", |b| {
        b.iter(|| Atmosphere::new(black_box(&preset), &AirParams::default(), &GroundParams::default()))
    });
}

criterion_group!(all, benches);
criterion_main!(all);
