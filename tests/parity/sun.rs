//! The Sun's disc, what stands before it and how its rays bend: WGSL against the f64 twins.

use glam::DVec3;
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
            "vec4f(shadow_discs(Shadow({}, {:?}, {}, {:?}, {:?}, {:?}), in.xyz), \
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
    let gpu = Kernel::of("phenomena/sun/eclipse.wgsl").evaluate("vec4f(corona_brightness(in.x))", &inputs);
    let cpu: Vec<_> = inputs.iter().map(|[x, ..]| [eclipse::corona_brightness(f64::from(*x)); 4]).collect();
    assert!(worst_error(&gpu, &cpu, 1e-12).0 < 1e-4);
}
