//! Laws of the moments, and how far each knob still moves the result.

use std::f64::consts::PI;
use std::sync::OnceLock;

use himmel_core::quadrature::gauss_legendre_unit;
use himmel_core::spectrum::Spectrum;

use super::*;
use crate::irradiance::Directions;
use crate::medium::{Component, Medium};
use crate::single::{Ray, march};
use crate::{Phase, Preset, Profile};

/// A table that is quick to fill: for laws that hold however coarse it is.
fn quick() -> Quality {
    Quality {
        rows: 12,
        columns: 24,
        directions: [6, 4, 4],
        deep_directions: [6, 4, 4],
        fine_cells: 100,
        ..Quality::default()
    }
}

fn bruneton() -> Medium {
    Preset::named("bruneton2017").unwrap().medium
}

fn ray(altitude_m: f64, view_zenith_deg: f64, sun_zenith_deg: f64, azimuth_deg: f64) -> Ray {
    let (z, s) = (view_zenith_deg.to_radians(), sun_zenith_deg.to_radians());
    let nu = z.sin() * s.sin() * azimuth_deg.to_radians().cos() + z.cos() * s.cos();
    Ray { altitude_m, mu: z.cos(), mu_s: s.cos(), nu: nu.clamp(-1.0, 1.0) }
}

fn rays() -> Vec<Ray> {
    let mut rays = Vec::new();
    for sun in [20.0, 60.0, 85.0, 90.0, 94.0] {
        for (altitude_m, views) in
            [(0.0, [10.0, 75.0, 89.0]), (9000.0, [40.0, 91.0, 150.0]), (4e5, [110.0, 109.0, 160.0])]
        {
            for view in views {
                for azimuth in [5.0, 90.0, 180.0] {
                    rays.push(ray(altitude_m, view, sun, azimuth));
                }
            }
        }
    }
    rays
}

/// Median, 95th percentile and largest of |a/b − 1|, where b exceeds 1e-8: a few times the night sky (2e-4 cd/m² of the
/// Sun's 1.3e5 lx).
fn errors(a: &[f64], b: &[f64]) -> [f64; 3] {
    let mut errors: Vec<f64> = a.iter().zip(b).filter(|(_, b)| **b > 1e-8).map(|(a, b)| (a / b - 1.0).abs()).collect();
    errors.sort_by(f64::total_cmp);
    [errors[errors.len() / 2], errors[errors.len() * 95 / 100], errors[errors.len() - 1]]
}

fn look(medium: &Medium, columns: &Columns, moments: &Moments<1>, steps: usize) -> Vec<f64> {
    let air = medium.sampled(&[440.0]);
    rays().iter().map(|ray| radiance(&air, columns, moments, ray, steps)[0]).collect()
}

/// The recipe's table of `bruneton2017` at 440 nm, made once.
fn recipe() -> &'static (Medium, Columns, Moments<1>) {
    static MADE: OnceLock<(Medium, Columns, Moments<1>)> = OnceLock::new();
    MADE.get_or_init(|| {
        let medium = bruneton();
        let columns = Columns::new(&medium);
        let moments = Moments::build(&medium.sampled(&[440.0]), &columns, &Quality::default());
        (medium, columns, moments)
    })
}

/// ∫ p(ω·ω′) L(ω′) dω′ by quadrature is what the moments say, for any L, if p ends at l = 2.
#[test]
fn moments_scatter_a_field_exactly() {
    // A field that is symmetric about the plane of the Sun, as ours are; smooth, so that 40 × 80 nodes are exact.
    let field = |x: f64, z: f64| (0.7 * z + 0.4 * x).exp() + 0.2 * z.powi(3) + x * z;
    let (nodes, azimuths) = (gauss_legendre_unit(40), 80);
    let sum = |f: &dyn Fn([f64; 3]) -> f64| -> f64 {
        let mut sum = 0.0;
        for (u, w) in &nodes {
            let z = 2.0 * u - 1.0;
            let sin = (1.0 - z * z).sqrt();
            for j in 0..azimuths {
                let azimuth = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(azimuths);
                sum += 2.0 * w * 2.0 * PI / f64::from(azimuths) * f([sin * azimuth.cos(), sin * azimuth.sin(), z]);
            }
        }
        sum
    };
    let gamma = 0.0143;
    let chi_2 = (1.0 - gamma) / (10.0 * (1.0 + 2.0 * gamma));
    let polynomial = |c: f64| (1.0 + 3.0 * 0.6 * c + 5.0 * 0.3 * 0.5 * (3.0 * c * c - 1.0)) / (4.0 * PI);
    let moments: Six<1> = [
        [sum(&|[x, _, z]| field(x, z))],
        [sum(&|[x, _, z]| field(x, z) * x)],
        [sum(&|[x, _, z]| field(x, z) * z)],
        [sum(&|[x, _, z]| field(x, z) * (x * x - 1.0 / 3.0))],
        [sum(&|[x, _, z]| field(x, z) * (z * z - 1.0 / 3.0))],
        [sum(&|[x, _, z]| field(x, z) * x * z)],
    ];
    let mu_s = 0.3f64;
    for (view_z, azimuth) in [(0.2f64, 0.4f64), (-0.8, 2.0), (1.0, 0.0), (0.0, PI), (-0.1, 1.5)] {
        let sin = (1.0 - view_z * view_z).sqrt();
        let view = [sin * azimuth.cos(), sin * azimuth.sin(), view_z];
        let nu = view[0] * (1.0 - mu_s * mu_s).sqrt() + view[2] * mu_s;
        let direct = |p: &dyn Fn(f64) -> f64| {
            // Light travels along ω′ and leaves against the view.
            sum(&|[x, y, z]| p(-(view[0] * x + view[1] * y + view[2] * z)) * field(x, z))
        };
        for (weights, expected) in [
            ([[1.0], [0.0], [chi_2]], direct(&|c| crate::phase::rayleigh_phase(c, gamma))),
            ([[1.0], [0.6], [0.3]], direct(&polynomial)),
        ] {
            let mut ours = [0.0];
            build::add_scattered(&mut ours, &moments, &weights, view[2], mu_s, nu);
            assert!((ours[0] / expected - 1.0).abs() < 1e-12, "{view:?}: {} {expected}", ours[0]);
        }
    }
}

/// Nothing is lost: without absorption, what a whole planet sends out at its top and what its ground keeps is what it
/// takes from the Sun's rays: all of its disc, and from the ring of air around it 1 − T.
///
/// ∫F_z dA (top) + (1 − albedo) ∫E dA (ground) = π R² + ∫ 2πb (1 − T(b)) db
#[test]
fn a_planet_loses_no_light() {
    let mut medium = bruneton();
    medium.components.retain(|c| c.name == "air");
    medium.ground_albedo = Spectrum::Constant(0.3);
    // Optical depth 0.26 and 2.1: the recipe loses 0.04 % and 0.4 %, these fewer directions a little more. It is the
    // rows of the table: straight chords under the arch of ln G; twice as many leave 0.06 % of the latter.
    for (amount, top, bound) in [(1.0, 60e3, 1e-3), (8.0, 80e3, 8e-3)] {
        medium.components[0].amount = amount;
        medium.top_altitude_m = top;
        let air = medium.sampled(&[440.0]);
        let columns = Columns::with_size(&medium, 256, 128);
        let quality = Quality { directions: [8, 6, 4], deep_directions: [8, 6, 4], ..Quality::default() };
        let moments = Moments::build(&air, &columns, &quality);
        let (r, top_r) = (medium.bottom_radius_m, medium.bottom_radius_m + top);
        let (mut came, mut went) = (PI * r * r, 0.0);
        let rule = gauss_legendre_unit(200);
        for &(x, w) in &rule {
            let tangent_m = x * x * top;
            let through = (-2.0 * columns.optical_depth(&air, tangent_m, 0.0)[0]).exp();
            came += w * 2.0 * x * top * 2.0 * PI * (r + tangent_m) * (1.0 - through);
            for mu_s in [x * x, -x * x] {
                let up = moments.at(top, mu_s)[2][0] * top_r * top_r;
                let kept = 0.7 * moments.ground_irradiance(&columns, mu_s)[0] * r * r;
                went += w * 2.0 * x * 2.0 * PI * (up + kept);
            }
        }
        assert!((went / came - 1.0).abs() < bound, "{amount}: {went} {came}");
    }
}

#[test]
fn air_that_scatters_nothing_is_black() {
    let mut medium = bruneton();
    medium.ground_albedo = Spectrum::Constant(0.0);
    for (name, keep) in [("ozone", true), ("no such", false)] {
        medium.components.retain(|c| c.name == name);
        assert_eq!(medium.components.is_empty(), !keep);
        let columns = Columns::new(&medium);
        let air = medium.sampled(&[440.0]);
        let moments = Moments::build(&air, &columns, &quick());
        for mu_s in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            assert_eq!(moments.at(3000.0, mu_s), [[0.0]; 6]);
        }
        for ray in rays() {
            assert_eq!(radiance(&air, &columns, &moments, &ray, 32), [0.0]);
        }
        assert!((moments.ground_irradiance(&columns, 0.8)[0] / 0.8 - 1.0).abs() < 0.1);
    }
    // Light that the ground reflects is in the field of light, air or not.
    medium.ground_albedo = Spectrum::Constant(0.5);
    let columns = Columns::new(&medium);
    let moments = Moments::build(&medium.sampled(&[440.0]), &columns, &quick());
    let g = moments.at(0.0, 1.0)[0][0];
    assert!((g - 1.0).abs() < 1e-6, "2π · 0.5/π: {g}");
}

/// Components of no amount change nothing; one aerosol is the same as two halves of it.
#[test]
fn only_amounts_matter_and_not_how_they_are_told() {
    let medium = bruneton();
    let columns = Columns::new(&medium);
    let moments = Moments::build(&medium.sampled(&[440.0]), &columns, &quick());
    let expected = look(&medium, &columns, &moments, 32);

    let mut more = medium.clone();
    let phase = Some(Phase::HenyeyGreenstein { g: Spectrum::Constant(0.95) });
    more.components.push(Component { amount: 0.0, phase, ..medium.components[1].clone() });
    let columns = Columns::new(&more);
    let moments = Moments::build(&more.sampled(&[440.0]), &columns, &quick());
    assert_eq!(look(&more, &columns, &moments, 32), expected);

    let mut halves = medium.clone();
    halves.components[1].amount = 0.5;
    halves.components.push(halves.components[1].clone());
    let columns = Columns::new(&halves);
    let moments = Moments::build(&halves.sampled(&[440.0]), &columns, &quick());
    let [.., worst] = errors(&look(&halves, &columns, &moments, 32), &expected);
    assert!(worst < 1e-10, "{worst}");
}

/// With molecules alone nothing is scaled, and the frame's first order is the march of `single.rs`. That one takes
/// twelve steps through the shadow, however many outside: 2 % there, against 0.1 %.
#[test]
fn the_first_order_is_the_march() {
    let mut medium = bruneton();
    medium.components.retain(|c| c.name != "aerosol");
    medium.ground_albedo = Spectrum::Constant(0.0);
    let columns = Columns::new(&medium);
    let air = medium.sampled(&[440.0]);
    let nothing = Moments::build(&air, &columns, &Quality { max_orders: 0, ..quick() });
    assert_eq!(nothing.orders(), 0);
    for ray in rays() {
        let (ours, theirs) =
            (radiance(&air, &columns, &nothing, &ray, 8000)[0], march(&air, &columns, &ray, 8000).radiance_per_sr[0]);
        let dark = ray.mu_s < 0.1;
        assert!((ours - theirs).abs() < if dark { 2e-2 } else { 1e-3 } * theirs + 1e-12, "{ray:?}: {ours} {theirs}");
    }
}

/// ∫ B_U dω = 1 and ∫ B_S dω = f (1 − e^(−τ))/τ: no light is lost or made; B → p in thin air; and both are the sums of
/// the recipe, term by term.
#[test]
fn stretches_of_clear_air_add_up() {
    let mut medium = bruneton();
    medium
        .components
        .retain(|component| component.phase.as_ref().is_none_or(|phase| matches!(phase, Phase::Rayleigh { .. })));
    let columns = Columns::new(&medium);
    let air = medium.sampled(&[440.0]);
    let moments = Moments::build(&air, &columns, &quick());
    for (view_zenith_deg, sun_zenith_deg) in [(60.0, 40.0), (91.0, 85.0), (88.0, 93.0)] {
        let from = ray(2000.0, view_zenith_deg, sun_zenith_deg, 30.0);
        let cells = 2000;
        let [whole] = radiance(&air, &columns, &moments, &from, cells);
        assert_eq!(radiance_to(&air, &columns, &moments, &from, cells, f64::INFINITY), [whole]);
        assert_eq!(radiance_to(&air, &columns, &moments, &from, cells, 0.0), [0.0]);
        let d = 4e4;
        let [near] = radiance_to(&air, &columns, &moments, &from, cells, d);
        let (r0, radius_m) = (medium.bottom_radius_m + from.altitude_m, medium.bottom_radius_m);
        let r = (r0 * r0 + d * d + 2.0 * r0 * from.mu * d).sqrt();
        let there = Ray {
            altitude_m: r - radius_m,
            mu: (r0 * from.mu + d) / r,
            mu_s: (r0 * from.mu_s + d * from.nu) / r,
            nu: from.nu,
        };
        let [beyond] = radiance(&air, &columns, &moments, &there, cells);
        let through = |ray: &Ray| march(&air, &columns, ray, cells).transmittance[0];
        let sum = near + through(&from) / through(&there) * beyond;
        assert!(near < whole && (sum / whole - 1.0).abs() < 2e-3, "{view_zenith_deg} {sun_zenith_deg}: {sum} {whole}");
    }
}

#[test]
fn forward_peaks_keep_their_light() {
    let g = 0.8f64;
    let mut medium = bruneton();
    medium.components.retain(|c| c.name == "aerosol");
    medium.components[0].phase = Some(Phase::HenyeyGreenstein { g: Spectrum::Constant(g) });
    let optics = Optics::new(&medium.sampled(&[550.0]), 192);
    let peaks = Peaks::new(&medium.components, &optics, medium.top_altitude_m, 128, 32);
    let f = g.powi(3);
    let smooth = |c: f64| {
        let [chi_1, chi_2] = optics.scatterers[0].scaled_chi.map(|chi| chi[0]);
        (1.0 + 3.0 * chi_1 * c + 5.0 * chi_2 * 0.5 * (3.0 * c * c - 1.0)) / (4.0 * PI)
    };
    let both = |c: f64, tau: f64| {
        let at = peaks.at_angle(c);
        let p = crate::phase::henyey_greenstein_phase(c, g);
        [(-tau).exp() * (p - (1.0 - f) * smooth(c)) + at.at(0, 0, 0, tau), (-tau).exp() * p + at.at(0, 1, 0, tau)]
    };
    let recipe = |c: f64, tau: f64| {
        let mut sums = [0.0; 2];
        crate::phase::for_each_legendre(c, 400, |l, p| {
            let chi = g.powi(l as i32);
            let peak = if l < 4 { 1.0 } else { chi / f };
            let factor = (2 * l + 1) as f64 / (4.0 * PI) * p;
            sums[0] += factor * f * ((-tau * (1.0 - peak)).exp() - (-tau).exp()) / tau;
            sums[1] += factor * chi * (-tau * (1.0 - peak)).exp();
        });
        sums
    };
    for tau in [1e-3, 0.1, 0.7, 3.0, 9.0] {
        let mut total = [0.0; 2];
        for (x, w) in gauss_legendre_unit(400) {
            let theta = PI * x * x;
            let b = both(theta.cos(), tau);
            for s in 0..2 {
                total[s] += w * 2.0 * PI * x * 2.0 * PI * theta.sin() * b[s];
            }
        }
        let expected = [f * -(-tau).exp_m1() / tau, 1.0];
        for s in 0..2 {
            // What interpolation in the table costs.
            assert!((total[s] / expected[s] - 1.0).abs() < 2e-3, "{tau}: {total:?} {expected:?}");
        }
        for degrees in [0.0f64, 1.0, 5.0, 20.0, 60.0, 120.0, 180.0] {
            let c = degrees.to_radians().cos();
            let (ours, sums) = (both(c, tau), recipe(c, tau));
            for s in 0..2 {
                // S and U change sign between the angles: relative to the phase function there, too.
                let scale = sums[s].abs() + crate::phase::henyey_greenstein_phase(c, g);
                assert!((ours[s] - sums[s]).abs() < 5e-3 * scale, "{tau} {degrees}: {ours:?} {sums:?}");
            }
        }
    }
    assert!(peaks.remainder < 1e-12);
}

/// The sums over the half spheres are what the table knows: the ground's irradiance, and the net flux aloft.
#[test]
fn irradiances_agree_with_the_moments() {
    let (medium, columns, moments) = recipe();
    let air = medium.sampled(&[440.0]);
    let directions = Directions { zenith: 12, azimuth: 8, steps: 48 };
    for elevation_deg in [60.0f64, 10.0, 0.5, -4.0] {
        let mu_s = elevation_deg.to_radians().sin();
        let ground = irradiance(&air, columns, moments, 0.0, mu_s, directions);
        let table = moments.ground_irradiance(columns, mu_s)[0];
        let sum = ground.direct[0] + ground.down[0];
        assert!((sum / table - 1.0).abs() < 5e-3, "{elevation_deg}: {sum} {table}");
        assert!((ground.up[0] / (0.1 * table) - 1.0).abs() < 1e-3, "{elevation_deg}: the ground's own light");
        let aloft = irradiance(&air, columns, moments, 8000.0, mu_s, directions);
        let flux = moments.at(8000.0, mu_s)[2][0];
        let net = aloft.up[0] - aloft.down[0];
        assert!((net - flux).abs() < 5e-3 * (aloft.up[0] + aloft.down[0]), "{elevation_deg}: {net} {flux}");
    }
}

/// Each knob has converged: turning it up moves the sky by no more than the recipe's own error, which is 0.12 % in the
/// median and 0.6 % at the 95th percentile by day, a few times that in twilight.
#[test]
fn the_recipe_has_converged() {
    let (medium, columns, moments) = recipe();
    let air = medium.sampled(&[440.0]);
    let seen = look(medium, columns, moments, 256);
    let check = |what: &str, other: &[f64], bounds: [f64; 3]| {
        let errors = errors(&seen, other);
        assert!(errors.iter().zip(bounds).all(|(error, bound)| *error < bound), "{what}: {errors:?}");
    };
    check("cells of the frame", &look(medium, columns, moments, 32), [1.5e-3, 6e-3, 2e-2]);
    let finer = Quality {
        rows: 36,
        columns: 72,
        directions: [14, 9, 7],
        deep_directions: [18, 14, 9],
        fine_cells: 400,
        cells: 20,
        cumulative_cells: 160,
        lit_samples: 30,
        ..Quality::default()
    };
    // The worst are the limb's of the night side, seen from space: an arch of light at the edge of the world lights
    // them.
    check("table", &look(medium, columns, &Moments::build(&air, columns, &finer), 256), [1e-3, 4e-3, 0.1]);
    let rounded = |half_floats| {
        let moments = Moments::build(&air, columns, &Quality { half_floats, ..quick() });
        look(medium, columns, &moments, 64)
    };
    let [_, p95, worst] = errors(&rounded(true), &rounded(false));
    assert!(p95 < 3e-3 && worst < 5e-3, "half floats: {p95} {worst}");
}

#[test]
fn the_result_does_not_depend_on_chance() {
    let medium = bruneton();
    let columns = Columns::new(&medium);
    let make = || Moments::build(&medium.sampled(&[440.0]), &columns, &quick());
    assert_eq!(look(&medium, &columns, &make(), 32), look(&medium, &columns, &make(), 32));
    assert_eq!(build::in_parallel(100, |i| i * i), (0..100).map(|i| i * i).collect::<Vec<_>>());
}

/// Absurd sizes and rays give numbers or black, and no panic.
#[test]
fn nonsense_is_survived() {
    let none = Quality {
        rows: 0,
        columns: 0,
        directions: [0; 3],
        deep_directions: [0; 3],
        fine_cells: 0,
        cells: 0,
        cumulative_cells: 0,
        lit_samples: 0,
        max_orders: 3,
        tolerance: f64::NAN,
        legendre_terms: 0,
        peak_angles: 0,
        peak_depths: 0,
        half_floats: true,
    };
    let mut medium = bruneton();
    medium.components[1].profile = Profile::Table { altitude_m: vec![], value: vec![] };
    let columns = Columns::new(&medium);
    let air = medium.sampled(&[440.0]);
    let moments = Moments::build(&air, &columns, &none);
    for altitude_m in [f64::NAN, f64::INFINITY, -5.0, 0.0, 6e4, 1e9] {
        for mu in [f64::NAN, -2.0, -1.0, -1e-9, 0.0, 1.0, 7.0] {
            for steps in [0, 3] {
                let ray = Ray { altitude_m, mu, mu_s: 0.3, nu: mu };
                let _ = radiance(&air, &columns, &moments, &ray, steps);
                let ray = Ray { altitude_m, mu: 0.3, mu_s: mu, nu: 0.3 };
                let _ = radiance(&air, &columns, &moments, &ray, steps);
                let _ = moments.at(altitude_m, mu);
            }
        }
    }
    assert!(moments.at(0.0, 0.5)[0][0].is_finite());
}
