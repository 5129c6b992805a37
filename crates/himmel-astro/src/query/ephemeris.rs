use super::Target;
use crate::apparent::Observer;
use crate::body::Body;
use crate::earth::{EarthOrientation, NutationModel};
use crate::ephemeris::Ephemeris;
use crate::error::{AstroError, Result, shown};
use crate::place::Place;
use crate::refraction::AirAtObserver;
use crate::time::{Instant, JulianDateTt, JulianDateUt1, PolarMotion, polar_motion};

/// What the rows of a table share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conditions {
    /// The air for `refracted_altitude_deg`.
    pub air: AirAtObserver,
    /// Whether the pole's motion is taken into account where the IERS knows it (since 1962).
    pub polar_motion: bool,
}

impl Conditions {
    /// An observer under these conditions.
    pub fn observer<'a>(&self, ephemeris: &'a dyn Ephemeris, instant: &Instant, place: &Place) -> Result<Observer<'a>> {
        let pole = if self.polar_motion {
            polar_motion(instant.tt().jd()).unwrap_or_default()
        } else {
            PolarMotion::default()
        };
        let orientation = EarthOrientation::with(instant, NutationModel::default(), pole);
        Observer::with_orientation(ephemeris, instant, place, orientation)
    }
}

/// The columns of a table of questions, found by name.
#[derive(Debug, Clone, PartialEq)]
pub struct EphemerisTable {
    body: usize,
    time_utc: Option<usize>,
    clocks: Option<(usize, usize)>,
    latitude: usize,
    longitude: usize,
    height: Option<usize>,
}

/// What is known of one target at one instant and place; `None` where a number has no meaning (a star's phase).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Answer {
    /// Values in the order of [`Answer::COLUMNS`].
    pub values: [Option<f64>; 15],
}

impl Answer {
    /// Names of the answer's columns, with their units.
    pub const COLUMNS: [&'static str; 15] = [
        "azimuth_deg",
        "altitude_deg",
        "refracted_altitude_deg",
        "ra_deg",
        "dec_deg",
        "distance_km",
        "angular_diameter_deg",
        "illuminated_fraction",
        "phase_angle_deg",
        "magnitude",
        "position_angle_bright_limb_deg",
        "libration_longitude_deg",
        "libration_latitude_deg",
        "axis_position_angle_deg",
        "parallactic_angle_deg",
    ];

    /// The values as text with all their digits, empty where there is none.
    pub fn to_fields(&self) -> [String; 15] {
        self.values.map(|v| v.map_or_else(String::new, |v| format!("{v}")))
    }

    /// Everything about a target. Bright limb, phase and the like are left out for stars, libration for all but the Moon, the
    /// distance of stars without a measured parallax.
    pub fn of(target: &Target, observer: &Observer<'_>, air: &AirAtObserver) -> Result<Self> {
        let seen = target.apparent(observer)?;
        let mut values = [None; 15];
        values[0] = Some(seen.azimuth_rad.to_degrees());
        values[1] = Some(seen.altitude_rad.to_degrees());
        values[2] = Some(seen.refracted_altitude_rad(air).to_degrees());
        values[3] = Some(seen.right_ascension_rad.to_degrees());
        values[4] = Some(seen.declination_rad.to_degrees());
        values[14] = Some(observer.parallactic_angle_rad(&seen).to_degrees());
        match target {
            Target::Star(star) => {
                values[5] = (star.parallax_rad > 0.0).then_some(seen.distance_m / 1e3);
                values[9] = Some(star.v_magnitude);
            }
            Target::Body(body) => {
                values[5] = Some(seen.distance_m / 1e3);
                values[6] = Some(seen.angular_diameter_rad.to_degrees());
                let look = observer.appearance(*body, &seen)?;
                values[7] = Some(look.illuminated_fraction);
                values[8] = Some(look.phase_angle_rad.to_degrees());
                values[9] = Some(look.magnitude);
                if *body != Body::Sun {
                    values[10] = Some(look.bright_limb_position_angle_rad.to_degrees());
                }
                if *body == Body::Moon {
                    let libration = observer.libration(&seen);
                    values[11] = Some(libration.longitude_rad.to_degrees());
                    values[12] = Some(libration.latitude_rad.to_degrees());
                    values[13] = Some(libration.axis_position_angle_rad.to_degrees());
                }
            }
        }
        Ok(Self { values })
    }
}

impl EphemerisTable {
    /// Finds the columns `body`, `time_utc` or both of `jd_tt` and `jd_ut1`, `latitude_deg`, `longitude_deg`, and `height_m` (0 where
    /// absent). Others are none of its business.
    pub fn from_header<S: AsRef<str>>(header: &[S]) -> Result<Self> {
        let find = |name: &str| header.iter().position(|h| h.as_ref().trim().trim_start_matches('\u{feff}') == name);
        let need = |name: &str| {
            find(name).ok_or_else(|| AstroError::Malformed {
                what: "header line",
                text: shown(&header.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(",")),
                reason: format!("the column `{name}` is missing"),
            })
        };
        for name in ["body", "time_utc", "jd_tt", "jd_ut1", "latitude_deg", "longitude_deg", "height_m"] {
            let same = |h: &&S| h.as_ref().trim().trim_start_matches('\u{feff}') == name;
            if header.iter().filter(same).count() > 1 {
                return Err(AstroError::Malformed {
                    what: "header line",
                    text: shown(&header.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(",")),
                    reason: format!("the column `{name}` stands twice"),
                });
            }
        }
        let clocks = find("jd_tt").zip(find("jd_ut1"));
        let time_utc = find("time_utc");
        if clocks.is_none() {
            need("time_utc").map_err(|_| AstroError::Malformed {
                what: "header line",
                text: shown(&header.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(",")),
                reason: "it needs the column `time_utc` or both `jd_tt` and `jd_ut1`".into(),
            })?;
        }
        Ok(Self {
            body: need("body")?,
            time_utc,
            clocks,
            latitude: need("latitude_deg")?,
            longitude: need("longitude_deg")?,
            height: find("height_m"),
        })
    }

    /// Answers one row. The pair `jd_tt, jd_ut1` goes before `time_utc` where both are filled in.
    pub fn answer<S: AsRef<str>>(
        &self,
        row: &[S],
        ephemeris: &dyn Ephemeris,
        conditions: &Conditions,
    ) -> Result<Answer> {
        let field = |i: usize| row.get(i).map(|f| f.as_ref().trim()).unwrap_or_default();
        let number = |i: usize, what: &'static str| {
            let text = field(i);
            text.parse::<f64>().map_err(|_| AstroError::Malformed {
                what,
                text: shown(text),
                reason: if text.is_empty() { "it is empty".into() } else { "expected a number".into() },
            })
        };
        let target = Target::parse(field(self.body))?;
        let clocks = self.clocks.filter(|(tt, ut1)| {
            self.time_utc.is_none_or(|u| field(u).is_empty()) || !(field(*tt).is_empty() || field(*ut1).is_empty())
        });
        let instant = match (clocks, self.time_utc) {
            (Some((tt, ut1)), _) => Instant::from_tt_ut1(
                JulianDateTt::new(number(tt, "jd_tt")?)?,
                JulianDateUt1::new(number(ut1, "jd_ut1")?)?,
            )?,
            (None, Some(utc)) => Instant::parse(field(utc))?,
            (None, None) => Instant::parse("")?,
        };
        let height_m = match self.height {
            Some(i) if !field(i).is_empty() => number(i, "height_m")?,
            _ => 0.0,
        };
        let place = Place::from_degrees(
            number(self.latitude, "latitude_deg")?,
            number(self.longitude, "longitude_deg")?,
            height_m,
        )?;
        Answer::of(&target, &conditions.observer(ephemeris, &instant, &place)?, &conditions.air)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fast;

    const HEADER: [&str; 7] = ["note", "height_m", "longitude_deg", "latitude_deg", "time_utc", "body", "jd_tt"];

    #[test]
    fn rows_are_answered_in_any_order_of_columns() {
        let table = EphemerisTable::from_header(&HEADER).unwrap();
        let air = Conditions::default();
        let row = ["mine", "", "13.06", "52.4", "2012-09-06T12:00Z", "Moon", ""];
        let answer = table.answer(&row, &Fast, &air).unwrap();
        assert!(answer.values.iter().all(Option::is_some));
        let star = table.answer(&["", "", "13", "52", "2012-09-06T12:00Z", "HIP 32349", ""], &Fast, &air).unwrap();
        assert_eq!(star.to_fields()[7], "");
        assert_eq!(star.values[9], Some(-1.44));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let table = EphemerisTable::from_header(&HEADER).unwrap();
        let air = Conditions::default();
        for (row, word) in [
            (["", "", "13", "99", "2012-09-06T12:00Z", "sun", ""], "latitude"),
            (["", "", "13", "NaN", "2012-09-06T12:00Z", "sun", ""], "latitude"),
            (["", "", "x", "52", "2012-09-06T12:00Z", "sun", ""], "longitude_deg"),
            (["", "", "13", "52", "soon", "sun", ""], "ISO 8601"),
            (["", "", "13", "52", "2012-09-06T12:00Z", "vulcan", ""], "vulcan"),
            (["", "1e99", "13", "52", "2012-09-06T12:00Z", "sun", ""], "height"),
        ] {
            let e = table.answer(&row, &Fast, &air).unwrap_err().to_string();
            assert!(e.contains(word), "{e}");
        }
        assert!(table.answer::<&str>(&[], &Fast, &air).is_err());
        assert!(EphemerisTable::from_header(&["body", "latitude_deg", "longitude_deg", "jd_tt"]).is_err());
    }
}
