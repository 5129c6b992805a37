//! What lights the air: parallel beams or discs, any number of them.

use std::f64::consts::PI;

use glam::DVec3;
use himmel_core::quadrature::gauss_legendre_unit;

use super::lobe::around;
use super::random::Random;
use crate::error::AirError;
use crate::sun::relative_disc_brightness;

/// A light above the air.
#[derive(Clone, Debug, PartialEq)]
pub struct Source<const N: usize> {
    /// Unit vector towards it, in the observer's frame: z is the zenith.
    pub direction: DVec3,
    /// Radius of its disc, rad; 0 is a parallel beam.
    pub radius_rad: f64,
    /// Its spectral irradiance on a surface that faces it, above the air. Answers have its unit per sr; 1 gives sr⁻¹.
    pub irradiance: [f64; N],
    /// Limb darkening as [`crate::sun::limb_darkening`] gives it, for each wavelength; `None`: an even disc.
    pub limb: Option<[[f64; 6]; N]>,
}

impl<const N: usize> Source<N> {
    /// A parallel beam of unit irradiance.
    pub fn beam(direction: DVec3) -> Self {
        Self { direction, radius_rad: 0.0, irradiance: [1.0; N], limb: None }
    }

    /// A parallel beam of unit irradiance at a zenith angle, in the plane of x and z.
    pub fn at_zenith_angle(zenith_rad: f64) -> Self {
        Self::beam(DVec3::new(zenith_rad.sin(), 0.0, zenith_rad.cos()))
    }

    pub(super) fn check(&self) -> Result<(), AirError> {
        let error = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
        let length = self.direction.length();
        if length.is_nan() || (length - 1.0).abs() > 1e-6 {
            return error("direction of a light", "be a unit vector", length);
        }
        // A quarter of the sky: beyond, a disc has no centre to aim at.
        if !(0.0..=PI / 4.0).contains(&self.radius_rad) {
            return error("radius of a light", "lie in 0..=0.785 rad", self.radius_rad);
        }
        for irradiance in self.irradiance {
            if !(0.0..=1e30).contains(&irradiance) {
                return error("irradiance of a light", "be finite and not negative", irradiance);
            }
        }
        Ok(())
    }

    /// Brightness relative to the disc's mean at a share of its radius.
    fn brightness(&self, fraction: f64) -> [f64; N] {
        match &self.limb {
            Some(limb) => limb.map(|coefficients| relative_disc_brightness(fraction, &coefficients)),
            None => [1.0; N],
        }
    }

    /// Directions and weights (which sum to 1) that stand for the disc: three rings of eight.
    pub(super) fn points(&self) -> Vec<(DVec3, [f64; N])> {
        if self.radius_rad == 0.0 {
            return vec![(self.direction, [1.0; N])];
        }
        let (x, y) = self.direction.any_orthonormal_pair();
        let mut points = Vec::new();
        let mut sum = [0.0; N];
        for (ring, (area, w)) in gauss_legendre_unit(3).into_iter().enumerate() {
            // Nodes in the square of the radius: equal shares of the disc.
            let fraction = area.sqrt();
            let brightness = self.brightness(fraction).map(|b| b * w / 8.0);
            for j in 0..8 {
                let (sin_phi, cos_phi) = (PI / 4.0 * (f64::from(j) + 0.5 * ring as f64)).sin_cos();
                let (sin, cos) = (fraction * self.radius_rad).sin_cos();
                points.push((self.direction * cos + (x * cos_phi + y * sin_phi) * sin, brightness));
            }
            for k in 0..N {
                sum[k] += 8.0 * brightness[k];
            }
        }
        for (_, weight) in &mut points {
            for k in 0..N {
                weight[k] /= sum[k];
            }
        }
        points
    }

    /// A direction within the disc and its weight: the brightness there relative to the mean.
    pub(super) fn sample(&self, random: &mut Random) -> (DVec3, [f64; N]) {
        if self.radius_rad == 0.0 {
            return (self.direction, [1.0; N]);
        }
        let fraction = random.unit().sqrt();
        let angle = fraction * self.radius_rad;
        (around(self.direction, angle.cos(), random), self.brightness(fraction))
    }
}
