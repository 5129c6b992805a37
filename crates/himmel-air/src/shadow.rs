//! Sunlight bent into the planet's shadow: what colours an eclipsed moon.

use std::f64::consts::PI;

use crate::error::AirError;
use crate::medium::Medium;
use crate::refraction::{End, trace};

/// Where a ray of sunlight that grazed the air crosses the plane of the moon.
#[derive(Clone, Copy, Debug)]
struct Ring {
    /// Impact parameter, m.
    impact_m: f64,
    /// Distance from the shadow's axis where it arrives, m; negative beyond the axis.
    arrives_m: f64,
    /// Transmittance.
    through: f64,
}

/// Light of a distant star behind a planet, over the distance from the shadow's axis, relative to the light without it.
#[derive(Clone, Debug)]
pub struct ShadowLight {
    rings: Vec<Ring>,
    star_radius_m: f64,
    solid_radius_m: f64,
    top_radius_m: f64,
}

impl ShadowLight {
    /// Follows rays of one wavelength past the planet, from the ground's limb to the top of the air.
    ///
    /// `distance_m`: from the planet's centre to the plane. `star_angular_radius_rad`: of the star as seen from there;
    /// its disc is even. `rays`: impact parameters, at least 16.
    ///
    /// Light between two neighbouring rays of impact b, b + db falls on the ring ρ, ρ + dρ: it is dimmed by
    /// |b db / (ρ dρ)| besides the air's extinction [link1969]; the caustic on the axis is finite because the star is
    /// extended: the sum runs over the star's image, not over points of the plane.
    ///
    /// Laws tested: without refraction nothing reaches the axis of the umbra; far outside the light is full; red
    /// reaches further in than blue.
    pub fn new(
        medium: &Medium,
        wavelength_nm: f64,
        distance_m: f64,
        star_angular_radius_rad: f64,
        rays: usize,
    ) -> Result<Self, AirError> {
        let wrong = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
        let (solid, top) = (medium.bottom_radius_m, medium.bottom_radius_m + medium.top_altitude_m);
        if !(distance_m > 2.0 * top && distance_m <= 1e13) {
            return wrong("distance of the plane", "lie beyond twice the planet's radius, up to 1e13 m", distance_m);
        }
        if !(star_angular_radius_rad > 0.0 && star_angular_radius_rad < 0.5) {
            return wrong("angular radius of the star", "lie in 0..0.5 rad", star_angular_radius_rad);
        }
        let rays = rays.clamp(16, 20_000);
        let far_m = medium.top_altitude_m + 1000.0;
        let mut rings = Vec::with_capacity(rays + 1);
        for i in 0..=rays {
            // Crowded towards the ground, where rays bend most.
            let impact_m = solid + medium.top_altitude_m * (i as f64 / rays as f64).powf(1.5);
            let elevation = -(impact_m / (solid + far_m)).clamp(0.0, 1.0).acos();
            let bent = trace(medium, wavelength_nm, far_m, elevation)?;
            if bent.end == End::Space {
                let arrives_m = impact_m - distance_m * bent.deviation_rad.tan();
                rings.push(Ring { impact_m, arrives_m, through: (-bent.optical_depth).exp() });
            }
        }
        Ok(Self {
            rings,
            star_radius_m: star_angular_radius_rad * distance_m,
            solid_radius_m: solid,
            top_radius_m: top,
        })
    }

    /// Share of the star's light that arrives at a distance from the axis, 0..=1 (a little above 1 is focusing).
    pub fn at(&self, axis_distance_m: f64) -> f64 {
        let star = self.star_radius_m;
        let area = PI * star * star;
        // Each ring of impact b maps the plane's point to a circle on the star: the point sees, through the ring, those
        // points of the star's projected disc that lie ρ(b) away along the ring's azimuth. Its share is
        // ∫∫ T [point + ρ-offset within the disc] b db dψ / (π s²), as the étendue of the bundle is kept.
        let mut sum = 0.0;
        for pair in self.rings.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let (impact, width) = (0.5 * (a.impact_m + b.impact_m), b.impact_m - a.impact_m);
            let shift = 0.5 * (a.arrives_m + b.arrives_m);
            let through = 0.5 * (a.through + b.through);
            // The disc of the star, thrown through the ring's point at azimuth ψ, is centred at shift·(cos ψ, sin ψ).
            sum += through * impact * width * 2.0 * PI * self.share_of_circle(axis_distance_m, shift);
        }
        // Straight past the air.
        let outside = area - overlap(axis_distance_m, star, self.top_radius_m);
        (sum / area + outside / area).max(0.0)
    }

    /// Share of the azimuths ψ for which |x − shift (cos ψ, sin ψ)| is within the star's projected radius.
    fn share_of_circle(&self, x: f64, shift: f64) -> f64 {
        let (x, r, s) = (x.abs(), shift.abs(), self.star_radius_m);
        if x + r <= s {
            return 1.0;
        }
        if (x - r).abs() >= s {
            return 0.0;
        }
        ((x * x + r * r - s * s) / (2.0 * x * r)).clamp(-1.0, 1.0).acos() / PI
    }

    /// Radius of the planet's solid body, m.
    pub fn solid_radius_m(&self) -> f64 {
        self.solid_radius_m
    }
}

/// Area that two circles share: radii `a`, `b`, centres `d` apart.
fn overlap(d: f64, a: f64, b: f64) -> f64 {
    let d = d.abs();
    if d >= a + b {
        return 0.0;
    }
    if d <= (a - b).abs() {
        return PI * a.min(b).powi(2);
    }
    let alpha = ((d * d + a * a - b * b) / (2.0 * d * a)).clamp(-1.0, 1.0).acos();
    let beta = ((d * d + b * b - a * a) / (2.0 * d * b)).clamp(-1.0, 1.0).acos();
    a * a * (alpha - 0.5 * (2.0 * alpha).sin()) + b * b * (beta - 0.5 * (2.0 * beta).sin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    const MOON_M: f64 = 384.4e6;
    const SUN_RAD: f64 = 0.2666 * PI / 180.0;

    #[test]
    fn red_light_reaches_the_axis_of_the_umbra() {
        let earth = Preset::named("earth").unwrap();
        let light = |nm| ShadowLight::new(&earth.medium, nm, MOON_M, SUN_RAD, 400).unwrap();
        let (red, green, blue) = (light(680.0), light(550.0), light(440.0));
        for km in [0.0, 1000.0, 3000.0] {
            let (r, g, b) = (red.at(km * 1e3), green.at(km * 1e3), blue.at(km * 1e3));
            println!("{km} km from the axis: {r:.2e} {g:.2e} {b:.2e} at 680, 550, 440 nm");
            assert!(r > g && g > b && r < 0.01, "{km}: {r} {g} {b}");
        }
        // Full light outside the penumbra, none of it missing.
        let outside = red.at(20_000e3);
        assert!((outside - 1.0).abs() < 2e-3, "{outside}");
    }

    #[test]
    fn without_refraction_the_umbra_is_black() {
        let preset = Preset::named("bruneton2017").unwrap();
        let light = ShadowLight::new(&preset.medium, 550.0, MOON_M, SUN_RAD, 200).unwrap();
        assert_eq!(light.at(0.0), 0.0);
        assert_eq!(light.at(4000e3), 0.0);
        assert!((light.at(30_000e3) - 1.0).abs() < 1e-9);
        // Half of the Sun's disc covers the penumbra's middle.
        let half = light.at(6400e3);
        assert!((0.3..0.7).contains(&half), "{half}");
        assert!(ShadowLight::new(&preset.medium, 550.0, 1.0, SUN_RAD, 20).is_err());
    }
}
