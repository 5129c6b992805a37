//! How the whole sky is bent for one observer: true elevation over apparent elevation, for discs and stars.

use std::f64::consts::{FRAC_PI_2, PI};

use himmel_core::quadrature::gauss_legendre_unit;

use super::{Bent, End, Path, trace};
use crate::error::AirError;
use crate::medium::Medium;

/// Nodes of the map over elevation. Between them it errs by 0.01′ from the ground and 0.1′ from an aeroplane.
pub const NODES: usize = 32;
/// Nodes of the integral along one ray.
const STEPS: usize = 48;
/// How fast the nodes spread from the horizon up, rad: half a degree.
const WIDTH_RAD: f64 = 0.5 * PI / 180.0;
/// Above this altitude they stand closer, m.
const HIGH_M: f64 = 20e3;
/// The least of (n + r dn/dr)/n: air denser than that towards the ground would keep horizontal light for good.
pub(super) const LEAST_SLOPE: f64 = 0.2;
/// How far below the horizon the map goes on, rad: what is deeper hides behind the ground.
const BELOW_RAD: f64 = 0.02;

/// By how much the air lifts what is seen, over apparent elevation, for one altitude: 32 numbers and four ratios.
///
/// Elevations are e = e₀ + w sinh(x asinh((π/2 − e₀)/w)), x = 0..=1, from the lowest e₀ that clears the ground; between
/// nodes cubics with the slope of their neighbours. Below e₀ (rays that end on the ground) a straight line goes on.
/// One integral a node, at the second wavelength; others are scaled by n − 1 ([`Bending::ratio`]), 0.1′ too little for
/// violet at the horizon.
///
/// Laws tested: agrees with rays followed step by step; without air 0; true rises with apparent elevation; back and forth;
/// the setting Sun is flattened by a sixth and green on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bending {
    /// The lowest elevation that clears the ground, rad.
    pub lowest_rad: f64,
    /// How fast the nodes spread from there, w, rad.
    pub width_rad: f64,
    /// asinh((π/2 − e₀)/w).
    pub span: f64,
    /// Deviation at the nodes, rad: apparent minus true elevation.
    pub deviation_rad: [f64; NODES],
    /// Deviation at each wavelength over that of the table.
    pub ratio: [f64; 4],
}

/// n − 1 and dn/dr at an altitude; nothing above the top.
pub(super) fn index(path: &Path<'_>, altitude_m: f64) -> (f64, f64) {
    if altitude_m > path.medium.top_altitude_m {
        return (0.0, 0.0);
    }
    let refractivity = path.at(altitude_m.max(0.0)).0;
    (refractivity, path.gradient_per_m(altitude_m.max(0.0)) * (1.0 + refractivity))
}

/// Deviation of the ray that arrives at a zenith distance, without steps along it.
///
/// R = ∫ −(r dn/dr) / (n + r dn/dr) dψ from the top of the air to the observer, r(ψ) from r n sin ψ = constant   [auer2000]
///
/// ψ: the ray's own zenith distance; it passes 90° smoothly where the ray is lowest, so nothing is special at the horizon.
///
/// `altitude_m`: of the observer, also above the air. `zenith_rad`: apparent zenith distance.
/// Laws tested: [`trace`] within 0.1″ above the horizon.
fn deviation_rad(path: &Path<'_>, altitude_m: f64, zenith_rad: f64) -> f64 {
    let radius_m = path.medium.bottom_radius_m;
    let constant = (radius_m + altitude_m) * (1.0 + index(path, altitude_m).0) * zenith_rad.sin();
    let sine_at_top = constant / (radius_m + path.medium.top_altitude_m);
    if sine_at_top >= 1.0 {
        return 0.0;
    }
    let from = sine_at_top.asin();
    let to = zenith_rad.min(PI - from);
    if to <= from {
        return 0.0;
    }
    let sum = |(x, w): (f64, f64)| {
        let psi = from + (to - from) * x;
        let target = constant / psi.sin();
        // Newton on r n(r) = target, from r = target: n is nearly 1.
        let mut altitude = target - radius_m;
        let mut integrand = 0.0;
        for _ in 0..6 {
            let (refractivity, gradient) = index(path, altitude);
            let (n, bend) = (1.0 + refractivity, (radius_m + altitude) * gradient);
            let slope = (n + bend).max(LEAST_SLOPE * n);
            integrand = -bend / slope;
            let step = ((radius_m + altitude) * n - target) / slope;
            altitude -= step;
            if step.abs() < 1e-3 {
                break;
            }
        }
        w * integrand
    };
    (to - from) * gauss_legendre_unit(STEPS).into_iter().map(sum).sum::<f64>()
}

impl Bending {
    /// Nothing bends.
    pub fn none() -> Self {
        let span = (PI / WIDTH_RAD).asinh();
        Self { lowest_rad: -FRAC_PI_2, width_rad: WIDTH_RAD, span, deviation_rad: [0.0; NODES], ratio: [1.0; 4] }
    }

    /// Of a medium for an observer at an altitude (m, also above the air), at four wavelengths.
    pub fn new(medium: &Medium, wavelengths_nm: &[f64; 4], altitude_m: f64) -> Self {
        let altitude_m = altitude_m.clamp(0.0, 1e9);
        let path = Path::new(medium, wavelengths_nm[1]);
        let at_ground = |nm: f64| Path::new(medium, nm).at(0.0).0;
        if path.at(0.0).0 <= 0.0 {
            return Self::none();
        }
        let ratio = wavelengths_nm.map(|nm| at_ground(nm) / at_ground(wavelengths_nm[1]));
        // Bouguer: the ray that touches the ground.
        let touching = medium.bottom_radius_m * (1.0 + path.at(0.0).0)
            / ((medium.bottom_radius_m + altitude_m) * (1.0 + index(&path, altitude_m).0));
        let lowest_rad = -touching.min(1.0).acos();
        // From afar the layer that bends is thin: 0.1° at 400 km.
        let width_rad = WIDTH_RAD * (HIGH_M / altitude_m.max(HIGH_M)).sqrt();
        let span = ((FRAC_PI_2 - lowest_rad) / width_rad).asinh();
        let node = |i: usize| {
            let elevation_rad = lowest_rad + width_rad * (span * i as f64 / (NODES - 1) as f64).sinh();
            let deviation = deviation_rad(&path, altitude_m, FRAC_PI_2 - elevation_rad.min(FRAC_PI_2));
            if deviation.is_finite() { deviation.clamp(0.0, 0.5) } else { 0.0 }
        };
        Self { lowest_rad, width_rad, span, deviation_rad: std::array::from_fn(node), ratio }
    }

    /// Apparent minus true elevation at an apparent elevation, at the second wavelength, and how it changes with it.
    pub fn deviation(&self, apparent_rad: f64) -> (f64, f64) {
        let above = (apparent_rad - self.lowest_rad).clamp(-BELOW_RAD, FRAC_PI_2 - self.lowest_rad);
        let last = (NODES - 1) as f64;
        let x = (above / self.width_rad).asinh() / self.span * last;
        let per_rad = last / (self.span * above.hypot(self.width_rad));
        let i = (x.max(0.0) as usize).min(NODES - 2);
        let y = |j: usize| self.deviation_rad[j.min(NODES - 1)];
        // Slopes by neighbours; at the ends those of the cell.
        let low = if i == 0 { y(1) - y(0) } else { 0.5 * (y(i + 1) - y(i - 1)) };
        let high = if i == NODES - 2 { y(i + 1) - y(i) } else { 0.5 * (y(i + 2) - y(i)) };
        let t = x - i as f64;
        if t < 0.0 {
            return (y(0) + low * t, low * per_rad);
        }
        let rise = y(i + 1) - y(i);
        let (a, b) = (3.0 * rise - 2.0 * low - high, low + high - 2.0 * rise);
        (y(i) + t * (low + t * (a + t * b)), (low + t * (2.0 * a + t * 3.0 * b)) * per_rad)
    }

    /// Where what is seen at an apparent elevation stands without air, at one of the four wavelengths.
    pub fn true_rad(&self, apparent_rad: f64, wavelength: usize) -> f64 {
        apparent_rad - self.deviation(apparent_rad).0 * self.ratio[wavelength.min(3)]
    }

    /// The same map over true elevation: [`deviation`](Self::deviation) of the result takes where something stands and
    /// gives by how much higher it is seen. For shaders that move many points.
    ///
    /// Laws tested: [`apparent_rad`](Self::apparent_rad) within 1″ down to the horizon of the ground.
    pub fn lift(&self) -> Self {
        let lowest_rad = self.true_rad(self.lowest_rad, 1);
        let span = ((FRAC_PI_2 - lowest_rad) / self.width_rad).asinh();
        let node = |i: usize| {
            let true_rad = lowest_rad + self.width_rad * (span * i as f64 / (NODES - 1) as f64).sinh();
            (self.apparent_rad(true_rad.min(FRAC_PI_2)) - true_rad.min(FRAC_PI_2)).max(0.0)
        };
        Self { lowest_rad, span, deviation_rad: std::array::from_fn(node), ..self.clone() }
    }

    /// Where something is seen that stands at a true elevation, at the second wavelength. What the ground hides is put
    /// as far above its place as the lowest that can be seen.
    pub fn apparent_rad(&self, true_rad: f64) -> f64 {
        // The cubics may dip below zero by a hair near the zenith.
        let (mut low, mut high) = (true_rad - 1e-3, true_rad + 0.5);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if self.true_rad(middle, 1) < true_rad { low = middle } else { high = middle }
        }
        high
    }
}

/// The same deviation by following the ray step by step: for tests, and for whoever wants it.
pub fn traced_deviation_rad(
    medium: &Medium,
    wavelength_nm: f64,
    altitude_m: f64,
    elevation_rad: f64,
) -> Result<Option<f64>, AirError> {
    let Bent { deviation_rad, end, .. } = trace(medium, wavelength_nm, altitude_m, elevation_rad)?;
    Ok((end == End::Space).then_some(deviation_rad))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use crate::refraction::bennett_arcmin;

    const FOUR: [f64; 4] = [630.0, 560.0, 490.0, 430.0];

    fn arcmin(radians: f64) -> f64 {
        radians.to_degrees() * 60.0
    }

    #[test]
    fn the_integral_is_the_traced_ray() {
        for (name, altitudes) in [("earth", [0.0, 2000.0, 35e3]), ("mars", [0.0, 5000.0, 20e3])] {
            let medium = Preset::named(name).unwrap().medium;
            let path = Path::new(&medium, 560.0);
            for altitude_m in altitudes {
                for degrees in [-0.4f64, 0.0, 0.3, 2.0, 10.0, 45.0, 89.0] {
                    let Some(traced) = traced_deviation_rad(&medium, 560.0, altitude_m, degrees.to_radians()).unwrap()
                    else {
                        continue;
                    };
                    let ours = deviation_rad(&path, altitude_m, FRAC_PI_2 - degrees.to_radians());
                    let arcsec = arcmin(ours - traced) * 60.0;
                    assert!(arcsec.abs() < 0.15, "{name} {altitude_m} m, {degrees}°: {arcsec}″ of {}′", arcmin(traced));
                }
            }
        }
    }

    /// 34.5′ at the horizon, 9.9′ at 5°, 5.4′ at 10° [bennett1982]; `earth` is 15 °C warm and of one temperature.
    #[test]
    fn the_map_is_bennetts() {
        let earth = Preset::named("earth").unwrap().medium;
        let start = std::time::Instant::now();
        let bending = Bending::new(&earth, &FOUR, 0.0);
        println!("{:?}", start.elapsed());
        for (degrees, tolerance) in [(0.0, 2.1), (0.5, 1.7), (2.0, 1.0), (5.0, 0.4), (10.0, 0.2), (30.0, 0.1)] {
            let ours = arcmin(bending.deviation(f64::to_radians(degrees)).0);
            println!("{degrees}°: {ours:.2}′, Bennett {:.2}′", bennett_arcmin(degrees));
            assert!((ours - bennett_arcmin(degrees)).abs() < tolerance, "{degrees}: {ours}");
        }
    }

    #[test]
    fn the_map_holds_between_its_nodes() {
        let earth = Preset::named("earth").unwrap().medium;
        let path = Path::new(&earth, FOUR[1]);
        for altitude_m in [0.0, 2.0, 1000.0, 11e3, 400e3] {
            let mut worst: f64 = 0.0;
            let bending = Bending::new(&earth, &FOUR, altitude_m);
            let mut before = f64::NEG_INFINITY;
            for i in 0..600 {
                let above = 1e-5 * 1.02f64.powi(i);
                let elevation = bending.lowest_rad + above;
                if elevation > FRAC_PI_2 {
                    break;
                }
                let (deviation, slope) = bending.deviation(elevation);
                let exact = deviation_rad(&path, altitude_m, FRAC_PI_2 - elevation);
                let error = arcmin(deviation - exact).abs();
                worst = worst.max(error);
                let step = 1e-7;
                let difference =
                    (bending.deviation(elevation + step).0 - bending.deviation(elevation - step).0) / (2.0 * step);
                assert!(
                    (difference - slope).abs() < 1e-3 + 0.02 * slope.abs(),
                    "{altitude_m} {above}: {difference} {slope}"
                );
                let place = bending.true_rad(elevation, 1);
                assert!(place > before);
                before = place;
                assert!((bending.apparent_rad(place) - elevation).abs() < 1e-9);
            }
            println!("{altitude_m} m: worst {worst:.3}′");
            assert!(worst < if altitude_m > 1e5 { 0.5 } else { 0.1 }, "{altitude_m} m: {worst}");
        }
    }

    /// The Sun on the horizon: 16.0′ of radius become an ellipse of about 5 : 6, its upper rim greener than its lower.
    #[test]
    fn the_setting_sun_is_flat_and_green_on_top() {
        let bending = Bending::new(&Preset::named("earth").unwrap().medium, &FOUR, 2.0);
        let radius = (16.0f64 / 60.0).to_radians();
        // Its lower limb touches the horizon.
        let bottom = bending.lowest_rad;
        let top = bending.apparent_rad(bending.true_rad(bottom, 1) + 2.0 * radius);
        let flat = (top - bottom) / (2.0 * radius);
        let rim = |k: usize| arcmin(bending.deviation(top).0 * (bending.ratio[k] - bending.ratio[0])) * 60.0;
        println!("flattened to {flat:.3}; green {:.1}″, violet {:.1}″ above red", rim(1), rim(3));
        assert!((0.78..0.88).contains(&flat), "{flat}");
        assert!(rim(1) > 3.0 && rim(3) > rim(2) && rim(2) > rim(1) && rim(3) < 60.0);
    }

    #[test]
    fn points_are_lifted_to_where_they_are_seen() {
        let earth = Preset::named("earth").unwrap().medium;
        for altitude_m in [2.0, 2600.0, 11e3] {
            let bending = Bending::new(&earth, &FOUR, altitude_m);
            let lift = bending.lift();
            let mut worst: f64 = 0.0;
            for i in 0..2000 {
                let elevation = lift.lowest_rad + 1.7 * (f64::from(i) / 2000.0).powi(3);
                if elevation < FRAC_PI_2 {
                    let error = elevation + lift.deviation(elevation).0 - bending.apparent_rad(elevation);
                    worst = worst.max(arcmin(error).abs() * 60.0);
                }
            }
            println!("{altitude_m} m: {worst:.2}″");
            assert!(worst < 1.0, "{altitude_m} m: {worst}″");
        }
    }

    #[test]
    fn without_refractivity_nothing_moves() {
        let bending = Bending::new(&Preset::named("bruneton2017").unwrap().medium, &FOUR, 0.0);
        assert_eq!(bending, Bending::none());
        for e in [-1.5, -0.1, 0.0, 0.3, 1.57] {
            assert_eq!(bending.deviation(e).0, 0.0);
            assert!((bending.apparent_rad(e) - e).abs() < 1e-12);
        }
        let venus = Bending::new(&Preset::named("venus").unwrap().medium, &FOUR, 0.0);
        assert!(venus.deviation_rad.iter().all(|d| d.is_finite()));
    }
}
