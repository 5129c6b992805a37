//! `himmel almanac`

use himmel::parts::astro::query::{Almanac, almanac};
use himmel::parts::astro::time::DeltaTModel;
use himmel::parts::astro::{AstroError, Instant, Place};
use jiff::civil::Date;
use jiff::tz::TimeZone;
use serde_json::{Value, json};

use super::level::Level;
use crate::progress::Progress;
use crate::{Failure, out};

/// Arguments of `himmel almanac`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel almanac --place Potsdam --date 2012-09-06
  himmel almanac --place 78.22,15.63 --from 2024-10-20 --to 2024-11-02 --json

A day runs from midnight to midnight of the place's own clock (with --utc: of UTC); each moment is the first of its kind in it.
Sunrise and sunset: the Sun's centre at -50' without air. Twilights: at -6, -12, -18 degrees. Moon: its upper limb at -34'.")]
pub struct Args {
    /// City or site, or lat,lon[,height_m].
    #[arg(long, allow_hyphen_values = true, default_value = "Potsdam")]
    place: String,
    /// The day, such as 2012-09-06; today unless given.
    #[arg(long, value_name = "DATE", allow_hyphen_values = true, conflicts_with_all = ["from", "to"])]
    date: Option<String>,
    /// First day of a span.
    #[arg(long, value_name = "DATE", allow_hyphen_values = true, requires = "to")]
    from: Option<String>,
    /// Last day of a span.
    #[arg(long, value_name = "DATE", allow_hyphen_values = true, requires = "from")]
    to: Option<String>,
    /// Days of UTC instead of the place's clock.
    #[arg(long)]
    utc: bool,
    /// Ephemeris: series alone, or JPL DE440 (1850–2150, series outside).
    #[arg(long, value_enum, default_value_t = Level::Precise)]
    level: Level,
    /// Print JSON: an object for a day, a list for a span.
    #[arg(long)]
    json: bool,
}

/// The longest span, days: a century takes about a minute.
const MOST_DAYS: i32 = 40_000;

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let site = himmel::Observer::at(&args.place)?;
    let zone = if args.utc { TimeZone::UTC } else { site.time_zone.clone() };
    let place = Place::from_degrees(site.latitude_deg, site.longitude_deg, site.height_m).map_err(usage)?;
    let (first, last) = match (&args.date, &args.from, &args.to) {
        (_, Some(from), Some(to)) => (date(from)?, date(to)?),
        (Some(day), ..) => (date(day)?, date(day)?),
        _ => {
            let today = zone.to_datetime(jiff::Timestamp::now()).date();
            (today, today)
        }
    };
    if last < first {
        return Err(Failure::usage(format!("--to ({last}) lies before --from ({first})")));
    }
    let ephemeris = args.level.open()?;
    let progress = Progress::new("computing", quiet);
    let whole = f64::from((last - first).get_days()) + 1.0;
    if whole > f64::from(MOST_DAYS) {
        return Err(Failure::usage(format!("at most {MOST_DAYS} days at once, got {whole}")));
    }
    let (mut days, mut day) = (Vec::new(), first);
    while day <= last {
        let next = day_after(day)?;
        let span = (midnight(day, &zone)?, midnight(next, &zone)?);
        if span.1.ut1().jd() <= span.0.ut1().jd() {
            return Err(Failure::usage(format!("{day} does not exist in {}: its calendar skipped it", site.name)));
        }
        let found = almanac(ephemeris.as_ref(), &place, span, DeltaTModel::Standard).map_err(usage)?;
        if args.json {
            days.push(object(day, &site, &zone, &found));
        } else {
            print(day, &site, &zone, &found);
            days.push(Value::Null);
        }
        day = next;
        if !progress.update(days.len() as f64 / whole) {
            return Err(Failure::failed("stopped"));
        }
    }
    drop(progress);
    if args.json {
        let all = if args.from.is_none() { days.swap_remove(0) } else { Value::Array(days) };
        out!("{}", serde_json::to_string_pretty(&all).map_err(|e| Failure::failed(e.to_string()))?);
    }
    Ok(())
}

fn usage(e: AstroError) -> Failure {
    Failure::usage(e.to_string())
}

/// Reads a bare date.
pub fn date(text: &str) -> Result<Date, Failure> {
    text.trim().parse().map_err(|_| Failure::usage(format!("\"{text}\" is no date; write 2012-09-06")))
}

/// The next day.
pub fn day_after(day: Date) -> Result<Date, Failure> {
    day.tomorrow().map_err(|_| Failure::usage(format!("the calendar ends with {day}; choose an earlier day")))
}

/// The instant at which a day begins.
pub fn midnight(day: Date, zone: &TimeZone) -> Result<Instant, Failure> {
    let start =
        zone.to_timestamp(day.to_datetime(jiff::civil::Time::midnight())).map_err(|e| Failure::usage(e.to_string()))?;
    Instant::from_unix_seconds(start.as_second() as f64).map_err(usage)
}

fn moment(instant: &Instant) -> Value {
    json!({ "utc": instant.to_iso_utc(), "jd_ut1": instant.ut1().jd(), "jd_tt": instant.tt().jd() })
}

fn object(day: Date, site: &himmel::Observer, zone: &TimeZone, found: &Almanac) -> Value {
    let mut json = json!({
        "place": site.name,
        "latitude_deg": site.latitude_deg,
        "longitude_deg": site.longitude_deg,
        "height_m": site.height_m,
        "date": day.to_string(),
        "time_zone": zone.iana_name(),
        "sun": found.sun.sun_words(),
        "moon": found.moon.moon_words(),
        "moon_phases": found.phases.iter().map(|p| {
            let mut phase = moment(&p.instant);
            phase["phase"] = p.phase.name().into();
            phase
        }).collect::<Vec<_>>(),
    });
    for (name, twilight) in ["civil_twilight", "nautical_twilight", "astronomical_twilight"].iter().zip(found.twilights)
    {
        json[*name] = twilight.twilight_words().into();
    }
    for event in &found.events {
        json[event.name] = event.instant.as_ref().map_or(Value::Null, moment);
    }
    json
}

fn print(day: Date, site: &himmel::Observer, zone: &TimeZone, found: &Almanac) {
    out!("{day} {} (Sun: {}; Moon: {})", site.name, found.sun.sun_words(), found.moon.moon_words());
    for event in &found.events {
        let when = event.instant.as_ref().map_or_else(
            || "-".to_owned(),
            |instant| {
                let local = jiff::Timestamp::from_millisecond((instant.unix_seconds() * 1e3).round() as i64)
                    .map(|t| zone.to_datetime(t).strftime("%H:%M:%S").to_string());
                format!("{}   {}", local.unwrap_or_default(), instant.to_iso_utc())
            },
        );
        out!("  {:<20} {when}", event.name.replace('_', " "));
    }
    for phase in &found.phases {
        out!("  {:<20} {}", phase.phase.name(), phase.instant.to_iso_utc());
    }
}
