//! A star's disc as the air shows it: limb-darkened, flattened, behind an occluder, with its corona. Twin of `disc.wgsl`.
//!
//! Refraction moves every point of the sky up by its own amount ([`Bending`]). So the disc stays a circle around its
//! airless place, and it is the line of sight that is turned down before the chord to the centre is measured, once for
//! each wavelength: flattening and the green rim follow. Radiance does not change by refraction (n² at the eye, 6e-4, is
//! left out), so a flattened disc gives less light.
//!
//! **Known to look wrong**: mirages, inversions and the green flash need layers that no preset has. The occluder is a
//! smooth black circle.

use glam::DVec3;

use crate::eclipse::corona_brightness;
use crate::refraction::Bending;
use crate::sun::relative_disc_brightness;

/// A star's disc for one observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Unit vector to its centre, without refraction.
    pub centre: DVec3,
    /// Apparent radius, rad.
    pub radius_rad: f64,
    /// Unit vector to the zenith.
    pub up: DVec3,
    /// Unit vector to the centre of the occluder, without refraction, and its apparent radius, rad.
    pub occluder: Option<(DVec3, f64)>,
    /// Whether the corona is drawn.
    pub corona: bool,
}

impl Disc {
    /// Radiance of disc and corona in an apparent direction (unit vector) per unit irradiance of the star, sr⁻¹.
    ///
    /// |x − t δ(e) κ_λ| < ρ,   x = direction − centre
    ///
    /// t: unit tangent upward.  δ, κ: deviation and its share by wavelength.  e: apparent elevation.
    /// Laws tested: without bending the circle of [`relative_disc_brightness`]; flattened at the horizon; black behind
    /// the occluder; parity with WGSL.
    pub fn radiance_per_sr(&self, direction: DVec3, bending: &Bending, limb: &[[f64; 6]; 4]) -> [f64; 4] {
        let height = direction.dot(self.up).clamp(-1.0, 1.0);
        let tangent = (self.up - direction * height).normalize_or_zero();
        let deviation = bending.deviation(height.asin()).0;
        let solid_angle = std::f64::consts::TAU * (1.0 - self.radius_rad.cos());
        std::array::from_fn(|k| {
            let down = tangent * (deviation * bending.ratio[k]);
            let angle_to = |centre: DVec3| {
                let chord = (direction - centre - down).length();
                chord * (1.0 + chord * chord / 24.0)
            };
            if self.occluder.is_some_and(|(centre, radius_rad)| angle_to(centre) < radius_rad) {
                return 0.0;
            }
            let rho = angle_to(self.centre) / self.radius_rad;
            let corona = if self.corona { corona_brightness(rho) } else { 0.0 };
            (relative_disc_brightness(rho, &limb[k]) + corona) / solid_angle
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use crate::sun::limb_darkening;

    const FOUR: [f64; 4] = [630.0, 560.0, 490.0, 430.0];
    const RADIUS: f64 = 0.004_65;

    fn at(azimuth: f64, elevation: f64) -> DVec3 {
        DVec3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin())
    }

    fn disc(elevation: f64) -> Disc {
        Disc { centre: at(0.0, elevation), radius_rad: RADIUS, up: DVec3::Z, occluder: None, corona: false }
    }

    /// Flux of a patch of sky around an apparent elevation, per unit irradiance.
    fn flux(disc: &Disc, bending: &Bending, elevation: f64) -> [f64; 4] {
        let limb = FOUR.map(limb_darkening);
        let (n, reach) = (400, 3.0 * RADIUS);
        let mut sum = [0.0; 4];
        for i in 0..n * n {
            let (x, y) = ((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n));
            let (a, e) = ((2.0 * x - 1.0) * reach, elevation + (2.0 * y - 1.0) * reach);
            let light = disc.radiance_per_sr(at(a / elevation.cos(), e), bending, &limb);
            for k in 0..4 {
                sum[k] += light[k] * (2.0 * reach / f64::from(n)).powi(2) * e.cos() / elevation.cos();
            }
        }
        sum
    }

    #[test]
    fn unbent_it_gives_its_irradiance() {
        let all = flux(&disc(0.5), &Bending::none(), 0.5);
        assert!(all.iter().all(|f| (f - 1.0).abs() < 2e-3), "{all:?}");
    }

    /// Refraction squeezes the disc and keeps its radiance: its light falls by the flattening, 0.81 on the horizon.
    #[test]
    fn a_setting_disc_is_squeezed() {
        let bending = Bending::new(&Preset::named("earth").unwrap().medium, &FOUR, 2.0);
        let apparent = bending.lowest_rad + RADIUS;
        let low = flux(&disc(bending.true_rad(apparent, 1)), &bending, apparent);
        assert!((0.77..0.9).contains(&low[1]), "{low:?}");
        let high = flux(&disc(bending.true_rad(0.7, 1)), &bending, 0.7);
        assert!((high[1] - 1.0).abs() < 4e-3, "{high:?}");
    }

    /// The Moon on the disc takes what `visible_part` says; in totality only the corona is left, a millionth.
    #[test]
    fn the_occluder_takes_its_part() {
        let moon = 1.03 * RADIUS;
        let limb = FOUR.map(limb_darkening);
        for d in [0.5, 1.0, 1.7] {
            let covered = Disc { occluder: Some((at(0.0, 0.5 + d * RADIUS), moon)), ..disc(0.5) };
            let (seen, law) = (flux(&covered, &Bending::none(), 0.5), crate::eclipse::visible_part(d, 1.03, &limb));
            assert!((0..4).all(|k| (seen[k] - law[k]).abs() < 4e-3), "{d}: {seen:?} {law:?}");
        }
        let total = Disc { occluder: Some((at(0.0, 0.5), moon)), corona: true, ..disc(0.5) };
        let left = flux(&total, &Bending::none(), 0.5)[1];
        assert!((0.4e-6..1.2e-6).contains(&left), "{left:e}");
    }
}
