//! The Sun's disc, what stands before it and how its rays bend: WGSL against the f64 twins.

use glam::DVec3;
use himmel::parts::air::disc::Disc;
use himmel::parts::air::refraction::Bending;
use himmel::parts::air::{eclipse, sun};
use himmel_tests::{Kernel, Random, worst_error};

const WAVELENGTHS_NM: [f64; 4] = [630.0, 560.0, 490.0, 430.0];

/// Limb darkening as a WGSL expression.
fn limb() -> (String, [[f64; 6]; 4]) {
    let c = WAVELENGTHS_NM.map(sun::limb_darkening);
    let rows: Vec<String> =
        (0..6).map(|k| format!("vec4f({:?}, {:?}, {:?}, {:?})", c[0][k], c[1][k], c[2][k], c[3][k])).collect();
    (format!("array<vec4f, 6>({})", rows.join(", ")), c)
}

#[test]
fn visible_part_of_an_eclipsed_sun() {
    let mut random = Random::new(5);
    let inputs: Vec<[f32; 4]> = (0..20_000)
        .map(|i| {
            let b = if i % 4 == 0 { random.within(0.01, 3.0) } else { random.within(0.9, 1.08) };
            // Crowded at both contacts.
            let (inner, x) = (f64::abs(1.0 - b), random.within(0.0, std::f64::consts::PI));
            [(inner + (1.0 + b - inner) * (0.5 - 0.52 * x.cos())).max(0.0) as f32, b as f32, 0.0, 0.0]
        })
        .collect();
    let (array, c) = limb();
    let gpu = Kernel::of("phenomena/sun/eclipse.wgsl").evaluate(&format!("visible_part(in.x, in.y, {array})"), &inputs);
    let cpu: Vec<_> = inputs.iter().map(|[d, b, ..]| eclipse::visible_part(f64::from(*d), f64::from(*b), &c)).collect();
    // Of full light.
    let (worst, at) = worst_error(&gpu, &cpu, 1.0);
    assert!(worst < 2e-5, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
    // The last crescent keeps its colour: 3e-3 of itself down to 1e-3 of the Sun.
    let (worst, at) = worst_error(&gpu, &cpu, 1e-3);
    assert!(worst < 3e-3, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
    for (gpu, [d, b, ..]) in gpu.iter().zip(&inputs) {
        assert!(*d > b - 1.0 || *gpu == [0.0; 4]);
        assert!(*d < b + 1.0 || *gpu == [1.0; 4]);
    }
}

#[test]
fn discs_seen_from_far_samples() {
    let sun = DVec3::new(0.48, -0.6, 0.64);
    let moon = sun * 3.6e8 + DVec3::new(9e5, 7e5, 0.0);
    let shadow = eclipse::Shadow::new(moon, 1.7374e6, sun, 0.00465, 1.496e11);
    let mut random = Random::new(9);
    let inputs: Vec<[f32; 4]> = (0..5000).map(|_| [0; 4].map(|_: i32| random.within(-2e6, 2e6) as f32)).collect();
    let vector = |v: DVec3| format!("vec3f({:?}, {:?}, {:?})", v.x, v.y, v.z);
    let gpu = Kernel::of("phenomena/sun/eclipse.wgsl").evaluate(
        &format!(
            "vec4f(shadow_discs(ShadowUniform({}, {:?}, {}, {:?}, {:?}, {:?}, vec2f(0.0)), in.xyz), \
             eclipse_table_coordinate(abs(in.x) * 1e-6, 0.95), eclipse_table_coordinate(abs(in.x) * 1.1e-6, 1.05))",
            vector(shadow.across_m),
            shadow.along_m,
            vector(sun),
            shadow.radius_m,
            shadow.sun_radius_rad,
            shadow.parallax
        ),
        &inputs,
    );
    let cpu: Vec<_> = inputs
        .iter()
        .map(|[x, y, z, _]| {
            let (d, b) = shadow.discs(DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z)));
            let wide = f64::from(x.abs());
            [d, b, eclipse::table_coordinate(wide * 1e-6, 0.95), eclipse::table_coordinate(wide * 1.1e-6, 1.05)]
        })
        .collect();
    // 1e-6 radii of the Sun are a thousandth of an arcsecond, at the Moon 2 m. A texel's coordinate: 1e-2 at contacts.
    let two = |all: &[[f32; 4]]| all.iter().map(|a| [a[0], a[1], 0.0, 0.0]).collect::<Vec<_>>();
    let cpu_two: Vec<_> = cpu.iter().map(|a| [a[0], a[1], 0.0, 0.0]).collect();
    let (worst, at) = worst_error(&two(&gpu), &cpu_two, 1.0);
    assert!(worst < 4e-6, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
    for (a, b) in gpu.iter().zip(&cpu) {
        assert!((2..4).all(|k| (f64::from(a[k]) - b[k]).abs() < 5e-2), "{a:?} {b:?}");
    }
}

#[test]
fn corona() {
    let inputs: Vec<[f32; 4]> = (0..1000).map(|i| [0.9 + i as f32 * 0.01; 4]).collect();
    let gpu = Kernel::of("phenomena/sun/eclipse.wgsl").evaluate("corona_brightness(in)", &inputs);
    let cpu: Vec<_> = inputs.iter().map(|[x, ..]| [eclipse::corona_brightness(f64::from(*x)); 4]).collect();
    assert!(worst_error(&gpu, &cpu, 1e-12).0 < 1e-4);
}

fn bending_text(bending: &Bending) -> String {
    let vectors: Vec<String> = bending
        .deviation_rad
        .chunks(4)
        .map(|d| format!("vec4f({:?}, {:?}, {:?}, {:?})", d[0], d[1], d[2], d[3]))
        .collect();
    let [a, b, c, d] = bending.ratio;
    format!(
        "BendingUniform(array<vec4f, 8>({}), vec4f({a:?}, {b:?}, {c:?}, {d:?}), {:?}, {:?}, {:?}, 0.0)",
        vectors.join(", "),
        bending.lowest_rad,
        bending.width_rad,
        bending.span
    )
}

fn earth_bending(altitude_m: f64) -> Bending {
    let earth = himmel::Preset::named("earth").unwrap_or_else(|error| panic!("{error}"));
    Bending::new(&earth.medium, &WAVELENGTHS_NM, altitude_m)
}

#[test]
fn deviation_of_bent_rays() {
    for altitude_m in [2.0, 11e3] {
        let bending = earth_bending(altitude_m);
        let inputs: Vec<[f32; 4]> = (0..4000)
            .map(|i| [(bending.lowest_rad - 0.01 + 1e-5 * 1.0035f64.powi(i)).min(1.57) as f32, 0.0, 0.0, 0.0])
            .collect();
        let expression = format!("vec4f(bent_deviation({}, in.x), 0.0, 0.0)", bending_text(&bending));
        let gpu = Kernel::of("phenomena/sun/bending.wgsl").evaluate(&expression, &inputs);
        let cpu: Vec<_> = inputs
            .iter()
            .map(|[e, ..]| {
                let (deviation, slope) = bending.deviation(f64::from(*e));
                [deviation, slope, 0.0, 0.0]
            })
            .collect();
        // 5e-6 of the horizon's 0.01 rad would be 0.01″; slopes change where nodes meet.
        for (i, (a, b)) in gpu.iter().zip(&cpu).enumerate() {
            assert!((f64::from(a[0]) - b[0]).abs() < 2e-7, "{:?}: {a:?} {b:?}", inputs[i]);
            assert!((f64::from(a[1]) - b[1]).abs() < 2e-3, "{:?}: {a:?} {b:?}", inputs[i]);
        }
    }
}

/// A pixel without width is a point: the disc near the horizon, half eclipsed, with its corona.
#[test]
fn bent_disc() {
    let bending = earth_bending(2.0);
    let (array, limb) = limb();
    let radius_rad = 0.00465;
    for (apparent, occluded) in [(0.004, false), (0.004, true), (0.7, true)] {
        let elevation = bending.true_rad(apparent, 1);
        let at = |azimuth: f64, e: f64| DVec3::new(azimuth.sin() * e.cos(), azimuth.cos() * e.cos(), e.sin());
        let centre = at(0.0, elevation);
        let moon = (at(0.002, elevation + 0.003), 0.0047);
        let disc = Disc { centre, radius_rad, up: DVec3::Z, occluder: occluded.then_some(moon), corona: occluded };
        let mut random = Random::new(11);
        let inputs: Vec<[f32; 4]> = (0..8000)
            .map(|_| {
                let look = at(random.within(-0.008, 0.008) / apparent.cos(), apparent + random.within(-0.008, 0.008));
                [look.x as f32, look.y as f32, look.z as f32, 0.0]
            })
            .collect();
        let vector = |v: DVec3| format!("vec3f({:?}, {:?}, {:?})", v.x, v.y, v.z);
        let aside = if occluded { centre - moon.0 } else { DVec3::ZERO };
        let expression = format!(
            "bent_disc_radiance(in.xyz, vec3f(0.0), vec3f(0.0), DiscUniform({}, {radius_rad:?}, {}, {:?}, {}, {:?}), {}, {array})",
            vector(centre),
            vector(DVec3::Z),
            if occluded { moon.1 } else { 0.0 },
            vector(aside),
            if occluded { 1.0 } else { 0.0 },
            bending_text(&bending)
        );
        let gpu = Kernel::of("phenomena/sun/disc.wgsl").evaluate(&expression, &inputs);
        let twin = |input: &[f32; 4]| {
            let look = DVec3::new(f64::from(input[0]), f64::from(input[1]), f64::from(input[2]));
            disc.radiance_per_sr(look.normalize(), &bending, &limb)
        };
        // Edges move by 1e-7 rad, 2e-5 radii: a point in ten thousand falls on the other side.
        let mean = 1.0 / (std::f64::consts::PI * radius_rad * radius_rad);
        let off = gpu.iter().zip(&inputs).filter(|(a, input)| {
            let b = twin(input);
            (0..4).any(|k| (f64::from(a[k]) - b[k]).abs() > 2e-3 * b[k] + 1e-10 * mean)
        });
        let off: Vec<_> = off.collect();
        for (a, input) in off.iter().take(3) {
            println!("{apparent} {occluded} {input:?}: {a:?} {:?}", twin(input));
        }
        let off = off.len();
        assert!(off <= 16, "{off} of {} points differ", inputs.len());
    }
}
