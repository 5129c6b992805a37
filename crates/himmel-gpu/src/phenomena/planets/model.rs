//! What planets are to the renderer, and the f64 twins of `shade.wgsl`: same names, order and units.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

/// A planet whose disc may be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanetDisc {
    /// Which of the frame's points it is where its disc is too small.
    pub body: usize,
    /// Unit vector to its centre, without refraction, east-north-up.
    pub direction: DVec3,
    /// Apparent equatorial radius, rad.
    pub radius_rad: f64,
    /// Polar over equatorial radius.
    pub polar: f64,
    /// Unit vector from it to the Sun, east-north-up.
    pub sun: DVec3,
    /// Unit vector along its north pole, east-north-up.
    pub pole: DVec3,
    /// Whether it has Saturn's rings.
    pub rings: bool,
    /// Irradiance of all its light above the air at the four wavelengths, relative to the preset's star at 1 au.
    pub irradiance: [f64; 4],
}

/// A planet's disc in its own frame: x along the equator in the sky, y along the projected pole, z to the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanetFrame {
    /// Unit vectors in the sky, east-north-up.
    pub along: [DVec3; 2],
    /// Apparent polar radius over the equatorial one.
    pub flat_radius: f64,
    /// To the Sun, in the frame.
    pub sun: DVec3,
    /// The pole, in the frame: (0, cos B, sin B).
    pub pole: DVec3,
}

impl PlanetDisc {
    /// Half the side of the square that holds it, in radii.
    pub fn reach(&self) -> f64 {
        if self.rings { RING_EDGES[4] + 0.05 } else { 1.1 }
    }

    /// Its frame.
    pub fn frame(&self) -> PlanetFrame {
        let to_observer = -self.direction;
        let sine = self.pole.dot(to_observer).clamp(-1.0, 1.0);
        let y = (self.pole - to_observer * sine).normalize_or(to_observer.any_orthonormal_vector());
        let x = y.cross(to_observer);
        let into = |v: DVec3| DVec3::new(v.dot(x), v.dot(y), v.dot(to_observer));
        let (cos2, sin2) = (1.0 - sine * sine, sine * sine);
        PlanetFrame {
            along: [x, y],
            flat_radius: (sin2 + self.polar * self.polar * cos2).sqrt(),
            sun: into(self.sun),
            pole: into(self.pole),
        }
    }

    /// Radiance of a surface that faces the Sun per unit of irradiance, sr⁻¹: the disc then shines as bright as it should.
    ///
    /// Without rings E = L π ρ² b Φ(α) with Lambert's phase function; with rings the sum over a raster.
    pub fn radiance_scale(&self) -> f64 {
        let frame = self.frame();
        let area = if self.rings {
            const STEPS: i32 = 96;
            let reach = self.reach();
            let cell = 2.0 * reach / f64::from(STEPS);
            let at = |i: i32| -reach + (f64::from(i) + 0.5) * cell;
            (0..STEPS * STEPS)
                .map(|i| planet_shade(DVec2::new(at(i % STEPS), at(i / STEPS)), &frame, true) * cell * cell)
                .sum()
        } else {
            PI * frame.flat_radius * lambert_phase(frame.sun.z.clamp(-1.0, 1.0).acos())
        };
        1.0 / (area * self.radius_rad * self.radius_rad).max(1e-30)
    }
}

/// Light of a Lambert sphere over that of a flat disc that faces the Sun: 2/(3π) (sin α + (π − α) cos α)   [russell1916].
pub fn lambert_phase(alpha_rad: f64) -> f64 {
    2.0 / (3.0 * PI) * (alpha_rad.sin() + (PI - alpha_rad) * alpha_rad.cos())
}

/// Edges of the rings in Saturn's radii: C inner, B inner, B outer, A inner, A outer   [nssdc2016].
pub const RING_EDGES: [f64; 5] = [1.2388, 1.5265, 1.9510, 2.0271, 2.2694];

/// Optical depth and brightness of the rings by distance from the axis: C, B, Cassini's division, A   [cuzzi1984, rounded].
pub fn ring_at(rho: f64) -> [f64; 2] {
    match RING_EDGES.iter().filter(|edge| rho >= **edge).count() {
        1 => [0.10, 0.45],
        2 => [1.8, 1.0],
        3 => [0.12, 0.5],
        4 => [0.50, 0.8],
        _ => [0.0, 0.0],
    }
}

/// Brightness of globe and rings relative to a surface that faces the Sun, at a place in radii.
///
/// Globe: Lambert, with the rings' shadow. Rings: light scattered once, μ₀/(μ₀ + μ) (1 − e^(−τ (1/μ + 1/μ₀)))
/// [chandrasekhar1960], with the globe's shadow; what is behind shines through as e^(−τ/μ).
/// Laws tested: nothing outside; dark beyond the terminator; rings pass before and behind the globe.
pub fn planet_shade(place: DVec2, frame: &PlanetFrame, rings: bool) -> f64 {
    let (sun, pole) = (frame.sun, frame.pole);
    let mut light = 0.0;
    let mut globe_z = -1e3;
    let squeezed = DVec2::new(place.x, place.y / frame.flat_radius);
    let inside = squeezed.length_squared();
    if inside < 1.0 {
        let normal = squeezed.extend((1.0 - inside).sqrt());
        globe_z = normal.z;
        light = normal.dot(sun).max(0.0);
        let (height, slope) = (normal.dot(pole), sun.dot(pole));
        if rings && height * slope < 0.0 {
            let met = normal - sun * (height / slope);
            light *= (-ring_at(met.length())[0] / slope.abs().max(0.01)).exp();
        }
    }
    let tilt = pole.z;
    if rings && tilt.abs() > 1e-3 {
        let at = place.extend(-place.y * pole.y / tilt);
        let [depth_up, brightness] = ring_at(at.length());
        if depth_up > 0.0 && at.z > globe_z {
            let (mu, mu_s) = (tilt.abs(), sun.dot(pole).abs());
            let along = at.dot(sun);
            let dark = along < 0.0 && (at - along * sun).length() < 1.0;
            let lit = if tilt * sun.dot(pole) > 0.0 { 1.0 } else { 0.08 };
            let depth = depth_up * (1.0 / mu + 1.0 / mu_s.max(0.01));
            let bright = 1.9 * brightness * lit * mu_s / (mu_s + mu) * -(-depth).exp_m1();
            light = light * (-depth_up / mu).exp() + if dark { 0.0 } else { bright };
        }
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(phase_deg: f64, rings: bool, tilt_deg: f64) -> PlanetDisc {
        let (alpha, tilt) = (phase_deg.to_radians(), tilt_deg.to_radians());
        // Seen towards north; the observer is south of it.
        PlanetDisc {
            body: 0,
            direction: DVec3::Y,
            radius_rad: 1e-4,
            polar: 1.0,
            sun: DVec3::new(alpha.sin(), -alpha.cos(), 0.0),
            pole: DVec3::new(0.0, -tilt.sin(), tilt.cos()),
            rings,
            irradiance: [1.0; 4],
        }
    }

    fn area(disc: &PlanetDisc) -> f64 {
        let (frame, steps) = (disc.frame(), 1600);
        let at = |i: i32| 2.4 * (2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0);
        let cell = (4.8 / f64::from(steps)).powi(2);
        (0..steps * steps)
            .map(|i| cell * planet_shade(DVec2::new(at(i % steps), at(i / steps)), &frame, disc.rings))
            .sum()
    }

    #[test]
    fn a_disc_gives_the_light_that_it_should() {
        for (phase, rings, tilt) in
            [(0.0, false, 0.0), (70.0, false, 3.0), (150.0, false, 0.0), (4.0, true, 20.0), (5.0, true, -9.0)]
        {
            let disc = disc(phase, rings, tilt);
            let flux = disc.radiance_scale() * area(&disc) * disc.radius_rad.powi(2);
            assert!((flux - 1.0).abs() < 0.01, "{phase} {rings}: {flux}");
        }
    }

    #[test]
    fn phases_and_rings_are_where_they_should_be() {
        let half = disc(90.0, false, 0.0);
        let frame = half.frame();
        let [x, y] = frame.along;
        // Right-handed as seen: up is up, and x to the right of somebody who looks north is east.
        assert!((x - DVec3::X).length() < 1e-12 && (y - DVec3::Z).length() < 1e-12);
        assert!(planet_shade(DVec2::new(0.5, 0.0), &frame, false) > 0.4);
        assert_eq!(planet_shade(DVec2::new(-0.5, 0.0), &frame, false), 0.0);
        assert_eq!(planet_shade(DVec2::new(1.1, 0.0), &frame, false), 0.0);
        // Northern side towards us: the near half of the rings is below the middle and covers the globe there.
        let saturn = disc(0.0, true, 20.0).frame();
        let sine = 20f64.to_radians().sin();
        let near = planet_shade(DVec2::new(0.0, -1.7 * sine), &saturn, true);
        let far = planet_shade(DVec2::new(0.0, 1.7 * sine), &saturn, true);
        assert!(near != far && (far - (1.0 - (1.7 * sine).powi(2)).sqrt()).abs() < 1e-12);
        // Cassini's division is darker than both sides of it.
        let at = |rho: f64| planet_shade(DVec2::new(rho, 0.0), &saturn, true);
        assert!(at(1.99) < 0.6 * at(1.8) && at(1.99) < 0.6 * at(2.1) && at(2.3) == 0.0);
    }

    /// The plate of the globe's shadow lies on the ring away from the Sun.
    #[test]
    fn the_globe_shades_the_rings() {
        let disc = disc(6.0, true, 25.0);
        let frame = disc.frame();
        let lit = |x: f64| planet_shade(DVec2::new(x, 0.55), &frame, true);
        let dark = (0..400).map(|i| f64::from(i) * 0.01 - 2.0).filter(|x| {
            lit(*x) == 0.0
                && ring_at((DVec2::new(*x, 0.55).extend(-0.55 * frame.pole.y / frame.pole.z)).length())[0] > 0.0
        });
        let places: Vec<f64> = dark.collect();
        assert!(places.iter().all(|x| *x < 1.2));
    }
}
