use super::*;
use crate::sun::limb_darkening;

fn four() -> [[f64; 6]; 4] {
    [630.0, 560.0, 490.0, 430.0].map(limb_darkening)
}

const EVEN: [[f64; 6]; 1] = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
const RADII: [f64; 9] = [0.01, 0.5, 0.9, 0.97, 0.999, 1.0, 1.001, 1.05, 3.0];

/// Separations through all phases, crowded at the contacts.
fn separations(b: f64) -> Vec<f64> {
    let (inner, outer) = ((1.0 - b).abs(), 1.0 + b);
    let mut all: Vec<f64> = (0..=300).map(|i| (outer + 0.1) * f64::from(i) / 300.0).collect();
    for i in 1..40 {
        let x = 10f64.powf(-7.0 + 0.15 * f64::from(i));
        all.extend([inner + x, inner - x, outer - x, outer + x]);
    }
    all.retain(|&d| d >= 0.0);
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn exact_where_nothing_is_cut() {
    for b in RADII {
        assert_eq!(visible_part(1.0 + b, b, &four()), [1.0; 4]);
        assert_eq!(visible_part(1.01 + b, b, &four()), [1.0; 4]);
        if b > 1.0 {
            assert_eq!(visible_part(b - 1.0, b, &four()), [0.0; 4]);
            assert_eq!(visible_part(0.0, b, &four()), [0.0; 4]);
        }
    }
    assert_eq!(outer_flux(0.0, &four()), [0.0; 4]);
    assert!(outer_flux(1.0, &four()).iter().all(|all| (all - 1.0).abs() < 1e-12));
}

/// Two circles of even brightness: the lens. A ring: 1 − b².
#[test]
fn an_even_disc_gives_the_lens() {
    let lens = |d: f64, b: f64| {
        let (x, y) = ((d * d + 1.0 - b * b) / (2.0 * d), (d * d + b * b - 1.0) / (2.0 * d * b));
        let (a, c) = (x.clamp(-1.0, 1.0).acos(), y.clamp(-1.0, 1.0).acos());
        (a - a.sin() * a.cos() + b * b * (c - c.sin() * c.cos())) / PI
    };
    let mut worst: f64 = 0.0;
    for b in RADII {
        for d in separations(b).into_iter().filter(|d| *d > (1.0 - b).abs() && *d < 1.0 + b) {
            worst = worst.max((visible_part(d, b, &EVEN)[0] - (1.0 - lens(d, b))).abs());
        }
    }
    assert!((visible_part(0.05, 0.9, &EVEN)[0] - (1.0 - 0.81)).abs() < 1e-6);
    assert!((visible_part(0.0, 0.9, &EVEN)[0] - (1.0 - 0.81)).abs() < 1e-12);
    println!("against the lens: {worst:.1e}");
    assert!(worst < 3e-5);
}

/// Against 400 nodes, and those against the plainest sum there is: four million points.
#[test]
fn eight_nodes_are_enough() {
    let (mut worst, mut real): (f64, f64) = (0.0, 0.0);
    for b in RADII {
        for d in separations(b) {
            let (few, many) = (visible_part(d, b, &four()), visible_part_by(400, d, b, &four()));
            let error = (0..4).map(|k| (few[k] - many[k]).abs()).fold(0.0, f64::max);
            worst = worst.max(error);
            if (0.9..1.1).contains(&b) {
                real = real.max(error);
            }
        }
    }
    println!("8 nodes: {worst:.1e}, Moon and Sun {real:.1e}");
    assert!(worst < 5e-5 && real < 5e-6);
    let (d, b, n) = (0.7, 0.97, 2000);
    let (mut sum, c) = (0.0, four()[1]);
    for i in 0..n {
        for j in 0..n {
            let (x, y) = ((i as f64 + 0.5) / n as f64 * 2.0 - 1.0, (j as f64 + 0.5) / n as f64 * 2.0 - 1.0);
            if x.hypot(y) < 1.0 && (x - d).hypot(y) > b {
                sum += crate::sun::relative_disc_brightness(x.hypot(y), &c);
            }
        }
    }
    let plain = sum * 4.0 / (n * n) as f64 / PI;
    assert!((visible_part(d, b, &[c])[0] / plain - 1.0).abs() < 2e-4, "{plain}");
}

/// Light never jumps and never falls as the discs part, nor does its colour.
#[test]
fn no_jump_at_the_contacts() {
    for b in RADII {
        let all: Vec<_> = separations(b).into_iter().map(|d| (d, visible_part(d, b, &four()))).collect();
        for pair in all.windows(2) {
            for k in 0..4 {
                let step = pair[1].1[k] - pair[0].1[k];
                assert!(step > -2e-5 && step < 1e-6 + 2.5 * (pair[1].0 - pair[0].0), "{b} {:?}", pair);
            }
        }
        let before = visible_part(1.0 + b - 1e-4, b, &four());
        assert!(before.iter().all(|v| 1.0 - v < 1e-5));
    }
}

/// The limb is redder than the centre: as the crescent thins its light reddens, until it has the limb's own colour, twice
/// as red (630 over 430 nm) as the whole disc.
#[test]
fn the_last_light_is_redder() {
    let redness = |d: f64| {
        let v = visible_part(d, 1.03, &four());
        v[0] / v[3]
    };
    assert!((redness(3.0) - 1.0).abs() < 1e-12);
    assert!(redness(0.06) > redness(0.4) && redness(0.4) > redness(1.0) && redness(1.0) > 1.0);
    println!("last light, 630 over 430 nm: {:.3}", redness(0.0301));
    let limb = four()[0][0] / four()[3][0];
    assert!((redness(0.030_001) / limb - 1.0).abs() < 0.02, "{limb}");
}

#[test]
fn the_table_repeats_the_integral() {
    let (mut same, mut near): (f64, f64) = (0.0, 0.0);
    for b in [0.5, 0.9, 0.97, 1.02, 1.05, 3.0] {
        let table = EclipseTable::new(b, &four());
        let worst = |other: f64| {
            let error = |d: f64| {
                let (a, b) = (table.at(d, other), visible_part(d, other, &four()));
                (0..4).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
            };
            separations(other).into_iter().map(error).fold(0.0, f64::max)
        };
        println!("b = {b}: {:.1e}, ±0.5 %: {:.1e} {:.1e}", worst(b), worst(b * 0.995), worst(b * 1.005));
        same = same.max(worst(b));
        if !(0.98..1.02).contains(&b) {
            near = near.max(worst(b * 0.995)).max(worst(b * 1.005));
        }
        assert_eq!(table.at(b + 1.0, b), [1.0; 4]);
        if b > 1.0 {
            assert_eq!(table.at(b - 1.0, b), [0.0; 4]);
        }
    }
    println!("table {same:.1e}, with other radii {near:.1e}");
    assert!(same < 3e-4 && near < 6e-3);
}

/// The vectors as they are, in f64, against the split ones.
#[test]
fn discs_are_where_the_vectors_say() {
    let au = 1.496e11;
    let sun = DVec3::new(0.3, -0.5, 0.6).normalize();
    let moon = sun * 3.6e8 + DVec3::new(1.1e6, 0.7e6, -0.4e6);
    let shadow = Shadow::new(moon, 1.7374e6, sun, 0.00465, au);
    for offset in [DVec3::ZERO, DVec3::new(2e6, 0.0, 0.0), DVec3::new(-3e5, 1.2e6, -7e5), sun * 2e6] {
        let (d, b) = shadow.discs(offset);
        let separation = (moon - offset).angle_between(sun * au - offset);
        // Parallax is first order: 1e-7 rad is a fiftieth of an arcsecond.
        assert!((d * 0.00465 - separation).abs() < 1e-7, "{offset}: {} {separation}", d * 0.00465);
        let radius = (1.7374e6 / (moon - offset).length()).asin();
        assert!((b * 0.00465 / radius - 1.0).abs() < 1e-5);
    }
    let behind = Shadow::new(-moon, 1.7374e6, sun, 0.00465, au);
    assert_eq!(behind.fraction(DVec3::ZERO, &four()), [1.0; 4]);
    assert!(shadow.reaches(1e6) && !behind.reaches(1e6));
    let far = Shadow::new(sun * 3.6e8 + sun.any_orthonormal_vector() * 7e6, 1.7374e6, sun, 0.00465, au);
    assert!(!far.reaches(1e6) && far.reaches(5e6));
    for i in 0..100 {
        let angle = f64::from(i) * 0.37;
        let offset = DVec3::new(angle.cos(), angle.sin(), (angle * 1.7).sin()).normalize() * 1e6;
        assert_eq!(far.fraction(offset, &EVEN), [1.0]);
    }
}

#[test]
fn the_disc_rule_is_of_fifth_degree() {
    let mean = |f: &dyn Fn(f64, f64) -> f64| disc_rule().iter().map(|([x, y], w)| w * f(*x, *y)).sum::<f64>();
    for (f, expected) in [
        (&(|_, _| 1.0) as &dyn Fn(f64, f64) -> f64, 1.0),
        (&|x, _| x, 0.0),
        (&|x, _| x * x, 0.25),
        (&|x, y| x * x * y, 0.0),
        (&|x, _| x.powi(4), 0.125),
        (&|x, y| (x * y).powi(2), 1.0 / 24.0),
    ] {
        assert!((mean(f) - expected).abs() < 1e-14);
    }
}

/// At the edge of the umbra of 2024, seen from 3.6e8 m: 7 points against 4000.
#[test]
fn the_blur_is_the_mean_of_the_disc() {
    let sun = DVec3::Z;
    let mut worst: f64 = 0.0;
    for aside_km in [0.0, 50.0, 100.0, 150.0, 200.0, 300.0, 1000.0, 3000.0] {
        let shadow = Shadow::new(sun * 3.54e8 + DVec3::X * aside_km * 1e3, 1.7374e6, sun, 0.00465, 1.496e11);
        let few = blurred(DVec3::ZERO, DVec3::Z, BLUR_RADIUS_M, |x| shadow.fraction(x, &EVEN))[0];
        let (mut sum, n) = (0.0, 4000);
        for i in 0..n {
            // A sunflower: even over the disc.
            let (r, a) = (((f64::from(i) + 0.5) / f64::from(n)).sqrt() * BLUR_RADIUS_M, f64::from(i) * 2.399_963);
            sum += shadow.fraction(DVec3::new(r * a.cos(), r * a.sin(), 0.0), &EVEN)[0];
        }
        println!("{aside_km} km: {few:.4}, many points {:.4}", sum / f64::from(n));
        worst = worst.max((few - sum / f64::from(n)).abs());
    }
    assert!(worst < 5e-3, "{worst:e}");
}

/// Totals of the corona at eclipses lie between 0.4e-6 and 1.3e-6 of the Sun [allen1973].
#[test]
fn the_corona_is_a_millionth_of_the_sun() {
    let total = |inner: f64| -> f64 {
        // ρ = inner / x; the disc's flux is π in these units.
        gauss_legendre_unit(200)
            .iter()
            .map(|(x, w)| w * 2.0 * corona_brightness(inner / x) * inner * inner / x.powi(3))
            .sum()
    };
    println!("corona: {:.3e} from the limb, {:.3e} around a Moon of 1.03", total(1.0), total(1.03));
    assert!((0.4e-6..1.4e-6).contains(&total(1.03)));
    assert!(corona_brightness(1.0) > corona_brightness(1.1) && corona_brightness(0.99) == 0.0);
}
