//! Truth for `himmel-air`: Lorenz–Mie by another program. The tables are written by `xtask/data/air_mie_truth.py`
//! with PyPI `miepython` 3.3.0. 1e-6 is the bound.

use himmel_air::lognormal::{FINE, Mode, lorenz_mie};
use himmel_air::mie::{Index, Mie};

/// Rows of numbers below a header.
fn rows(csv: &str) -> impl Iterator<Item = Vec<f64>> + '_ {
    csv.lines().skip(1).map(|line| line.split(',').filter_map(|field| field.parse().ok()).collect())
}

/// Forty spheres: size parameters 0.01 to 200, five indices. Efficiencies and g relative to the other program; q_ext and
/// q_sca of the smallest absolutely as well, because that program switches to a series there.
#[test]
fn forty_spheres() {
    let (mut worst, mut count) = (0.0f64, 0);
    for row in rows(include_str!("air_mie.csv")) {
        let [x, n, k, q_ext, q_sca, g] = row[..] else { panic!("{row:?}") };
        let mie = Mie::new(x, Index { n, k }).expect("a sphere");
        for (ours, theirs) in [(mie.q_ext, q_ext), (mie.q_sca, q_sca), (mie.g, g)] {
            let error = ((ours - theirs) / theirs).abs().min((ours - theirs).abs() * 1e3);
            worst = worst.max(error);
            assert!(error < 1e-6, "x {x} n {n} k {k}: {ours:e} {theirs:e}");
        }
        count += 1;
    }
    println!("{count} spheres, worst relative difference {worst:.1e}");
    assert_eq!(count, 40);
}

/// The three modes of thesis B, table 3, one by one and together, at 440, 550, 680 nm.
#[test]
fn three_modes() {
    let modes = [(0.013, 1.7, 7.7e4), (0.069, 2.03, 1.3e4), (0.97, 2.15, 4.2)]
        .map(|(rg, sg, n)| Mode::new(rg, sg, n).expect("a mode"));
    let mut worst = 0.0f64;
    for row in rows(include_str!("air_lognormal.csv")) {
        let [which, nm, extinction, scattering, g] = row[..] else { panic!("{row:?}") };
        let modes = if which > 3.0 { &modes[..] } else { &modes[which as usize - 1..which as usize] };
        let optics = lorenz_mie(modes, Index { n: 1.57, k: 0.02 }, nm, FINE).expect("optics");
        for (ours, theirs) in [(optics.extinction_m2, extinction), (optics.scattering_m2, scattering), (optics.g, g)] {
            worst = worst.max((ours / theirs - 1.0).abs());
            assert!((ours / theirs - 1.0).abs() < 1e-6, "mode {which} at {nm} nm: {ours:e} {theirs:e}");
        }
    }
    println!("three modes and their mixture, worst relative difference {worst:.1e}");
}
