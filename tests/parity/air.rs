//! The air's tables and march on the GPU against their f64 twins: the same sums, in f32.

use himmel::Preset;
use himmel::parts::air::single::Ray;
use himmel::parts::air::{AirParams, AirQuality, Atmosphere, GroundParams};
use himmel::parts::gpu::RayMeter;
use himmel_tests::{Random, gpu};

/// Rays of all kinds: from the ground to space, by day and twilight.
fn rays(atmosphere: &Atmosphere, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let top_m = atmosphere.medium().top_altitude_m;
    (0..count)
        .map(|i| {
            let altitude_m = match i % 4 {
                0 => 2.0,
                1 => 10f64.powf(random.within(1.0, 4.5)).min(0.9 * top_m),
                2 => random.within(0.1, 0.9) * top_m,
                _ => random.within(1.5, 20.0) * top_m,
            };
            let sun = random.within(-8.0, 80.0).to_radians();
            let limb = -(altitude_m / (atmosphere.medium().bottom_radius_m + altitude_m)).sqrt() * 1.5;
            let view = if i % 4 == 3 { limb - random.within(0.0, 0.3) } else { random.within(-1.2, 1.5) };
            let azimuth = random.within(0.0, std::f64::consts::PI);
            let nu = view.sin() * sun.sin() + view.cos() * sun.cos() * azimuth.cos();
            Ray { altitude_m, mu: view.sin(), mu_s: sun.sin(), nu: nu.clamp(-1.0, 1.0) }
        })
        .collect()
}

/// Relative differences in percent, sorted.
fn differences(preset: &str, count: usize) -> Vec<(f64, Ray, usize)> {
    let preset = Preset::named(preset).expect("a preset");
    let air = AirParams { quality: Some(AirQuality::Film), ..AirParams::default() };
    let atmosphere = Atmosphere::new(&preset, &air, &GroundParams::default());
    let rays = rays(&atmosphere, count, 5);
    let started = std::time::Instant::now();
    let mut meter = RayMeter::new(gpu(), &atmosphere, &mut |_| true).expect("tables");
    println!("tables {:.2} s, {:.2} MiB", started.elapsed().as_secs_f64(), meter.table_bytes() as f64 / 1048576.0);
    let found = meter.answer(&rays).expect("answers");
    let mut differences = Vec::new();
    for (ray, answer) in rays.iter().zip(found) {
        let twin = atmosphere.radiance(ray, 48);
        for k in 0..4 {
            let (a, b) = (f64::from(answer.radiance_per_sr[k]), twin[k]);
            if b > 1e-9 {
                differences.push((100.0 * (a / b - 1.0), *ray, k));
            }
        }
    }
    differences.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    differences
}

#[test]
fn rays_are_those_of_the_twin() {
    for (preset, median_percent, p95_percent) in
        [("bruneton2017", 0.05, 0.3), ("earth-haze", 0.1, 0.4), ("mars-reference", 0.05, 0.4), ("earth", 0.1, 1.0)]
    {
        let found = differences(preset, 400);
        let at = |share: f64| found[(share * (found.len() - 1) as f64) as usize].0.abs();
        println!(
            "{preset}: {} of 1600, median {:.4} %, 95 % {:.4} %, 99 % {:.3} %, worst {:?}",
            found.len(),
            at(0.5),
            at(0.95),
            at(0.99),
            found.last()
        );
        assert!(at(0.5) < median_percent && at(0.95) < p95_percent, "{preset}");
    }
}
