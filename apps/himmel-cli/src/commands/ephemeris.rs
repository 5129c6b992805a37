//! `himmel ephemeris`

use std::path::{Path, PathBuf};

use himmel::parse_time;
use himmel::parts::astro::query::{Answer, Conditions, EphemerisTable, Target};
use himmel::parts::astro::{AirAtObserver, Instant, Place};

use super::level::Level;
use super::table::read_table;
use crate::{Failure, out, print_bytes};

/// Arguments of `himmel ephemeris`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel ephemeris moon --place Potsdam --time 2012-09-06T20:00
  himmel ephemeris \"HIP 32349\" --place Paranal --time 2024-01-15T03:00Z --json
  himmel ephemeris --input q.csv --output a.csv --level precise

A table of questions has one header line and, in any order, the columns body, latitude_deg, longitude_deg, height_m, and
time_utc or the pair jd_tt, jd_ut1 (which takes Delta T out of the question). Other columns are passed through. Rows that
cannot be answered are named on the error output (the first below the header is row 1) and keep empty answers; the exit code is then 1.")]
pub struct Args {
    /// sun, moon, mercury … neptune, pluto, or a star: Sirius, HIP 32349, HD 48915, alpha CMa.
    #[arg(value_name = "BODY", conflicts_with = "input", required_unless_present = "input")]
    body: Option<String>,
    /// City or site, or lat,lon[,height_m].
    #[arg(long, allow_hyphen_values = true, default_value = "Potsdam")]
    place: String,
    /// ISO 8601 with Z or an offset, bare and local to the place, or now.
    #[arg(long, allow_hyphen_values = true, default_value = "now")]
    time: String,
    /// Table of questions (CSV, or a JSON list of objects); - reads the standard input.
    #[arg(long, value_name = "FILE.csv")]
    input: Option<PathBuf>,
    /// Where the table with the answers goes; the standard output unless given.
    #[arg(long, value_name = "FILE.csv", requires = "input")]
    output: Option<PathBuf>,
    /// Ephemeris: series alone, or JPL DE440 (1850–2150, series outside).
    #[arg(long, value_enum, default_value_t = Level::Precise)]
    level: Level,
    /// Air pressure for refraction, hPa; 0 for none.
    #[arg(long, value_name = "HPA", default_value_t = 1010.0)]
    pressure: f64,
    /// Air temperature for refraction, °C.
    #[arg(long, value_name = "C", default_value_t = 10.0, allow_hyphen_values = true)]
    temperature: f64,
    /// Take the pole's motion into account where it is known (since 1962).
    #[arg(long)]
    polar_motion: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let air =
        AirAtObserver::new(args.pressure, args.temperature + 273.15).map_err(|e| Failure::usage(e.to_string()))?;
    let conditions = Conditions { air, polar_motion: args.polar_motion };
    if let Some(path) = &args.output {
        if args.input.is_none() {
            return Err(Failure::usage("--output goes with --input; for one body, send the output where you want it"));
        }
        himmel::picture::check_writable(path)?;
    }
    match (&args.input, &args.body) {
        (Some(input), _) => table(args, input, &conditions),
        (None, Some(body)) => one(args, body, &conditions),
        (None, None) => Err(Failure::usage("name a body, or a table with --input")),
    }
}

/// One body, now or then.
fn one(args: &Args, body: &str, conditions: &Conditions) -> Result<(), Failure> {
    let usage = |e: himmel::parts::astro::AstroError| Failure::usage(e.to_string());
    let target = Target::parse(body).map_err(usage)?;
    let site = himmel::Observer::at(&args.place)?;
    let time = parse_time(&args.time, &site.time_zone)?;
    let seconds = time.as_second() as f64 + f64::from(time.subsec_nanosecond()) * 1e-9;
    let instant = Instant::from_unix_seconds(seconds).map_err(usage)?;
    let place = Place::from_degrees(site.latitude_deg, site.longitude_deg, site.height_m).map_err(usage)?;
    let ephemeris = args.level.open()?;
    let observer = conditions.observer(ephemeris.as_ref(), &instant, &place).map_err(usage)?;
    let answer = Answer::of(&target, &observer, &conditions.air).map_err(usage)?;
    if args.json {
        let mut json = object(&answer);
        for (key, value) in [
            ("body", body.into()),
            ("place", site.name.into()),
            ("latitude_deg", site.latitude_deg.into()),
            ("longitude_deg", site.longitude_deg.into()),
            ("height_m", site.height_m.into()),
            ("time_utc", instant.to_iso_utc().into()),
            ("jd_tt", instant.tt().jd().into()),
            ("jd_ut1", instant.ut1().jd().into()),
        ] {
            json.insert(key.to_owned(), value);
        }
        out!("{}", serde_json::to_string_pretty(&json).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    out!("{body} from {} at {}", site.name, instant.to_iso_utc());
    for (name, value) in Answer::COLUMNS.iter().zip(answer.values) {
        if let Some(value) = value {
            out!("  {name:<32} {value:.6}");
        }
    }
    Ok(())
}

/// The answer by column name; null where there is none.
fn object(answer: &Answer) -> serde_json::Map<String, serde_json::Value> {
    Answer::COLUMNS.iter().zip(answer.values).map(|(name, v)| ((*name).to_owned(), v.into())).collect()
}

/// A whole table.
fn table(args: &Args, input: &Path, conditions: &Conditions) -> Result<(), Failure> {
    let bytes = read_table(input)?;
    let mut reader = csv::ReaderBuilder::new().flexible(true).has_headers(false).from_reader(bytes.as_slice());
    let text = |record: &csv::ByteRecord| -> Vec<String> {
        record.iter().map(|field| String::from_utf8_lossy(field).into_owned()).collect()
    };
    let mut records = reader.byte_records();
    let broken = |e: csv::Error| Failure::failed(format!("{}: {e}", input.display()));
    let header = match records.next() {
        Some(record) => text(&record.map_err(broken)?),
        None => return Err(Failure::failed(format!("{} is empty; it needs a header line", input.display()))),
    };
    let columns =
        EphemerisTable::from_header(&header).map_err(|e| Failure::failed(format!("{}: {e}", input.display())))?;
    // A column that the answer brings replaces one of the same name.
    let kept: Vec<usize> = (0..header.len()).filter(|i| !Answer::COLUMNS.contains(&header[*i].trim())).collect();
    let ephemeris = args.level.open()?;
    let mut written = csv::Writer::from_writer(Vec::new());
    let mut objects = Vec::new();
    let fail = |e: csv::Error| Failure::failed(e.to_string());
    let head: Vec<&str> = kept.iter().map(|i| header[*i].as_str()).chain(Answer::COLUMNS).collect();
    written.write_record(&head).map_err(fail)?;
    let mut bad = 0;
    for (index, record) in records.enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(e) => {
                eprintln!("himmel: row {}: {e}", index + 1);
                bad += 1;
                continue;
            }
        };
        let row = text(&record);
        let result = if row.len() > header.len() {
            let (got, wanted) = (row.len(), header.len());
            Err(format!("{got} fields, the header has {wanted} (decimals take a point, texts with commas take quotes)"))
        } else {
            columns.answer(&row, ephemeris.as_ref(), conditions).map_err(|e| e.to_string())
        };
        let answer = result.unwrap_or_else(|e| {
            eprintln!("himmel: row {}: {e}", index + 1);
            bad += 1;
            Answer::default()
        });
        if args.json {
            let mut json = object(&answer);
            for i in &kept {
                json.insert(header[*i].trim().to_owned(), row.get(*i).cloned().unwrap_or_default().into());
            }
            objects.push(json);
        } else {
            let fields = answer.to_fields();
            let passed = kept.iter().map(|i| row.get(*i).map_or("", String::as_str));
            written.write_record(passed.chain(fields.iter().map(String::as_str))).map_err(fail)?;
        }
    }
    let bytes = if args.json {
        serde_json::to_vec_pretty(&objects).map_err(|e| Failure::failed(e.to_string()))?
    } else {
        written.into_inner().map_err(|e| Failure::failed(e.to_string()))?
    };
    match &args.output {
        Some(path) => {
            himmel::picture::save_bytes(&bytes, path)?;
        }
        None => print_bytes(&bytes),
    }
    match bad {
        0 => Ok(()),
        1 => Err(Failure::failed("1 row could not be answered; the others are")),
        n => Err(Failure::failed(format!("{n} rows could not be answered; the others are"))),
    }
}
