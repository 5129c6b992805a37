//! WGSL functions against their f64 twins, each through one dispatch.

use glam::DVec3;
use himmel::parts::air::{geometry, sun};
use himmel::parts::gpu::output::{dither, tonemap};
use himmel_tests::{Kernel, Random, worst_error};

const R: f64 = 6_371_000.0;
const TOP: f64 = 100_000.0;

/// Altitudes from a man's height to the top, crowded at the bottom, and zenith cosines of all directions.
fn rays(count: usize) -> Vec<[f32; 4]> {
    let mut random = Random::new(1);
    (0..count)
        .map(|_| {
            let altitude_m = 1.0 + (TOP - 1.0) * random.within(0.0, 1.0).powi(4);
            let t = 10f64.powf(random.within(0.0, 6.0));
            [altitude_m as f32, random.within(-1.0, 1.0) as f32, t as f32, random.within(-1.0, 1.0) as f32]
        })
        .collect()
}

fn twin(inputs: &[[f32; 4]], f: impl Fn([f64; 4]) -> [f64; 4]) -> Vec<[f64; 4]> {
    inputs.iter().map(|input| f(input.map(f64::from))).collect()
}

#[test]
fn spheres() {
    let kernel = Kernel::of("frame/sphere.wgsl");
    let inputs = rays(20_000);
    let gpu = kernel.evaluate(
        &format!(
            "vec4f(altitude_along({R:?}, in.x, in.y, in.z), top_distance({R:?}, {TOP:?}, in.x, in.y), \
                  horizon_cosine({R:?}, in.x), 0.0)"
        ),
        &inputs,
    );
    let cpu = twin(&inputs, |[h, mu, t, _]| {
        [
            geometry::altitude_along(R, h, mu, t),
            geometry::top_distance(R, TOP, h, mu),
            geometry::horizon_cosine(R, h),
            0.0,
        ]
    });
    // f32 holds 2 R h + … to 1e-7 of the largest term: 2 R t µ up to 1e13 m² gives 0.1 m of altitude; floor 1 km.
    let (worst, at) = worst_error(&gpu, &cpu, 1000.0);
    assert!(worst < 3e-4, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
}

#[test]
fn optical_depth_coordinates() {
    let kernel = Kernel::of("frame/sphere.wgsl");
    // Only rays that clear the horizon have a place in the table.
    let inputs: Vec<_> =
        rays(20_000).into_iter().filter(|r| f64::from(r[1]) > geometry::horizon_cosine(R, f64::from(r[0]))).collect();
    let gpu = kernel.evaluate(&format!("vec4f(depth_table_uv({R:?}, {TOP:?}, in.x, in.y), 0.0, 0.0)"), &inputs);
    let cpu = twin(&inputs, |[h, mu, _, _]| {
        let (u, v) = geometry::depth_table_uv(R, TOP, h, mu);
        [u, v, 0.0, 0.0]
    });
    // A tenth of a texel of 128.
    let (worst, at) = worst_error(&gpu, &cpu, 1.0);
    assert!(worst < 1e-3, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
}

#[test]
fn shadow_of_the_planet() {
    let kernel = Kernel::of("frame/sphere.wgsl");
    let mut random = Random::new(7);
    let inputs: Vec<[f32; 4]> = (0..20_000)
        .map(|_| {
            let (z, s) = (random.within(0.0, 2.0), random.within(1.6, 3.0));
            let azimuth = random.within(0.0, std::f64::consts::PI);
            let nu = f64::cos(z) * f64::cos(s) + f64::sin(z) * f64::sin(s) * f64::cos(azimuth);
            [random.within(100.0, 5e4) as f32, f64::cos(z) as f32, f64::cos(s) as f32, nu as f32]
        })
        .collect();
    let gpu = kernel.evaluate(
        &format!("vec4f(min(shadow_interval({R:?}, in.x, in.y, in.z, in.w), vec2f(3e6)), 0.0, 0.0)"),
        &inputs,
    );
    let cpu = twin(&inputs, |[h, mu, mu_s, nu]| {
        let (from, to) = geometry::shadow_interval(R, h, mu, mu_s, nu);
        [from.min(3e6), to.min(3e6), 0.0, 0.0]
    });
    // Grazing rays are ill-conditioned: the 99.5th percentile must lie within 1 km of 1,000 km.
    let mut errors: Vec<f64> =
        gpu.iter().zip(&cpu).map(|(a, b)| (0..2).map(|k| (f64::from(a[k]) - b[k]).abs()).fold(0.0, f64::max)).collect();
    errors.sort_by(f64::total_cmp);
    let p995 = errors[errors.len() * 995 / 1000];
    assert!(p995 < 1000.0, "{p995} m");
}

#[test]
fn tone_mappers() {
    let kernel = Kernel::of("output/tonemap.wgsl");
    let mut random = Random::new(3);
    let inputs: Vec<[f32; 4]> = (0..10_000)
        .map(|_| {
            let peak = 10f64.powf(random.within(-4.0, 3.0));
            [0; 4].map(|_: i32| (peak * random.within(0.0, 1.0)) as f32)
        })
        .collect();
    for &operator in himmel::Tonemap::ALL {
        let gpu = kernel.evaluate(&format!("vec4f(tonemap({}u, in.rgb, 0.02), 0.0)", operator as u32), &inputs);
        let cpu =
            twin(&inputs, |[r, g, b, _]| tonemap::tonemap(operator, DVec3::new(r, g, b), 0.02).extend(0.0).to_array());
        // A tenth of a step of 8 bits.
        let (worst, at) = worst_error(&gpu, &cpu, 1.0);
        assert!(worst < 4e-4, "{operator:?}: {worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
    }
}

#[test]
fn srgb_decoding() {
    let inputs: Vec<[f32; 4]> = (0..=1000).map(|i| [i as f32 / 1000.0; 4]).collect();
    let gpu = Kernel::of("output/tonemap.wgsl").evaluate("vec4f(srgb_decode(in.rgb), 0.0)", &inputs);
    let cpu = twin(&inputs, |[r, g, b, _]| tonemap::srgb_decode(DVec3::new(r, g, b)).extend(0.0).to_array());
    assert!(worst_error(&gpu, &cpu, 0.01).0 < 1e-4);
}

/// Integer arithmetic: equal to the last bit.
#[test]
fn dithering_noise() {
    let inputs: Vec<[f32; 4]> = (0..4096).map(|i| [(i % 64 * 37) as f32, (i / 64 * 91) as f32, 0.0, 0.0]).collect();
    let gpu = Kernel::of("output/dither.wgsl").evaluate("vec4f(triangular_noise(vec2u(in.xy)), 0.0)", &inputs);
    let cpu = twin(&inputs, |[x, y, _, _]| {
        let [r, g, b] = dither::triangular_noise([x as u32, y as u32]);
        [r, g, b, 0.0]
    });
    assert_eq!(worst_error(&gpu, &cpu, 1.0).0, 0.0);
}

#[test]
fn limb_darkening() {
    let c = sun::limb_darkening(560.0);
    let rows: Vec<String> = c.iter().map(|c| format!("vec4f({:?})", *c as f32)).collect();
    let inputs: Vec<[f32; 4]> = (0..1000).map(|i| [i as f32 / 1000.0; 4]).collect();
    let expression = format!("disc_brightness(vec4f(in.x), array<vec4f, 6>({}))", rows.join(", "));
    let gpu = Kernel::of("phenomena/sun/disc.wgsl").evaluate(&expression, &inputs);
    let cpu = twin(&inputs, |[x, ..]| [sun::relative_disc_brightness(x, &c); 4]);
    assert!(worst_error(&gpu, &cpu, 0.1).0 < 1e-4);
}

/// The harness can fail: a kernel with one wrong sign, one with one wrong constant.
#[test]
fn sabotage_is_noticed() {
    let inputs = rays(2000);
    let expression = format!("vec4f(altitude_along({R:?}, in.x, in.y, in.z), 0.0, 0.0, 0.0)");
    let cpu = twin(&inputs, |[h, mu, t, _]| [geometry::altitude_along(R, h, mu, t), 0.0, 0.0, 0.0]);
    let honest = Kernel::of("frame/sphere.wgsl");
    assert!(worst_error(&honest.evaluate(&expression, &inputs), &cpu, 1000.0).0 < 3e-4);
    let flipped = Kernel::of("frame/sphere.wgsl").sabotaged("t * (t + 2.0 *", "t * (t - 2.0 *");
    assert!(worst_error(&flipped.evaluate(&expression, &inputs), &cpu, 1000.0).0 > 0.1);

    let colours = vec![[0.5f32, 0.2, 0.1, 0.0]; 64];
    let cpu = twin(&colours, |[r, g, b, _]| tonemap::tonemap_agx(DVec3::new(r, g, b)).extend(0.0).to_array());
    let wrong = Kernel::of("output/tonemap.wgsl").sabotaged("31.96", "31.56");
    assert!(worst_error(&wrong.evaluate("vec4f(tonemap_agx(in.rgb), 0.0)", &colours), &cpu, 1.0).0 > 4e-4);
}
