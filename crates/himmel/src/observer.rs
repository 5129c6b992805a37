//! Where one stands.

use jiff::tz::TimeZone;

use crate::error::Result;
use crate::place::NamedPlace;

/// A place on the planet with its clock.
///
/// ```
/// let potsdam = himmel::Observer::at("Potsdam")?;
/// assert_eq!(potsdam.time_zone.iana_name(), Some("Europe/Berlin"));
/// let anywhere = himmel::Observer::at("-24.6272,-70.4042,2635")?;
/// assert_eq!(anywhere.height_m, 2635.0);
/// # Ok::<(), himmel::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Observer {
    /// What it is called: `Potsdam (DE)`, or its coordinates.
    pub name: String,
    /// Geodetic latitude, north positive, −90..=90.
    pub latitude_deg: f64,
    /// Longitude, east positive, −180..=180.
    pub longitude_deg: f64,
    /// Height of the ground above the sea, m.
    pub height_m: f64,
    /// The zone that bare times are read in.
    pub time_zone: TimeZone,
}

impl Observer {
    /// A city or site by name, or `lat,lon[,height_m]` in degrees.
    pub fn at(text: &str) -> Result<Self> {
        let NamedPlace { name, latitude_deg, longitude_deg, height_m, time_zone } = text.parse::<NamedPlace>()?;
        // A zone that the bundled tzdb does not know is as good as its nautical time.
        let time_zone = TimeZone::get(&time_zone).unwrap_or_else(|_| {
            let hours = (longitude_deg / 15.0).round() as i8;
            TimeZone::fixed(jiff::tz::offset(hours.clamp(-12, 12)))
        });
        Ok(Self { name, latitude_deg, longitude_deg, height_m, time_zone })
    }
}
