//! Artificial satellites from two-line elements, by SGP4   [vallado2006], with the crate `sgp4`.

use crate::apparent::{Apparent, Observer};
use crate::constants::{EARTH_ECLIPSE_RADIUS_M, SECONDS_PER_DAY, SUN_RADIUS_M};
use crate::earth::axes_turned_z;
use crate::error::{AstroError, Result, shown};
use crate::physical::angle_between;
use crate::time::Instant;
use glam::DVec3;

/// Elements older or younger than this are refused: SGP4 is off by tens of kilometres after weeks already.
const LARGEST_AGE_DAYS: f64 = 3_652.5;

/// A satellite ready to be asked where it is.
#[derive(Clone)]
pub struct Satellite {
    name: String,
    norad_id: u64,
    epoch_jd_utc: f64,
    constants: sgp4::Constants,
}

/// Where a satellite is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SatelliteView {
    /// Place in the sky, airless; the distance is the range.
    pub seen: Apparent,
    /// From the Earth's centre, Earth-fixed axes.
    pub ecef_m: DVec3,
    /// Part of the Sun's disc that the satellite sees past the Earth, 0..=1 (no air).
    pub sunlit: f64,
}

impl Satellite {
    /// Reads a TLE: two lines of 69 characters, before them perhaps one with the name.
    pub fn parse(text: &str) -> Result<Self> {
        let malformed = |reason: String| AstroError::Malformed { what: "TLE", text: shown(text), reason };
        let lines: Vec<&str> = text.lines().map(str::trim_end).filter(|l| !l.is_empty()).collect();
        let (name, one, two) = match lines.as_slice() {
            [one, two] => ("", *one, *two),
            [name, one, two] => (name.trim_start_matches("0 ").trim(), *one, *two),
            _ => return Err(malformed(format!("expected two or three lines, found {}", lines.len()))),
        };
        for (number, line) in [(1, one), (2, two)] {
            if !line.is_ascii() || line.len() != 69 {
                return Err(malformed(format!(
                    "line {number} must have 69 plain characters, it has {}",
                    line.chars().count()
                )));
            }
        }
        let elements = sgp4::Elements::from_tle(Some(name.to_owned()), one.as_bytes(), two.as_bytes())
            .map_err(|e| malformed(e.to_string()))?;
        let epoch = elements.datetime.and_utc();
        let epoch_jd_utc = 2_440_587.5
            + (epoch.timestamp() as f64 + f64::from(epoch.timestamp_subsec_nanos()) * 1e-9) / SECONDS_PER_DAY;
        let constants = sgp4::Constants::from_elements(&elements).map_err(|e| malformed(e.to_string()))?;
        Ok(Self { name: name.to_owned(), norad_id: elements.norad_id, epoch_jd_utc, constants })
    }

    /// Its name, empty where the TLE had none.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its catalogue number.
    pub fn norad_id(&self) -> u64 {
        self.norad_id
    }

    /// Days from the elements' epoch to an instant.
    pub fn age_days(&self, instant: &Instant) -> f64 {
        instant.utc().jd() - self.epoch_jd_utc
    }

    /// From the Earth's centre along Earth-fixed axes; the frame of SGP4 (TEME) turned by mean sidereal time of 1982.
    pub fn ecef_m(&self, instant: &Instant) -> Result<DVec3> {
        let days = self.age_days(instant);
        if days.abs() > LARGEST_AGE_DAYS {
            return Err(AstroError::NoSolution {
                what: "the satellite's orbit",
                reason: format!(
                    "its elements are {days:.0} days away; use newer ones (within days, at most ten years)"
                ),
            });
        }
        let prediction = self.constants.propagate(sgp4::MinutesSinceEpoch(days * 1440.0)).map_err(|e| {
            AstroError::NoSolution { what: "the satellite's orbit", reason: format!("{e}; it may have decayed") }
        })?;
        let teme = DVec3::from_array(prediction.position) * 1e3;
        if !teme.is_finite() {
            return Err(AstroError::NoSolution { what: "the satellite's orbit", reason: "it is not finite".into() });
        }
        Ok(axes_turned_z(sofars::erst::gmst82(instant.ut1().jd(), 0.0)) * teme)
    }
}

impl Observer<'_> {
    /// Where a satellite is seen, and how much Sun it has. Light time (some ms) is left out.
    pub fn satellite(&self, satellite: &Satellite) -> Result<SatelliteView> {
        let ecef_m = satellite.ecef_m(&self.instant)?;
        let from_site = ecef_m - self.place.ecef_m();
        let gcrs_from_ecef = self.orientation.ecef_from_gcrs.transpose();
        let range_m = from_site.length().max(1.0);
        let vector_m = gcrs_from_ecef * from_site;
        let mut seen = self.seen(vector_m / range_m);
        seen.distance_m = range_m;
        seen.vector_m = vector_m;
        let from_earth = gcrs_from_ecef * ecef_m;
        let to_sun = self.sun.position_m - self.earth.position_m - from_earth;
        let earth_radius = (EARTH_ECLIPSE_RADIUS_M / from_earth.length()).min(1.0).asin();
        let sun_radius = (SUN_RADIUS_M / to_sun.length()).min(1.0).asin();
        let apart = angle_between(-from_earth, to_sun);
        let sunlit = 1.0 - crate::events::covered_part(sun_radius, earth_radius, apart);
        Ok(SatelliteView { seen, ecef_m, sunlit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fast, Place};

    const ISS: &str = "ISS (ZARYA)\n1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927\n\
                       2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537\n";

    #[test]
    fn the_station_flies_where_it_should() {
        let iss = Satellite::parse(ISS).unwrap();
        assert_eq!((iss.name(), iss.norad_id()), ("ISS (ZARYA)", 25_544));
        let mut lit = [false; 2];
        for minute in 0..120 {
            let instant = Instant::from_unix_seconds(1_221_913_540.0 + f64::from(minute) * 60.0).unwrap();
            let height = iss.ecef_m(&instant).unwrap().length() - 6_371e3;
            assert!((320e3..380e3).contains(&height), "{height}");
            let place = Place::from_degrees(0.0, 0.0, 0.0).unwrap();
            let view = Observer::new(&Fast, &instant, &place).unwrap().satellite(&iss).unwrap();
            assert!((0.0..=1.0).contains(&view.sunlit));
            lit[usize::from(view.sunlit > 0.5)] = true;
            assert!(view.seen.altitude_rad < 0.0 || view.seen.distance_m < 2.6e6);
        }
        assert_eq!(lit, [true, true], "an orbit has day and night");
    }

    #[test]
    fn broken_elements_are_refused() {
        for text in ["", "x", "a\nb", "a\nb\nc\nd", &ISS.replace("51.6416", "5x.6416"), &ISS.replace("2927", "2926")] {
            assert!(Satellite::parse(text).is_err(), "{text}");
        }
        let iss = Satellite::parse(ISS).unwrap();
        let e = iss.ecef_m(&Instant::from_unix_seconds(0.0).unwrap()).unwrap_err();
        assert!(e.to_string().contains("newer"), "{e}");
    }
}
