//! What a frame costs: every body of the sky, apparent and topocentric, by level. Budget: fast 25 µs, precise 10 µs amortised.

use criterion::{Criterion, criterion_group, criterion_main};
use himmel_astro::earth::{EarthOrientation, Nutation, NutationModel};
use himmel_astro::time::JulianDateTt;
use himmel_astro::{Body, Cached, Catalogue, Ephemeris, Fast, Instant, Observer, Place, Precise};
use std::hint::black_box;

/// Sun, Moon, seven planets, Pluto.
fn all_bodies(ephemeris: &dyn Ephemeris, unix_s: f64, place: &Place) -> f64 {
    let instant = Instant::from_unix_seconds(unix_s).expect("a good date");
    let observer = Observer::new(ephemeris, &instant, place).expect("within the span");
    Body::ALL
        .into_iter()
        .filter(|b| *b != Body::Earth)
        .map(|b| observer.apparent(b).expect("a known body").altitude_rad)
        .sum()
}

/// The same with phases, magnitudes, bright limbs, the Moon's libration and Saturn's rings.
fn all_looks(ephemeris: &dyn Ephemeris, unix_s: f64, place: &Place) -> f64 {
    let instant = Instant::from_unix_seconds(unix_s).expect("a good date");
    let observer = Observer::new(ephemeris, &instant, place).expect("within the span");
    let mut sum = 0.0;
    for body in Body::ALL.into_iter().filter(|b| *b != Body::Earth) {
        let seen = observer.apparent(body).expect("a known body");
        sum += observer.appearance(body, &seen).expect("a known body").magnitude;
        match body {
            Body::Moon => sum += observer.libration(&seen).longitude_rad,
            Body::Saturn => sum += observer.saturn_rings(&seen).expect("a known body").tilt_rad,
            _ => {}
        }
    }
    sum
}

fn frames(c: &mut Criterion) {
    let place = Place::from_degrees(52.4, 13.06, 35.0).expect("a good place");
    let precise = Precise::embedded().expect("the pack is whole");
    let levels: [(&str, Box<dyn Ephemeris>); 4] = [
        ("fast", Box::new(Fast)),
        ("precise", Box::new(precise.clone())),
        ("cached fast", Box::new(Cached::new(Fast))),
        ("cached precise", Box::new(Cached::new(precise))),
    ];
    for (name, ephemeris) in &levels {
        // Sixty frames a second, as a game asks.
        let mut unix_s = 1.7e9;
        c.bench_function(&format!("all bodies, {name}"), |b| {
            b.iter(|| {
                unix_s += 1.0 / 60.0;
                black_box(all_bodies(&**ephemeris, unix_s, &place))
            });
        });
    }
    for (name, ephemeris) in &levels {
        let mut unix_s = 1.7e9;
        c.bench_function(&format!("all looks, {name}"), |b| {
            b.iter(|| {
                unix_s += 1.0 / 60.0;
                black_box(all_looks(&**ephemeris, unix_s, &place))
            });
        });
    }
    let instant = Instant::from_unix_seconds(1.7e9).expect("a good date");
    c.bench_function("Earth orientation", |b| b.iter(|| EarthOrientation::at(black_box(&instant))));
    let tt = JulianDateTt::new(2_460_000.5).expect("a good date");
    c.bench_function("nutation 2000B", |b| b.iter(|| Nutation::at(black_box(tt), NutationModel::Iau2000B)));
    let observer = Observer::new(&Fast, &instant, &place).expect("a good date");
    let stars = Catalogue::embedded();
    c.bench_function("all stars, apparent", |b| {
        b.iter(|| stars.stars().iter().map(|s| observer.apparent_star(s).altitude_rad).sum::<f64>());
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(20).warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1)); targets = frames }
criterion_main!(benches);
