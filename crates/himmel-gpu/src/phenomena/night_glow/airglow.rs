//! The layer of airglow: how much of it a line of sight crosses, and its colour.

use glam::DVec3;
use himmel_core::colour::Observer;
use himmel_core::constants::{PLANCK_J_S, SPEED_OF_LIGHT_M_S};

/// A shell of the upper air that glows.
///
/// Emission over the distance r from the planet's centre: 1 − ((r² − r₀²)/w²)², a parabola of altitude but for the curvature,
/// because a polynomial of r² can be integrated along any ray without an approximation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Distance of its middle from the planet's centre, m.
    pub radius_m: f64,
    /// The w of the formula: it ends where r² = r₀² ± w², m.
    pub unit_m: f64,
    /// w over what a vertical ray crosses, ∫ (1 − …) dr: so the result is 1 at the zenith.
    pub unit_over_vertical: f64,
}

/// Nodes and weights of three-point Gauss–Legendre on −1..1: exact for the quartic in s.
const NODES: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

impl Layer {
    /// Around an altitude; the thickness is that at half of the brightest.
    pub fn new(planet_radius_m: f64, altitude_m: f64, thickness_m: f64) -> Self {
        // A parabola has half its height at 1/√2 of its half width.
        let half_m = thickness_m / std::f64::consts::SQRT_2;
        let radius_m = planet_radius_m + altitude_m;
        let unit_m = (2.0 * radius_m * half_m).sqrt();
        Self { radius_m, unit_m, unit_over_vertical: unit_m / (4.0 / 3.0 * half_m) }
    }

    /// What a ray crosses relative to the zenith, on the near side of its point nearest to the planet and on the far side.
    ///
    /// With s along the ray from that point and r² = s² + p²: ∫ 1 − (s² + α)² ds in units of w, α = (p² − r₀²)/w². For a thin
    /// layer from below it is the function of van Rhijn, 1/√(1 − (R sin z/(R + h))²)   [vanrhijn1921]
    ///
    /// `distance_m`: of the eye from the centre. `below`: whether the ray meets the ground, which hides the far side.
    /// Twin of `airglow_path` in `night_glow.wgsl`.
    ///
    /// Laws tested: van Rhijn's from the ground; continuous through the layer; twice as much at the limb from above.
    pub fn path(&self, distance_m: f64, mu: f64, sin_theta: f64, below: bool) -> [f64; 2] {
        let nearest_m = distance_m * sin_theta;
        let alpha = (nearest_m - self.radius_m) * (nearest_m + self.radius_m) / (self.unit_m * self.unit_m);
        let outer = (1.0 - alpha).max(0.0).sqrt();
        let inner = (-1.0 - alpha).max(0.0).sqrt();
        let eye = distance_m * mu / self.unit_m;
        let near = self.between(alpha, inner, outer.min(-eye));
        let far = if below { 0.0 } else { self.between(alpha, inner.max(eye), outer) };
        [near, far]
    }

    fn between(&self, alpha: f64, from: f64, to: f64) -> f64 {
        let half = 0.5 * (to - from).max(0.0);
        let middle = from + half;
        let sum: f64 = NODES
            .iter()
            .map(|(node, weight)| {
                let s = middle + half * node;
                let u = s * s + alpha;
                weight * (1.0 - u * u)
            })
            .sum();
        half * sum * self.unit_over_vertical
    }
}

/// Lines of the nightglow: nm, rayleighs at the zenith   [leinert1998, table 13]
///
/// O I 557.7, Na D, O I 630.0 and 636.4 (typical values of variable lines).
const LINES: [(f64, f64); 4] = [(557.7, 250.0), (589.3, 50.0), (630.0, 60.0), (636.4, 20.0)];
/// The pseudo-continuum (NO₂, O₂) between the lines, rayleighs per nm from 500 to 650 nm   [leinert1998, table 13: 250 R]
/// and bands of OH beyond 600 nm are taken as one flat spectrum of photons: 0.3 R/Å, as dark sites measure it [noll2012].
const CONTINUUM_R_PER_NM: f64 = 3.0;

/// Airglow in S10 at the zenith for a solar radio flux: 145 + 130 (S − 0.8)/1.2, S in MJy (100 sfu)   [benn1998]
pub fn zenith_s10(solar_flux_sfu: f64) -> f64 {
    (145.0 + 130.0 * (solar_flux_sfu / 100.0 - 0.8) / 1.2).max(0.0)
}

/// The spectrum's photometric XYZ at the rayleighs above, cd m⁻².
///
/// One rayleigh is 10¹⁰/4π photons m⁻² s⁻¹ sr⁻¹.
pub fn xyz_cd_m2() -> DVec3 {
    let observer = Observer::cie1931();
    let radiance = |nm: f64, rayleighs: f64| {
        rayleighs * 1e10 / (4.0 * std::f64::consts::PI) * PLANCK_J_S * SPEED_OF_LIGHT_M_S / (nm * 1e-9)
    };
    // A line as a box of 5 nm, the step of the observer's table.
    let density = |nm: f64| {
        let lines: f64 =
            LINES.iter().filter(|(line, _)| (nm - line).abs() < 2.5).map(|(line, r)| radiance(*line, *r) / 5.0).sum();
        lines + radiance(nm, CONTINUUM_R_PER_NM)
    };
    observer.xyz_of(density)
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 6.371e6;

    fn path(layer: &Layer, altitude_m: f64, degrees: f64) -> [f64; 2] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let below = cos < 0.0 && (R + altitude_m) * sin < R;
        layer.path(R + altitude_m, cos, sin, below)
    }

    /// A layer of 1 km against the formula of an infinitely thin one.
    #[test]
    fn from_the_ground_it_is_van_rhijns_function() {
        let layer = Layer::new(R, 90e3, 1e3);
        for degrees in [0.0, 30.0, 60.0, 80.0, 90.0f64] {
            let law = 1.0 / (1.0 - (R * degrees.to_radians().sin() / (R + 90e3)).powi(2)).sqrt();
            let [near, far] = path(&layer, 0.0, degrees);
            println!("{degrees}°: {far:.4} {law:.4}");
            assert!(near == 0.0 && (far / law - 1.0).abs() < 2e-3, "{degrees}");
        }
    }

    #[test]
    fn seen_from_within_and_from_above() {
        let layer = Layer::new(R, 90e3, 10e3);
        // Straight down from orbit it is crossed once, the ground behind it; up, not at all.
        let down = path(&layer, 400e3, 180.0);
        assert!((down[0] - 1.0).abs() < 1e-3 && down[1] == 0.0);
        assert_eq!(path(&layer, 400e3, 0.0), [0.0; 2]);
        // From its middle half of it is above.
        assert!((path(&layer, 90e3, 0.0)[1] - 0.5).abs() < 1e-3);
        // Just above the limb both sides count alike, and together they are bright: a chord of 700 km in a layer of 10.
        let limb = path(&layer, 400e3, (R + 88e3).mul_add(0.0, 180.0 - ((R + 88e3) / (R + 400e3)).asin().to_degrees()));
        println!("limb {limb:?}");
        assert!((limb[0] / limb[1] - 1.0).abs() < 1e-6 && (30.0..120.0).contains(&(limb[0] + limb[1])));
    }

    #[test]
    fn it_is_continuous_in_altitude() {
        let layer = Layer::new(R, 90e3, 10e3);
        for degrees in [40.0, 89.0, 95.0] {
            let at = |h: f64| path(&layer, h, degrees).iter().sum::<f64>();
            let mut before = at(70e3);
            for i in 1..=400 {
                let now = at(70e3 + 100.0 * f64::from(i));
                assert!((now - before).abs() < 2.5, "{degrees}° {i}: {before} {now}");
                before = now;
            }
        }
    }

    /// Typical rayleighs make the luminance that is observed: 145 S10 = 1.2e-4 cd/m².
    #[test]
    fn the_spectrum_has_the_luminance_of_the_sky() {
        let xyz = xyz_cd_m2();
        let (x, y) = (xyz.x / (xyz.x + xyz.y + xyz.z), xyz.y / (xyz.x + xyz.y + xyz.z));
        println!("{:.2e} cd/m², x {x:.3} y {y:.3}", xyz.y);
        assert!((0.6e-4..2.5e-4).contains(&xyz.y));
        // Green-yellow.
        assert!((0.33..0.42).contains(&x) && (0.38..0.52).contains(&y));
        assert_eq!(zenith_s10(80.0), 145.0);
        assert!((zenith_s10(200.0) - 275.0).abs() < 1e-9);
    }
}
