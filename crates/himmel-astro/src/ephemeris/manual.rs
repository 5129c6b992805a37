use super::{Ephemeris, Fast, State};
use crate::body::Body;
use crate::earth::EarthOrientation;
use crate::error::{Result, in_range};
use crate::place::Place;
use crate::time::{Instant, JulianDateTdb};
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

/// Bodies where the caller puts them: for fiction, for tests, for a light that an artist moves. What is not set comes from the
/// fast level.
///
/// A place is fixed once for the instant and observer given and stays there in space; light time and aberration, which every level
/// shares, are undone, so that the body is *seen* where it was put (to 0.001″).
#[derive(Debug, Clone, Default)]
pub struct Manual {
    states: HashMap<Body, DVec3>,
}

impl Manual {
    /// Nothing set yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Puts a body where an observer sees it: azimuth from north through east, airless altitude, distance. The phase follows from where
    /// the Sun is put.
    pub fn put(
        &mut self,
        body: Body,
        (instant, place): (&Instant, &Place),
        azimuth_rad: f64,
        altitude_rad: f64,
        distance_m: f64,
    ) -> Result<&mut Self> {
        in_range("azimuth", "-7..=7 rad", azimuth_rad, -7.0, 7.0, " (is this in degrees?)")?;
        in_range("altitude", "-π/2..=π/2 rad", altitude_rad, -FRAC_PI_2, FRAC_PI_2, " (is this in degrees?)")?;
        in_range("distance", "1e5..=1e18 m", distance_m, 1e5, 1e18, " (is this in km?)")?;
        let (sin_az, cos_az) = azimuth_rad.sin_cos();
        let (sin_alt, cos_alt) = altitude_rad.sin_cos();
        let enu = DVec3::new(cos_alt * sin_az, cos_alt * cos_az, sin_alt);
        let orientation = EarthOrientation::at(instant);
        let gcrs_from_enu = (place.enu_from_ecef() * orientation.ecef_from_gcrs).transpose();
        let wanted = gcrs_from_enu * enu;
        // The direction whose aberrated one is wanted: three rounds of subtracting what aberration adds.
        let observer = crate::apparent::Observer::new(&*self, instant, place)?;
        let mut natural = wanted;
        for _ in 0..3 {
            natural = (natural + wanted - observer.aberrated(natural)).normalize();
        }
        let site = observer.state.position_m;
        self.states.insert(body, site + natural * distance_m);
        Ok(self)
    }
}

impl Ephemeris for Manual {
    fn name(&self) -> &'static str {
        "manual"
    }

    fn state(&self, body: Body, tdb: JulianDateTdb) -> Result<State> {
        match self.states.get(&body) {
            Some(position_m) => Ok(State { position_m: *position_m, velocity_m_s: DVec3::ZERO }),
            None if body == Body::Moon => self.earth_and_moon(tdb).map(|(earth, moon)| earth + moon),
            None => Fast.state(body, tdb),
        }
    }

    fn earth_and_moon(&self, tdb: JulianDateTdb) -> Result<(State, State)> {
        let (earth, moon) = Fast.earth_and_moon(tdb)?;
        let moon = match self.states.get(&Body::Moon) {
            Some(position_m) => State { position_m: *position_m - earth.position_m, velocity_m_s: -earth.velocity_m_s },
            None => moon,
        };
        Ok((earth, moon))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apparent::Observer;

    #[test]
    fn bodies_are_seen_where_they_were_put() {
        let place = Place::from_degrees(40.0, 20.0, 100.0).unwrap();
        let instant = Instant::from_unix_seconds(1.6e9).unwrap();
        let mut manual = Manual::new();
        manual.put(Body::Sun, (&instant, &place), 1.0, 0.5, 1.5e11).unwrap();
        manual.put(Body::Moon, (&instant, &place), 4.0, -0.2, 3.8e8).unwrap();
        let observer = Observer::new(&manual, &instant, &place).unwrap();
        for (body, azimuth, altitude, distance) in [(Body::Sun, 1.0, 0.5, 1.5e11), (Body::Moon, 4.0, -0.2, 3.8e8)] {
            let seen = observer.apparent(body).unwrap();
            assert!((seen.azimuth_rad - azimuth).abs() < 1e-7, "{body}: {}", seen.azimuth_rad - azimuth);
            assert!((seen.altitude_rad - altitude).abs() < 1e-7, "{body}");
            assert!((seen.distance_m / distance - 1.0).abs() < 1e-6);
        }
        assert!(manual.put(Body::Sun, (&instant, &place), 180.0, 0.5, 1.5e11).is_err());
        assert!(manual.put(Body::Sun, (&instant, &place), 1.0, f64::NAN, 1.5e11).is_err());
    }
}
