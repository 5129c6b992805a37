use super::magnitude::{Circumstances, planet_magnitude};
use super::saturn::pole_icrs;
use crate::apparent::{Apparent, Observer};
use crate::body::Body;
use crate::constants::AU_M;
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// How a body looks from the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// Lit part of the disc, 0..=1.
    pub illuminated_fraction: f64,
    /// Sun–body–observer, 0..=π.
    pub phase_angle_rad: f64,
    /// Visual magnitude above the air.
    pub magnitude: f64,
    /// Of the middle of the bright limb, from north through east, 0..2π; equator of date.
    pub bright_limb_position_angle_rad: f64,
    /// From the Sun, in the sky.
    pub elongation_rad: f64,
    /// From the Sun, in space.
    pub sun_distance_m: f64,
}

/// The Earth as seen from the Moon, which is what lights the Moon's dark part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Earthshine {
    /// Sun–Earth–Moon.
    pub phase_angle_rad: f64,
    /// Lit part of the Earth's disc.
    pub illuminated_fraction: f64,
    /// Visual magnitude of the Earth   [mallama2018].
    pub magnitude: f64,
    /// Of the Moon's ground with the Earth in its zenith.
    pub illuminance_lx: f64,
}

/// Position angle of a direction as seen at another, from celestial north through east, 0..2π; both along equatorial axes.
pub fn position_angle_rad(at: DVec3, towards: DVec3) -> f64 {
    let east = DVec3::new(-at.y, at.x, 0.0);
    let north = at.cross(east);
    towards.dot(east).atan2(towards.dot(north)).rem_euclid(TAU)
}

/// The angle at a body between zenith and celestial north, positive west of the meridian, −π..=π.
///
/// tan q = sin H / (tan φ cos δ − sin δ cos H)   [meeus1998, eq. 14.1]
pub fn parallactic_angle_rad(hour_angle_rad: f64, declination_rad: f64, latitude_rad: f64) -> f64 {
    let (sin_h, cos_h) = hour_angle_rad.sin_cos();
    let (sin_d, cos_d) = declination_rad.sin_cos();
    let (sin_f, cos_f) = latitude_rad.sin_cos();
    (sin_h * cos_f).atan2(sin_f * cos_d - sin_d * cos_h * cos_f)
}

/// Angle between two vectors, exact for small and large ones   [kahan2006].
pub(crate) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let (a, b) = (a.normalize(), b.normalize());
    2.0 * (a - b).length().atan2((a + b).length())
}

impl Observer<'_> {
    /// Phase, brightness and bright limb of a body whose place is `seen` ([`Observer::apparent`]).
    pub fn appearance(&self, body: Body, seen: &Apparent) -> Result<Appearance> {
        let vector = seen.vector_m;
        let from_sun = self.state.position_m + vector - self.sun.position_m;
        let sun_distance_m = if body == Body::Sun { 0.0 } else { from_sun.length() };
        let geometric = if body == Body::Sun { 0.0 } else { angle_between(from_sun, vector) };
        let phase_angle_rad = self.fixed_phase_angle_rad(body).unwrap_or(geometric);
        let sun = if body == Body::Sun { *seen } else { self.apparent(Body::Sun)? };
        let turn = self.orientation.true_from_gcrs;
        let (sun_latitude, observer_latitude) = pole_icrs(body, self.instant.tdb()).map_or((0.0, 0.0), |pole| {
            let latitude = |v: DVec3| PI / 2.0 - angle_between(pole, -v);
            (latitude(from_sun), latitude(vector))
        });
        let magnitude = planet_magnitude(
            body,
            &Circumstances {
                sun_distance_au: sun_distance_m / AU_M,
                distance_au: seen.distance_m / AU_M,
                phase_angle_deg: phase_angle_rad.to_degrees(),
                sun_latitude_deg: sun_latitude.to_degrees(),
                observer_latitude_deg: observer_latitude.to_degrees(),
                year: 2000.0 + 100.0 * self.instant.tt().centuries_since_j2000(),
            },
        );
        Ok(Appearance {
            illuminated_fraction: 0.5 * (1.0 + phase_angle_rad.cos()),
            phase_angle_rad,
            magnitude,
            bright_limb_position_angle_rad: position_angle_rad(turn * seen.direction_gcrs, turn * sun.direction_gcrs),
            elongation_rad: angle_between(seen.direction_gcrs, sun.direction_gcrs),
            sun_distance_m,
        })
    }

    /// Local hour angle of a place in the sky, −π..=π, positive west of the meridian.
    pub fn hour_angle_rad(&self, seen: &Apparent) -> f64 {
        let h = self.orientation.apparent_sidereal_time_rad + self.place.longitude_rad() - seen.right_ascension_rad;
        (h + PI).rem_euclid(TAU) - PI
    }

    /// Parallactic angle of a place in the sky.
    pub fn parallactic_angle_rad(&self, seen: &Apparent) -> f64 {
        parallactic_angle_rad(self.hour_angle_rad(seen), seen.declination_rad, self.place.latitude_rad())
    }

    /// The Earth as the Moon sees it.
    pub fn earthshine(&self) -> Earthshine {
        let to_sun = self.sun.position_m - self.earth.position_m;
        let phase_angle_rad = angle_between(to_sun, self.moon_from_earth.position_m);
        let magnitude = planet_magnitude(
            Body::Earth,
            &Circumstances {
                sun_distance_au: to_sun.length() / AU_M,
                distance_au: self.moon_from_earth.position_m.length() / AU_M,
                phase_angle_deg: phase_angle_rad.to_degrees(),
                sun_latitude_deg: 0.0,
                observer_latitude_deg: 0.0,
                year: 2000.0,
            },
        );
        Earthshine {
            phase_angle_rad,
            illuminated_fraction: 0.5 * (1.0 + phase_angle_rad.cos()),
            magnitude,
            illuminance_lx: super::illuminance_lx(magnitude),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fast, Instant, Place};

    #[test]
    fn moon_and_earth_have_opposite_phases_and_sun_has_none() {
        let place = Place::from_degrees(50.0, 10.0, 0.0).unwrap();
        for day in 0..30 {
            let instant = Instant::from_unix_seconds(1.5e9 + f64::from(day) * 86_400.0).unwrap();
            let observer = Observer::new(&Fast, &instant, &place).unwrap();
            let moon = observer.apparent(Body::Moon).unwrap();
            let look = observer.appearance(Body::Moon, &moon).unwrap();
            // Phase, elongation and the angle at the Sun make a triangle; the Sun's is below 0.16°. Parallax moves the Moon by 1°.
            assert!((look.phase_angle_rad + look.elongation_rad - PI).abs() < 0.003);
            assert!((observer.earthshine().illuminated_fraction + look.illuminated_fraction - 1.0).abs() < 0.02);
            let sun = observer.apparent(Body::Sun).unwrap();
            assert_eq!(observer.appearance(Body::Sun, &sun).unwrap().illuminated_fraction, 1.0);
        }
    }

    /// [meeus1998, example 48.a]: 1992-04-12 0h TD: k = 0.6786, χ = 285.0°, geocentric.
    #[test]
    fn bright_limb_of_meeus() {
        let tt = crate::time::JulianDateTt::new(2_448_724.5).unwrap();
        let instant = Instant::from_tt(tt, crate::time::DeltaTModel::Standard);
        // The place with the Moon near its zenith, where parallax moves it little.
        let place = Place::from_degrees(13.77, -67.0, 0.0).unwrap();
        let observer = Observer::new(&Fast, &instant, &place).unwrap();
        let moon = observer.apparent(Body::Moon).unwrap();
        let look = observer.appearance(Body::Moon, &moon).unwrap();
        assert!((look.illuminated_fraction - 0.6786).abs() < 0.003, "{}", look.illuminated_fraction);
        assert!((look.bright_limb_position_angle_rad.to_degrees() - 285.0).abs() < 0.3);
    }

    #[test]
    fn parallactic_angle_is_odd_and_zero_on_the_meridian() {
        assert_eq!(parallactic_angle_rad(0.0, 0.2, 0.9), 0.0);
        let q = parallactic_angle_rad(0.5, 0.2, 0.9);
        assert!(q > 0.0 && (q + parallactic_angle_rad(-0.5, 0.2, 0.9)).abs() < 1e-15);
    }
}
