//! Rays that graze a planet: what the air does to light that comes from space and goes back to it.

use std::f64::consts::{FRAC_PI_2, PI};

use himmel_core::quadrature::gauss_legendre_unit;

use super::Path;
use super::bending::{LEAST_SLOPE, index};
use crate::medium::Medium;

/// Nodes of the integral along half a ray.
const STEPS: usize = 64;

/// A ray past the planet, the same on both sides of its lowest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grazing {
    /// Its lowest altitude, m.
    pub lowest_m: f64,
    /// Distance of its straight ends from the planet's centre, m.
    pub impact_m: f64,
    /// By how much it is turned towards the planet, rad.
    pub deviation_rad: f64,
    /// Optical depth of the air.
    pub optical_depth: f64,
    /// Length that an even layer would have to be passed at right angles to meet as much of a thin dust layer, per unit of
    /// its vertical depth: see [`DUST_ALTITUDE_M`].
    pub dust_air_mass: f64,
}

/// Middle of the layer of volcanic dust, and its standard deviation, m: where sulphate droplets stood after 1991   [keen1983]
pub const DUST_ALTITUDE_M: f64 = 20e3;
const DUST_WIDTH_M: f64 = 4e3;

/// Follows rays of one wavelength whose lowest points stand at `lowest_m`, m, within the air.
///
/// With ψ the ray's own zenith distance and n r sin ψ = constant (Bouguer), of which half a ray has ψ from the top of the
/// air to 90°:   turn = ∫ −(r dn/dr)/(n + r dn/dr) dψ,   ds = n r/(n + r dn/dr) dψ / sin ψ   [auer2000]
///
/// Laws tested: [`trace`](super::trace) finds the same turn and depth; without refractivity the path is a chord.
pub fn grazing(medium: &Medium, wavelength_nm: f64, lowest_m: &[f64]) -> Vec<Grazing> {
    let path = Path::new(medium, wavelength_nm);
    let rule = gauss_legendre_unit(STEPS);
    let radius_m = medium.bottom_radius_m;
    let dust = |altitude_m: f64| {
        let x = (altitude_m - DUST_ALTITUDE_M) / DUST_WIDTH_M;
        (-0.5 * x * x).exp() / (DUST_WIDTH_M * (2.0 * PI).sqrt())
    };
    let one = |&lowest_m: &f64| {
        let impact_m = (radius_m + lowest_m) * (1.0 + index(&path, lowest_m).0);
        let from = (impact_m / (radius_m + medium.top_altitude_m)).min(1.0).asin();
        let mut sum = [0.0; 3];
        for &(x, w) in &rule {
            let psi = from + (FRAC_PI_2 - from) * x;
            let target = impact_m / psi.sin();
            // Newton on r n(r) = target, from r = target: n is nearly 1.
            let mut altitude_m = target - radius_m;
            let (mut turn, mut length_m) = (0.0, 0.0);
            for _ in 0..8 {
                let (refractivity, gradient) = index(&path, altitude_m);
                let (n, bend) = (1.0 + refractivity, (radius_m + altitude_m) * gradient);
                let slope = (n + bend).max(LEAST_SLOPE * n);
                turn = -bend / slope;
                length_m = n * (radius_m + altitude_m) / (slope * psi.sin());
                let step = ((radius_m + altitude_m) * n - target) / slope;
                altitude_m -= step;
                if step.abs() < 1e-3 {
                    break;
                }
            }
            let weight = 2.0 * w * (FRAC_PI_2 - from);
            let altitude_m = altitude_m.max(0.0);
            sum[0] += weight * turn;
            sum[1] += weight * length_m * path.at(altitude_m).1;
            sum[2] += weight * length_m * dust(altitude_m);
        }
        let [deviation_rad, optical_depth, dust_air_mass] = sum;
        Grazing { lowest_m, impact_m, deviation_rad, optical_depth, dust_air_mass }
    };
    lowest_m.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use crate::refraction::{End, trace};

    /// Against the path followed step by step from space: 0.5 % of the turn, 1 % of the depth (its own steps of 250 m).
    #[test]
    fn grazing_rays_are_those_traced() {
        let earth = Preset::named("earth").unwrap().medium;
        for ray in grazing(&earth, 560.0, &[1000.0, 5000.0, 10e3, 20e3, 40e3, 70e3]) {
            let far_m = earth.top_altitude_m + 1000.0;
            let elevation = -(ray.impact_m / (earth.bottom_radius_m + far_m)).acos();
            let bent = trace(&earth, 560.0, far_m, elevation).unwrap();
            println!(
                "{} m: turn {:.3}′ {:.3}′, depth {:.4e} {:.4e}",
                ray.lowest_m,
                ray.deviation_rad.to_degrees() * 60.0,
                bent.deviation_rad.to_degrees() * 60.0,
                ray.optical_depth,
                bent.optical_depth
            );
            assert_eq!(bent.end, End::Space);
            assert!((ray.deviation_rad / bent.deviation_rad - 1.0).abs() < 5e-3);
            assert!((ray.optical_depth / bent.optical_depth - 1.0).abs() < 1e-2);
            assert!((ray.lowest_m - bent.lowest_m).abs() < 30.0);
        }
    }

    /// A chord through a thin layer at 20 km, from below it: 1 / cos of where it meets it.
    #[test]
    fn dust_is_met_twice() {
        let bare = Preset::named("bruneton2017").unwrap().medium;
        let ray = grazing(&bare, 560.0, &[5000.0])[0];
        let sine = (bare.bottom_radius_m + 5000.0) / (bare.bottom_radius_m + DUST_ALTITUDE_M);
        let expected = 2.0 / (1.0 - sine * sine).sqrt();
        assert_eq!(ray.deviation_rad, 0.0);
        // The layer is 4 km thick: what is nearer the ray counts for more.
        assert!((ray.dust_air_mass / expected - 1.0).abs() < 0.06, "{} {expected}", ray.dust_air_mass);
    }
}
