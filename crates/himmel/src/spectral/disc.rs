//! The star's disc behind the air, without chance: finer and finer points where a pixel touches it.

use super::*;
use himmel_air::sun::relative_disc_brightness;

/// Points along a pixel's side for each pixel's width in radii of the disc, and the fewest and the most of them.
const POINTS_PER_RADIUS: f64 = 8.0;
const FEWEST: f64 = 8.0;
const MOST: f64 = 256.0;

impl ReferencePicture {
    /// XYZ in cd m⁻² that the disc adds to the pixels that it touches.
    pub(super) fn draw_disc(&self) -> Result<Vec<(usize, DVec3)>> {
        let radius = self.sun.radius_rad;
        let mut pixels = Vec::new();
        for index in 0..self.sums.len() {
            let direction = |x: f64, y: f64| self.view.direction(self.ndc(index, x, y));
            let Some(centre) = direction(0.5, 0.5) else { continue };
            let reach = |x: f64, y: f64| direction(x, y).map_or(0.0, |corner| centre.angle_between(corner));
            let reach = reach(0.0, 0.0).max(reach(1.0, 1.0)).max(reach(1.0, 0.0)).max(reach(0.0, 1.0));
            // A tenth more: sides may bulge.
            if centre.angle_between(self.disc_direction) > radius + 1.1 * reach {
                continue;
            }
            let across = POINTS_PER_RADIUS * std::f64::consts::SQRT_2 * reach / radius.max(1e-9);
            let xyz = self.disc_in_pixel(index, across.clamp(FEWEST, MOST).ceil() as u32)?;
            if xyz != DVec3::ZERO {
                pixels.push((index, xyz));
            }
        }
        Ok(pixels)
    }

    /// Mean over `across`² points of a pixel.
    fn disc_in_pixel(&self, index: usize, across: u32) -> Result<DVec3> {
        let radius = self.sun.radius_rad;
        // 2π (1 − cos r) without the difference.
        let solid_angle = 2.0 * TAU * (0.5 * radius).sin().powi(2);
        let mut sum = [0.0; WAVELENGTHS];
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(across);
        for (row, column) in (0..across).flat_map(|row| (0..across).map(move |column| (row, column))) {
            let Some(direction) = self.view.direction(self.ndc(index, place(column), place(row))) else { continue };
            let direction = direction.normalize();
            let fraction = direction.angle_between(self.disc_direction) / radius.max(1e-12);
            if fraction > 1.0 {
                continue;
            }
            let through = self.tracer.transmittance(self.altitude_m, direction)?;
            for k in 0..WAVELENGTHS {
                let brightness = self.sun.limb.map_or(1.0, |limb| relative_disc_brightness(fraction, &limb[k]));
                sum[k] += through[k] * brightness;
            }
        }
        let points = f64::from(across) * f64::from(across);
        Ok(self.xyz(&sum.map(|value| value / (points * solid_angle.max(1e-30)))))
    }
}
