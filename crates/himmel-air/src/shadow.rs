//! Sunlight bent into the planet's shadow: what colours an eclipsed moon.
//!
//! A point of the Moon sees the Sun's disc behind the planet, and through each ring of air around it another piece of that
//! disc, lifted by the air and dimmed by it. [`Rays`] are the rings, made once for an atmosphere; [`ShadowLight`] is the
//! light over the distance from the shadow's axis, for the distances of a night.
//!
//! **What it leaves out**: the planet's flattening, weather (but for the tops of clouds and dust, both the same all
//! around), airglow, and light that the air scatters into the shadow, which [garciamunoz2011] treats.

use std::f64::consts::PI;

use himmel_core::quadrature::gauss_legendre_unit;

use crate::eclipse::visible_part;
use crate::error::AirError;
use crate::medium::Medium;
use crate::refraction::{Grazing, grazing};

/// Rays past the planet.
const RAYS: usize = 1920;
/// Nodes over the azimuths of a ring that see the Sun.
const AZIMUTHS: usize = 12;
/// Nodes of [`ShadowLight`] over the distance from the axis.
pub const NODES: usize = 384;
/// Less light than this is none: e⁻⁴⁶ keeps logarithms finite.
const LEAST: f64 = 1e-20;

/// Rays that graze the air, at the four wavelengths.
#[derive(Clone, Debug)]
pub struct Rays {
    by_wavelength: [Vec<Grazing>; 4],
    top_radius_m: f64,
}

/// What stands in the air besides what the medium says, all around the planet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Veil {
    /// Share of the planet's rim that has clouds, 0..=1.
    pub cloud_cover: f64,
    /// Where there are, rays that come lower than this meet one, m.
    pub cloud_top_m: f64,
    /// Vertical optical depth of volcanic dust at 20 km, the same at all wavelengths.
    pub dust: f64,
}

/// Where everything is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// From the planet's centre to the plane of the moon, m.
    pub moon_m: f64,
    /// From the star to the planet, m.
    pub star_m: f64,
    /// Radius of the star, m.
    pub star_radius_m: f64,
}

impl Rays {
    /// Follows them: some tens of milliseconds.
    pub fn new(medium: &Medium, wavelengths_nm: &[f64; 4]) -> Self {
        // Crowded towards the ground, where rays bend most.
        let lowest: Vec<f64> = (0..=RAYS).map(|i| medium.top_altitude_m * (i as f64 / RAYS as f64).powf(1.5)).collect();
        Self {
            by_wavelength: wavelengths_nm.map(|nm| grazing(medium, nm, &lowest)),
            top_radius_m: medium.bottom_radius_m + medium.top_altitude_m,
        }
    }
}

/// Light of a star behind a planet, over the distance from the shadow's axis, relative to the light without it, at four
/// wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowLight {
    /// Natural logarithms at evenly spaced distances from 0 to the penumbra's edge.
    pub ln_light: Vec<[f64; 4]>,
    /// Distance between nodes, m.
    pub step_m: f64,
}

/// A ring of one wavelength as it is thrown onto the plane of the moon.
struct Ring {
    /// Radius of the circle of points to which the star's centre is thrown, m.
    arrives_m: f64,
    /// Transmittance times the ring's area over that of the star, per radian of azimuth.
    weight: f64,
}

impl ShadowLight {
    /// Sums the rings: a point at x from the axis sees through the ring of impact b, at azimuth ψ, the star's point that
    /// lies |x − a (cos ψ, sin ψ)| from its centre, where
    ///
    /// a = b (1 + D_m/D_s) − D_m δ(b),   light = Σ ∫ T(b) B(|x − a e(ψ)| / s) b db dψ (1 + D_m/D_s)² / (π s²)   [link1969]
    ///
    /// s = R_s D_m/D_s: the star's radius as thrown through a point of the ring. B: its limb-darkened brightness, mean 1.
    /// Radiance is kept along rays, so that the ring's own area counts, not where it falls: no caustic needs care.
    /// What passes above the air is [`visible_part`] in closed form.
    ///
    /// `limb`: the star's limb darkening at the four wavelengths.
    /// Laws tested: without refraction it is the geometric penumbra, and black within the umbra; full outside; red
    /// reaches further in than blue; ozone makes the rim blue.
    pub fn new(rays: &Rays, veil: &Veil, distances: &Distances, limb: &[[f64; 6]; 4]) -> Result<Self, AirError> {
        let wrong = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
        let Distances { moon_m, star_m, star_radius_m } = *distances;
        if !(moon_m > 1.5 * rays.top_radius_m && moon_m <= 1e13) {
            return wrong("distance of the moon", "lie beyond 1.5 radii of the planet, up to 1e13 m", moon_m);
        }
        if !(star_radius_m > 0.0 && star_m > 2.0 * star_radius_m && star_m <= 1e20) {
            return wrong("distance of the star", "lie beyond its diameter, up to 1e20 m", star_m);
        }
        let ratio = moon_m / star_m;
        let star = star_radius_m * ratio;
        let rings: [Vec<Ring>; 4] = std::array::from_fn(|k| {
            let pairs = rays.by_wavelength[k].windows(2);
            let ring = |pair: &[Grazing]| {
                let mean = |of: fn(&Grazing) -> f64| 0.5 * (of(&pair[0]) + of(&pair[1]));
                let depth = mean(|ray| ray.optical_depth) + veil.dust * mean(|ray| ray.dust_air_mass);
                let impact = mean(|ray| ray.impact_m);
                let clear = if mean(|ray| ray.lowest_m) < veil.cloud_top_m { 1.0 - veil.cloud_cover } else { 1.0 };
                let area = impact * (pair[1].impact_m - pair[0].impact_m) * (1.0 + ratio).powi(2);
                Ring {
                    arrives_m: impact * (1.0 + ratio) - moon_m * mean(|ray| ray.deviation_rad).tan(),
                    weight: clear * (-depth).exp() * area / (PI * star * star),
                }
            };
            pairs.map(ring).filter(|ring| ring.weight > LEAST).collect()
        });
        let top = rays.top_radius_m * (1.0 + ratio);
        let step_m = (top + star) / (NODES - 1) as f64;
        let rule = gauss_legendre_unit(AZIMUTHS);
        let node = |i: usize| {
            let x = step_m * i as f64;
            let past = visible_part(x / star, top / star, limb);
            std::array::from_fn(|k| {
                let rings: f64 = rings[k].iter().map(|ring| ring.light(x, star, &limb[k], &rule)).sum();
                (past[k] + rings).clamp(LEAST, 2.0).ln()
            })
        };
        Ok(Self { ln_light: (0..NODES).map(node).collect(), step_m })
    }

    /// At a distance from the axis.
    pub fn at(&self, axis_distance_m: f64) -> [f64; 4] {
        let x = axis_distance_m.abs() / self.step_m;
        let i = x as usize;
        let (Some(a), Some(b)) = (self.ln_light.get(i), self.ln_light.get(i + 1)) else { return [1.0; 4] };
        let t = x - i as f64;
        std::array::from_fn(|k| (a[k] + t * (b[k] - a[k])).exp())
    }

    /// Where the umbra ends to the eye: the distance at which light changes by the largest factor per metre, m. `weights`:
    /// of the four wavelengths in luminance.
    pub fn umbra_edge_m(&self, weights: [f64; 4]) -> f64 {
        let ln = |i: usize| {
            let light: f64 = (0..4).map(|k| weights[k] * self.ln_light[i][k].exp()).sum();
            light.max(LEAST).ln()
        };
        let slope: Vec<f64> = (1..self.ln_light.len()).map(|i| ln(i) - ln(i - 1)).collect();
        // The axis' own spot is steep, too; the edge lies beyond half of the way to the penumbra's.
        let from = slope.len() / 3;
        let steepest = (from..slope.len()).max_by(|&a, &b| slope[a].total_cmp(&slope[b])).unwrap_or(from);
        // The top of the parabola through it and its neighbours.
        let at = |i: usize| slope.get(i).copied().unwrap_or(0.0);
        let (a, b, c) = (at(steepest - 1), at(steepest), at(steepest + 1));
        let bend = a - 2.0 * b + c;
        let shift = if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        self.step_m * (steepest as f64 + 0.5 + shift)
    }

    /// Distance from the axis at which the penumbra ends, m.
    pub fn penumbra_edge_m(&self) -> f64 {
        self.step_m * (self.ln_light.len() - 1) as f64
    }
}

impl Ring {
    /// Its light at x from the axis. `star`: the thrown radius.
    fn light(&self, x: f64, star: f64, limb: &[f64; 6], rule: &[(f64, f64)]) -> f64 {
        let r = self.arrives_m.abs();
        if (x - r).abs() >= star {
            return 0.0;
        }
        // Azimuths that see the star: |ψ| up to where the distance is its radius.
        let most =
            if x + r <= star { PI } else { ((x * x + r * r - star * star) / (2.0 * x * r)).clamp(-1.0, 1.0).acos() };
        let mut sum = 0.0;
        for &(u, w) in rule {
            // Nodes crowd at the limb, where the brightness has a root.
            let psi = most * u * (2.0 - u);
            let square = (x * x + r * r - 2.0 * x * r * psi.cos()) / (star * star);
            let mu = (1.0 - square).max(0.0).sqrt();
            sum += w * 2.0 * (1.0 - u) * limb.iter().rev().fold(0.0, |sum, c| sum * mu + c);
        }
        2.0 * most * sum * self.weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use crate::sun::limb_darkening;

    const FOUR: [f64; 4] = [630.0, 560.0, 490.0, 430.0];
    const MEAN: Distances = Distances { moon_m: 384.4e6, star_m: 1.495_978_707e11, star_radius_m: 695.7e6 };
    /// Roughly the luminance of the four.
    const LUMINANCE: [f64; 4] = [0.35, 0.5, 0.13, 0.02];

    fn limb() -> [[f64; 6]; 4] {
        FOUR.map(limb_darkening)
    }

    fn magnitude(light: [f64; 4]) -> f64 {
        -2.5 * (0..4).map(|k| LUMINANCE[k] * light[k]).sum::<f64>().log10()
    }

    #[test]
    fn the_umbra_is_red_inside_and_turquoise_at_its_rim() {
        let earth = Preset::named("earth").unwrap();
        let start = std::time::Instant::now();
        let rays = Rays::new(&earth.medium, &FOUR);
        let rays_took = start.elapsed();
        let light = ShadowLight::new(&rays, &Veil::default(), &MEAN, &limb()).unwrap();
        println!("rays {rays_took:?}, all {:?}", start.elapsed());
        for km in [0.0, 1000.0, 2000.0, 3000.0] {
            let l = light.at(km * 1e3);
            println!("{km} km: {:.2e} {:.2e} {:.2e} {:.2e}, {:.2} mag", l[0], l[1], l[2], l[3], magnitude(l));
            assert!(l[0] > l[1] && l[1] > l[2] && l[2] > l[3]);
        }
        // 10 to 13 magnitudes for clean air; brighter outwards, full outside.
        assert!((10.0..13.0).contains(&magnitude(light.at(1e6))) && (12.0..13.0).contains(&magnitude(light.at(0.0))));
        let of_node: Vec<f64> = (0..=160).map(|i| magnitude(light.at(f64::from(i) * 50e3))).collect();
        assert!(of_node.windows(2).all(|pair| pair[0] > pair[1]));
        assert!(light.at(9e6) == [1.0; 4] && light.at(8.28e6).iter().all(|l| *l > 0.9999));
        let danjon = MEAN.moon_m
            * (1.01 * (6378.1366e3f64 / MEAN.moon_m).asin() + (6378.1366e3f64 / MEAN.star_m).asin()
                - (695.7e6f64 / MEAN.star_m).asin())
            .tan();
        let edge = light.umbra_edge_m(LUMINANCE);
        println!(
            "edge {:.1} km, Danjon {:.1} km, penumbra {:.1} km",
            edge / 1e3,
            danjon / 1e3,
            light.penumbra_edge_m() / 1e3
        );
        // 2 % of the Moon's radius. The edge is where rays are thinned out rather than dimmed: 50 km up.
        assert!((edge - danjon).abs() < 0.02 * 1737.4e3, "{edge} {danjon}");
        let veiled = |veil: Veil| ShadowLight::new(&rays, &veil, &MEAN, &limb()).unwrap();
        let clouds = veiled(Veil { cloud_cover: 0.7, cloud_top_m: 10e3, dust: 0.0 });
        let dust = veiled(Veil { dust: 0.1, ..Veil::default() });
        for (name, veiled) in [("clouds", &clouds), ("dust", &dust)] {
            let darker = magnitude(veiled.at(2e6)) - magnitude(light.at(2e6));
            println!(
                "{name}: {darker:.2} mag darker 2000 km from the axis, edge {:.1} km",
                veiled.umbra_edge_m(LUMINANCE) / 1e3
            );
            assert!((0.5..8.0).contains(&darker));
        }
    }

    /// Without refraction: the penumbra of a disc behind a disc, and nothing in the umbra.
    #[test]
    fn without_refraction_the_umbra_is_black() {
        let preset = Preset::named("bruneton2017").unwrap();
        let light = ShadowLight::new(&Rays::new(&preset.medium, &FOUR), &Veil::default(), &MEAN, &limb()).unwrap();
        assert!(light.at(0.0)[0] < 1e-19 && light.at(4.4e6)[0] < 1e-19);
        let half = light.at(6.4e6)[1];
        assert!((0.3..0.7).contains(&half), "{half}");
        let bad = Distances { moon_m: 1.0, ..MEAN };
        assert!(ShadowLight::new(&Rays::new(&preset.medium, &FOUR), &Veil::default(), &bad, &limb()).is_err());
    }

    /// Colour by the full spectrum relative to sunlight: red on the axis; towards the rim ozone takes yellow and orange.
    #[test]
    fn colours_of_the_full_spectrum() {
        use himmel_core::colour::{Observer, rec709_from_xyz};
        let earth = Preset::named("earth").unwrap();
        let groups: Vec<[f64; 4]> = (0..9).map(|i| [0, 1, 2, 3].map(|k| 390.0 + f64::from(4 * i + k) * 10.0)).collect();
        let lights: Vec<ShadowLight> = groups
            .iter()
            .map(|nm| {
                ShadowLight::new(&Rays::new(&earth.medium, nm), &Veil::default(), &MEAN, &nm.map(limb_darkening))
                    .unwrap()
            })
            .collect();
        let sun = crate::sun::irradiance_w_m2_nm();
        let rgb = |x_m: f64| {
            let at: Vec<f64> = lights.iter().flat_map(|light| light.at(x_m)).collect();
            let spectrum = |nm: f64| {
                let x = ((nm - 390.0) / 10.0).clamp(0.0, 34.999);
                let i = x as usize;
                (at[i] + (x - i as f64) * (at[i + 1] - at[i])) * sun.at(nm)
            };
            rec709_from_xyz() * Observer::cie1931().xyz_of(spectrum)
        };
        let white = rgb(9e6);
        let ratios = |radii: f64| {
            let c = rgb(radii * 1737.4e3) / white;
            (c.y / c.x, c.z / c.x)
        };
        let (axis, inside, rim, outside) = (ratios(0.0), ratios(2.3), ratios(2.66), ratios(2.72));
        println!("green and blue over red: axis {axis:.3?}, 2.30 {inside:.3?}, rim {rim:.3?}, 2.72 {outside:.3?}");
        assert!(axis.0 < 0.1 && axis.1 < 0.02 && inside.1 < 0.4);
        // The rim is greener and bluer than what is inside and outside: turquoise beside them, though not beside the Sun.
        assert!(rim.0 > inside.0 && rim.1 > inside.1 && rim.0 > outside.0 + 0.01 && rim.1 > outside.1 + 0.04);
    }
}
