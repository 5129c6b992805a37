//! Bent rays: where light comes from, and what is left of it, when the air's density bends its path.

mod bending;
mod grazing;

pub use bending::{Bending, NODES as BENDING_NODES, traced_deviation_rad};
pub use grazing::{DUST_ALTITUDE_M, Grazing, grazing};

use himmel_core::interpolate::{lerp, locate};
use himmel_core::spectrum::Spectrum;

use crate::error::AirError;
use crate::medium::Medium;

/// Radii of the spherical shells that a path crosses are where the integration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// It left the air.
    Space,
    /// It met the ground.
    Ground,
}

/// What became of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Bent {
    /// By how much the air turned it towards the ground, radians: true minus apparent zenith distance of what it sees.
    pub deviation_rad: f64,
    /// Optical depth along it.
    pub optical_depth: f64,
    /// Angle between the verticals at its ends, radians.
    pub planet_angle_rad: f64,
    /// Lowest altitude on it, m.
    pub lowest_m: f64,
    /// Where it ended.
    pub end: End,
}

/// The air's index, its gradient and its extinction at one wavelength.
struct Path<'a> {
    medium: &'a Medium,
    /// Refractivity and extinction coefficient of each component where its profile is 1.
    coefficients: Vec<(f64, f64)>,
}

impl<'a> Path<'a> {
    fn new(medium: &'a Medium, wavelength_nm: f64) -> Self {
        let at = |spectrum: &Spectrum| spectrum.at(wavelength_nm);
        let coefficients = medium
            .components
            .iter()
            .map(|c| (c.amount * at(&c.refractivity), c.amount * (at(&c.scattering_per_m) + at(&c.absorption_per_m))))
            .collect();
        Self { medium, coefficients }
    }

    /// n − 1 and extinction per metre at an altitude.
    fn at(&self, altitude_m: f64) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        for (component, (bend, dim)) in self.medium.components.iter().zip(&self.coefficients) {
            let density = component.profile.at(altitude_m);
            sum = (sum.0 + density * bend, sum.1 + density * dim);
        }
        sum
    }

    /// d(ln n)/dr, 1/m. Central difference over 2 m: profiles have no finer structure.
    fn gradient_per_m(&self, altitude_m: f64) -> f64 {
        let low = altitude_m.max(1.0);
        ((self.at(low + 1.0).0).ln_1p() - (self.at(low - 1.0).0).ln_1p()) / 2.0
    }

    /// Derivatives of (r − R, cosine of zenith angle, angle at the planet's centre, turn, depth) along the path:
    /// dr/ds = µ, dµ/ds = (1 − µ²)(1/r + d ln n/dr), dφ/ds = √(1 − µ²)/r, turn′ = −√(1 − µ²) d ln n/dr.
    fn derivatives(&self, y: [f64; 5]) -> [f64; 5] {
        let r = self.medium.bottom_radius_m + y[0];
        let mu = y[1].clamp(-1.0, 1.0);
        let sin = (1.0 - mu * mu).sqrt();
        let altitude_m = y[0].max(0.0);
        let gradient = self.gradient_per_m(altitude_m);
        [mu, sin * sin * (1.0 / r + gradient), sin / r, -sin * gradient, self.at(altitude_m).1]
    }
}

/// Follows a ray through the air's refractivity to space or to the ground.
///
/// Fourth-order Runge–Kutta along the path, in steps of at most 250 m in dense air and 16 times that where it is thin.
///
/// `altitude_m`: start, within the air or above it. `elevation_rad`: apparent elevation there.
/// Laws tested: without refractivity nothing turns; Bennett's table; n r sin z is the same at both ends.
pub fn trace(medium: &Medium, wavelength_nm: f64, altitude_m: f64, elevation_rad: f64) -> Result<Bent, AirError> {
    let wrong = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
    if !(0.0..=1e9).contains(&altitude_m) {
        return wrong("altitude of a ray", "lie in 0..=1e9 m", altitude_m);
    }
    if !(-std::f64::consts::FRAC_PI_2..=std::f64::consts::FRAC_PI_2).contains(&elevation_rad) {
        return wrong("elevation of a ray", "lie in -π/2..=π/2", elevation_rad);
    }
    if !(1.0..=1e6).contains(&wavelength_nm) {
        return wrong("wavelength", "lie in 1..=1e6 nm", wavelength_nm);
    }
    let path = Path::new(medium, wavelength_nm);
    let top_m = medium.top_altitude_m;
    let radius_m = medium.bottom_radius_m;
    let mut y = [altitude_m, elevation_rad.sin(), 0.0, 0.0, 0.0];
    let mut lowest_m = altitude_m;
    if altitude_m > top_m {
        let impact = (radius_m + altitude_m) * elevation_rad.cos();
        if elevation_rad >= 0.0 || impact >= radius_m + top_m {
            let lowest_m = if elevation_rad < 0.0 { impact - radius_m } else { altitude_m };
            return Ok(Bent {
                deviation_rad: 0.0,
                optical_depth: 0.0,
                planet_angle_rad: 0.0,
                lowest_m,
                end: End::Space,
            });
        }
        let mu = -(1.0 - (impact / (radius_m + top_m)).powi(2)).sqrt();
        y = [top_m, mu, (-mu).asin() - (-y[1]).asin(), 0.0, 0.0];
        y[2] = -y[2];
    }
    // Short where the air is dense, long where it is thin.
    let shortest = (top_m / 400.0).min(250.0);
    for _ in 0..200_000 {
        let step = shortest * (1.0 + (y[0].max(0.0) / 10e3).powi(2)).min(16.0);
        let add = |y: [f64; 5], k: [f64; 5], h: f64| -> [f64; 5] { std::array::from_fn(|i| y[i] + h * k[i]) };
        let k1 = path.derivatives(y);
        let k2 = path.derivatives(add(y, k1, 0.5 * step));
        let k3 = path.derivatives(add(y, k2, 0.5 * step));
        let k4 = path.derivatives(add(y, k3, step));
        let next: [f64; 5] = std::array::from_fn(|i| y[i] + step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        lowest_m = lowest_m.min(next[0]);
        let end = if next[0] < 0.0 {
            Some((End::Ground, y[0] / (y[0] - next[0])))
        } else if next[0] > top_m {
            Some((End::Space, (top_m - y[0]) / (next[0] - y[0])))
        } else {
            None
        };
        if let Some((end, share)) = end {
            let last: [f64; 5] = std::array::from_fn(|i| lerp(y[i], next[i], share.clamp(0.0, 1.0)));
            return Ok(Bent {
                deviation_rad: last[3],
                optical_depth: last[4],
                planet_angle_rad: last[2],
                lowest_m: lowest_m.max(0.0),
                end,
            });
        }
        y = next;
    }
    // A ray caught in a duct circles until its light is spent.
    Ok(Bent { deviation_rad: y[3], optical_depth: f64::INFINITY, planet_angle_rad: y[2], lowest_m, end: End::Ground })
}

/// Deviation and transmittance over altitude and apparent elevation, at several wavelengths.
#[derive(Clone, Debug)]
pub struct RefractionTable {
    altitudes_m: Vec<f64>,
    elevations_rad: Vec<f64>,
    wavelengths_nm: Vec<f64>,
    /// (deviation in radians, transmittance) for each wavelength, altitude, elevation.
    values: Vec<(f64, f64)>,
}

impl RefractionTable {
    /// Follows a ray for each node. Altitudes from 0 to the air's top, crowded near the ground; elevations from
    /// −6° to 90°, crowded at the horizon.
    pub fn new(medium: &Medium, wavelengths_nm: &[f64], altitudes: usize, elevations: usize) -> Result<Self, AirError> {
        let (altitudes, elevations) = (altitudes.clamp(2, 512), elevations.clamp(8, 4096));
        let unit = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let altitudes_m: Vec<f64> =
            (0..altitudes).map(|i| medium.top_altitude_m * unit(i, altitudes).powi(2)).collect();
        let w = 2f64.to_radians();
        let (a, b) = ((-6f64.to_radians() / w).asinh(), (90f64.to_radians() / w).asinh());
        let elevations_rad: Vec<f64> = (0..elevations).map(|i| w * lerp(a, b, unit(i, elevations)).sinh()).collect();
        let mut values = Vec::with_capacity(wavelengths_nm.len() * altitudes * elevations);
        for &wavelength_nm in wavelengths_nm {
            for &altitude_m in &altitudes_m {
                for &elevation_rad in &elevations_rad {
                    let elevation_rad = elevation_rad.min(std::f64::consts::FRAC_PI_2);
                    let bent = trace(medium, wavelength_nm, altitude_m, elevation_rad)?;
                    let through = if bent.end == End::Space { (-bent.optical_depth).exp() } else { 0.0 };
                    values.push((bent.deviation_rad, through));
                }
            }
        }
        Ok(Self { altitudes_m, elevations_rad, wavelengths_nm: wavelengths_nm.to_vec(), values })
    }

    /// The wavelengths, nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// Deviation (radians) and transmittance at the wavelength with this index, between nodes bilinearly; 0 and 0 for
    /// an index that the table lacks.
    pub fn at(&self, wavelength: usize, altitude_m: f64, elevation_rad: f64) -> (f64, f64) {
        if wavelength >= self.wavelengths_nm.len() {
            return (0.0, 0.0);
        }
        let ((i, s), (j, t)) = (locate(&self.altitudes_m, altitude_m), locate(&self.elevations_rad, elevation_rad));
        let node =
            |i: usize, j: usize| self.values[(wavelength * self.altitudes_m.len() + i) * self.elevations_rad.len() + j];
        let row = |i: usize| {
            let (a, b) = (node(i, j), node(i, j + 1));
            (lerp(a.0, b.0, t), lerp(a.1, b.1, t))
        };
        let (a, b) = (row(i), row(i + 1));
        (lerp(a.0, b.0, s), lerp(a.1, b.1, s))
    }
}

/// Refraction of what is seen at an apparent altitude: Bennett's 1′/tan(h + 7.31/(h + 4.4)), h in degrees, at
/// 1010 hPa and 10 °C [bennett1982]. Answers in arcminutes.
pub fn bennett_arcmin(apparent_altitude_deg: f64) -> f64 {
    1.0 / (apparent_altitude_deg + 7.31 / (apparent_altitude_deg + 4.4)).to_radians().tan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    fn arcmin(radians: f64) -> f64 {
        radians.to_degrees() * 60.0
    }

    /// Air as Bennett's: 1010 hPa and 10 °C at the ground, 6.5 K less with every kilometre up to 11 km, isothermal above
    /// [ussa1976]. Density falls as (T/T₀)^4.2559, then with kT/(mg) = 6.34 km at 216.65 K (6.19 km at 211.65 K).
    fn bennetts_air() -> Medium {
        let mut medium = Preset::named("earth").unwrap().medium;
        let altitude_m: Vec<f64> = (0..=400).map(|i| 250.0 * f64::from(i)).collect();
        let density = |h: f64| {
            let low = (1.0 - 0.0065 * h.min(11e3) / 283.15).powf(4.2559);
            low * (-(h - 11e3).max(0.0) / crate::rayleigh::scale_height_m(211.65, 28.9644, 9.80665)).exp()
        };
        let amount = crate::rayleigh::number_density_per_m3(101_000.0, 283.15) / 2.5469e25;
        medium.components.truncate(1);
        medium.components[0].amount = amount;
        medium.components[0].profile =
            crate::Profile::LogTable { value: altitude_m.iter().map(|&h| density(h)).collect(), altitude_m };
        medium.top_altitude_m = 100e3;
        medium
    }

    /// 34.5′ at the horizon, 9.9′ at 5°, 5.4′ at 10° [bennett1982]. 0.1′ from 5° up, where his formula itself is good
    /// to 0.07′; 0.8′ at the horizon, where the lowest hundred metres decide (0.65′ measured).
    #[test]
    fn rays_bend_as_bennett_says() {
        let (medium, earth) = (bennetts_air(), Preset::named("earth").unwrap().medium);
        for degrees in [0.0f64, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0] {
            let ours = arcmin(trace(&medium, 575.0, 0.0, degrees.to_radians()).unwrap().deviation_rad);
            let preset = arcmin(trace(&earth, 575.0, 0.0, degrees.to_radians()).unwrap().deviation_rad);
            let bennett = bennett_arcmin(degrees);
            println!("{degrees}°: {ours:.2}′ in Bennett's air, {preset:.2}′ in `earth`, Bennett {bennett:.2}′");
            assert!((ours - bennett).abs() < if degrees < 5.0 { 0.8 } else { 0.1 }, "{degrees}: {ours} {bennett}");
            // `earth` has one temperature at every height and 15 °C at the ground.
            assert!((preset / bennett - 1.0).abs() < 0.06, "{degrees}: {preset} {bennett}");
        }
        assert!((bennett_arcmin(0.0) - 34.5).abs() < 0.05 && (bennett_arcmin(5.0) - 9.9).abs() < 0.05);
    }

    /// Bouguer: n r sin z is the same at both ends, whatever lies between. 0.1″, the linear last step.
    #[test]
    fn bouguers_invariant_holds() {
        let medium = Preset::named("earth").unwrap().medium;
        for degrees in [0.0f64, 1.0, 10.0, 45.0] {
            let bent = trace(&medium, 550.0, 0.0, degrees.to_radians()).unwrap();
            let zenith = std::f64::consts::FRAC_PI_2 - degrees.to_radians();
            let n = 1.0 + medium.components[0].refractivity.at(550.0);
            let expected =
                (n * medium.bottom_radius_m * zenith.sin() / (medium.bottom_radius_m + medium.top_altitude_m)).asin();
            let found = zenith + bent.deviation_rad - bent.planet_angle_rad;
            let arcsec = (found - expected).to_degrees() * 3600.0;
            println!("{degrees}°: {arcsec:.4}″");
            assert!(arcsec.abs() < 0.1, "{degrees}: {arcsec}″");
        }
    }

    #[test]
    fn without_refractivity_rays_are_straight() {
        let preset = Preset::named("bruneton2017").unwrap();
        let columns = crate::Columns::new(&preset.medium);
        let air = preset.medium.sampled(&[550.0]);
        for degrees in [90.0f64, 30.0, 3.0, 0.5] {
            let bent = trace(&preset.medium, 550.0, 0.0, degrees.to_radians()).unwrap();
            assert_eq!(bent.deviation_rad, 0.0);
            let table = columns.optical_depth(&air, 0.0, degrees.to_radians().sin())[0];
            assert!((bent.optical_depth / table - 1.0).abs() < 5e-3, "{degrees}: {} {table}", bent.optical_depth);
        }
        assert_eq!(trace(&preset.medium, 550.0, 1000.0, -0.5).unwrap().end, End::Ground);
    }

    /// Blue turns more than red; a ray from space that passes 20 km above the ground leaves again.
    #[test]
    fn blue_bends_more() {
        let earth = Preset::named("earth").unwrap();
        let turn = |nm| trace(&earth.medium, nm, 0.0, 0.0).unwrap().deviation_rad;
        assert!(turn(430.0) > turn(550.0) && turn(550.0) > turn(680.0));
        let from_space = trace(&earth.medium, 550.0, 1e6, -(6391f64 / 7371.0).acos()).unwrap();
        assert!(from_space.end == End::Space && from_space.lowest_m < 100e3);
    }

    #[test]
    fn the_table_repeats_its_rays() {
        let earth = Preset::named("earth").unwrap();
        let table = RefractionTable::new(&earth.medium, &[550.0], 24, 64).unwrap();
        for (altitude_m, degrees) in [(0.0, 5.0), (500.0, 1.0), (3000.0, 20.0)] {
            let bent = trace(&earth.medium, 550.0, altitude_m, f64::to_radians(degrees)).unwrap();
            let (deviation, through) = table.at(0, altitude_m, f64::to_radians(degrees));
            assert!((deviation / bent.deviation_rad - 1.0).abs() < 0.05, "{altitude_m} {degrees}");
            assert!((through - (-bent.optical_depth).exp()).abs() < 0.02);
        }
        assert_eq!(table.at(3, 0.0, 0.0), (0.0, 0.0));
        assert!(trace(&earth.medium, 550.0, -1.0, 0.0).is_err() && trace(&earth.medium, 550.0, 0.0, f64::NAN).is_err());
    }
}
