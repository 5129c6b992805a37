//! `himmel eclipses`

use himmel::parts::astro::events::{
    LunarEclipse, ShadowConvention, SolarEclipse, SolarMoment, lunar_eclipses, solar_eclipses,
};
use himmel::parts::astro::time::{DeltaTModel, JulianDateTt};
use himmel::parts::astro::{AstroError, Instant, Place};
use jiff::tz::TimeZone;
use serde_json::{Value, json};

use super::almanac::{date, day_after, midnight};
use super::level::Level;
use crate::progress::Progress;
use crate::{Failure, out};

/// Arguments of `himmel eclipses`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel eclipses lunar --from 1950-01-01 --to 2050-12-31 --json
  himmel eclipses solar --place 48.7758,9.1829,245 --from 1999-01-01 --to 1999-12-31

Dates are days of UTC, the last one included. Contacts in JSON are Julian dates TT, null where a phase is not reached. Solar eclipses are
those of which the place sees some part.")]
pub struct Args {
    /// Of the Moon, or of the Sun as a place sees it.
    #[arg(value_enum)]
    kind: Kind,
    /// First day.
    #[arg(long, value_name = "DATE", allow_hyphen_values = true)]
    from: String,
    /// Last day.
    #[arg(long, value_name = "DATE", allow_hyphen_values = true)]
    to: String,
    /// City or site, or lat,lon[,height_m]; solar eclipses need it.
    #[arg(long, allow_hyphen_values = true)]
    place: Option<String>,
    /// How the Earth's shadow is enlarged (lunar).
    #[arg(long, value_enum, default_value_t = Shadow::Danjon)]
    shadow: Shadow,
    /// Ephemeris: series alone, or JPL DE440 (1850–2150, series outside).
    #[arg(long, value_enum, default_value_t = Level::Precise)]
    level: Level,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    Lunar,
    Solar,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Shadow {
    /// 1.01 times the Moon's parallax.
    Danjon,
    /// 1.02 times the whole.
    Chauvenet,
    /// The bare cone of the equatorial radius.
    Geometric,
    /// The bare cone of the mean radius, as Müller's thesis has it.
    Thesis,
}

/// Ten years between looks at the clock: half a second for solar eclipses.
const PIECE_DAYS: f64 = 3652.5;

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let (first, last) = (date(&args.from)?, date(&args.to)?);
    if last < first {
        return Err(Failure::usage(format!("--to ({last}) lies before --from ({first})")));
    }
    let end = day_after(last)?;
    let (start, stop) = (midnight(first, &TimeZone::UTC)?.tt(), midnight(end, &TimeZone::UTC)?.tt());
    let ephemeris = args.level.open()?;
    let convention = match args.shadow {
        Shadow::Danjon => ShadowConvention::Danjon,
        Shadow::Chauvenet => ShadowConvention::Chauvenet,
        Shadow::Geometric => ShadowConvention::Geometric,
        Shadow::Thesis => ShadowConvention::Thesis,
    };
    let place = match (args.kind, &args.place) {
        (Kind::Solar, None) => {
            return Err(Failure::usage("solar eclipses need a place: --place Stuttgart, or --place 48.78,9.18,245"));
        }
        (_, Some(place)) => {
            let site = himmel::Observer::at(place)?;
            Place::from_degrees(site.latitude_deg, site.longitude_deg, site.height_m).map_err(usage)?
        }
        (Kind::Lunar, None) => Place::GREENWICH_EQUATOR,
    };
    // Both ends must lie within the ephemeris before years of work begin.
    for end in [start, stop] {
        ephemeris.earth_and_moon(end.to_tdb()).map_err(usage)?;
    }
    let progress = Progress::new("searching", quiet);
    let mut list: Vec<Value> = Vec::new();
    let pieces = ((stop.jd() - start.jd()) / PIECE_DAYS).ceil().max(1.0);
    let at = |i: f64| JulianDateTt::new(start.jd() + (stop.jd() - start.jd()) * i / pieces).map_err(usage);
    for i in 0..pieces as u32 {
        let span = (at(f64::from(i))?, at(f64::from(i + 1))?);
        match args.kind {
            Kind::Lunar => {
                list.extend(lunar_eclipses(ephemeris.as_ref(), span, convention).map_err(usage)?.iter().map(lunar));
            }
            Kind::Solar => {
                let found = solar_eclipses(ephemeris.as_ref(), &place, span, DeltaTModel::Standard).map_err(usage)?;
                list.extend(found.iter().map(solar));
            }
        }
        if !progress.update(f64::from(i + 1) / pieces) {
            return Err(Failure::failed("stopped"));
        }
    }
    drop(progress);
    if args.json {
        out!("{}", serde_json::to_string_pretty(&list).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    for eclipse in &list {
        let field = |key: &str| eclipse[key].as_str().unwrap_or("-").to_owned();
        match args.kind {
            Kind::Lunar => out!(
                "{}  {:<9}  umbral {:>7.4}  penumbral {:.4}",
                field("greatest_utc"),
                field("type"),
                eclipse["umbral_magnitude"].as_f64().unwrap_or(f64::NAN),
                eclipse["penumbral_magnitude"].as_f64().unwrap_or(f64::NAN)
            ),
            Kind::Solar => {
                out!(
                    "{}  {:<7}  magnitude {:.4}  obscuration {:.4}  Sun at {:.1}°{}",
                    field("max_utc"),
                    field("type"),
                    eclipse["magnitude"].as_f64().unwrap_or(f64::NAN),
                    eclipse["obscuration"].as_f64().unwrap_or(f64::NAN),
                    eclipse["sun_altitude_max_deg"].as_f64().unwrap_or(f64::NAN),
                    // The numbers are those of the geometric maximum, seen or not.
                    if eclipse["sun_altitude_max_deg"].as_f64().is_some_and(|h| h < -0.8333) {
                        ", below the horizon"
                    } else {
                        ""
                    }
                );
                for contact in ["c1", "c2", "c3", "c4"] {
                    out!("  {contact}  {}", field(&format!("{contact}_utc")));
                }
            }
        }
    }
    if list.is_empty() {
        out!("none");
    }
    Ok(())
}

fn usage(e: AstroError) -> Failure {
    Failure::usage(e.to_string())
}

fn lunar(e: &LunarEclipse) -> Value {
    let jd = |t: Option<JulianDateTt>| t.map(JulianDateTt::jd);
    json!({
        "greatest_jd_tt": e.greatest.jd(),
        "greatest_utc": Instant::from_tt(e.greatest, DeltaTModel::Standard).to_iso_utc(),
        "type": e.kind.name(),
        "umbral_magnitude": e.umbral_magnitude,
        "penumbral_magnitude": e.penumbral_magnitude,
        "p1": jd(e.p1), "u1": jd(e.u1), "u2": jd(e.u2), "u3": jd(e.u3), "u4": jd(e.u4), "p4": jd(e.p4),
    })
}

fn solar(e: &SolarEclipse) -> Value {
    let mut json = json!({
        "max_jd_tt": e.greatest.instant.tt().jd(),
        "max_utc": e.greatest.instant.to_iso_utc(),
        "type": e.kind.name(),
        "magnitude": e.magnitude,
        "obscuration": e.obscuration,
        "sun_altitude_max_deg": e.greatest.sun_altitude_rad.to_degrees(),
        "sun_azimuth_max_deg": e.greatest.sun_azimuth_rad.to_degrees(),
    });
    let contacts: [(&str, Option<SolarMoment>); 4] =
        [("c1", Some(e.c1)), ("c2", e.c2), ("c3", e.c3), ("c4", Some(e.c4))];
    for (name, contact) in contacts {
        json[name] = contact.map(|m| m.instant.tt().jd()).into();
        json[format!("{name}_utc")] = contact.map(|m| m.instant.to_iso_utc()).into();
        json[format!("sun_altitude_{name}_deg")] = contact.map(|m| m.sun_altitude_rad.to_degrees()).into();
    }
    json
}
