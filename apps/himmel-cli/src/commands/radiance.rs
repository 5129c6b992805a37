//! `himmel radiance`: what a line of sight shows, as numbers.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use himmel::{Gpu, Scene};
use himmel_air::AirError;
use himmel_air::medium::Medium;
use himmel_air::moments::Quality;
use himmel_air::query::{Answer, OneWavelength, Question, Solver};
use himmel_air::reference::{Effort, for_each_parallel};

use super::scene::key_and_value;
use super::table::read_table;
use crate::progress::Progress;
use crate::{Failure, out, print_bytes};

/// Arguments of `himmel radiance`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel radiance --preset bruneton2017 --sun-zenith 60 --view-zenith 45 --azimuth 90
  himmel radiance --preset mars-reference --input q.csv --output a.csv --target-error 0.01
  himmel radiance --solver gpu --preset bruneton2017 --input q.csv --output a.csv
  himmel radiance --solver moments --transmittance --set ground.albedo=0.3 --input q.csv --output a.csv

A table of questions has one header line and, in any order, the columns altitude_m, sun_zenith_deg, view_zenith_deg,
azimuth_deg (view minus Sun) and wavelength_nm (360 to 830); other columns are passed through. The answer adds radiance_per_sr
(per unit spectral irradiance of the Sun above the air, its disc excluded), for the reference standard_error_per_sr, and
transmittance where asked for. The Sun is a parallel beam; nothing is refracted. A row that makes no sense refuses the table.

reference: Monte Carlo, all orders. The random numbers of a row depend on the seed and the row's place alone.
moments:   the table of moments in f64, without noise; seconds for each wavelength, within about a percent in clear air.
gpu:       the renderer's own tables and shaders on the adapter at hand, four wavelengths at a time; what a pixel shows.")]
pub struct Args {
    /// Atmosphere: earth, bruneton2017, mars-reference … (`himmel info` lists them), or a .toml file.
    #[arg(long, value_name = "NAME", default_value = "earth")]
    preset: String,
    /// What answers: reference, moments or gpu.
    #[arg(long, value_name = "NAME", default_value = "reference", value_parser = solver_name)]
    solver: &'static str,
    /// Table of questions (CSV, or a JSON list of objects); - reads the standard input.
    #[arg(long, value_name = "FILE.csv")]
    input: Option<PathBuf>,
    /// Where the table with the answers goes; - or none is the standard output.
    #[arg(long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// One question: zenith angle of the Sun, degrees.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with = "input")]
    sun_zenith: Option<f64>,
    /// One question: zenith angle of the line of sight, degrees.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with = "input")]
    view_zenith: Option<f64>,
    /// One question: azimuth of the line of sight minus that of the Sun, degrees; 0 unless given.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with = "input")]
    azimuth: Option<f64>,
    /// One question: height above the ground, m; 0 unless given.
    #[arg(long, value_name = "M", allow_hyphen_values = true, conflicts_with = "input")]
    altitude: Option<f64>,
    /// One question: wavelength, nm; 550 unless given.
    #[arg(long, value_name = "L", allow_hyphen_values = true, conflicts_with = "input")]
    wavelength: Option<f64>,
    /// Add the transmittance from the observer along the line of sight to space; 0 where the ground is in the way.
    #[arg(long)]
    transmittance: bool,
    /// Paths for each question, at least 32 [default: 4096; with --target-error, 1024 to begin with]. Reference only.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    samples: Option<u64>,
    /// Double the paths until the standard error is this share of the value, or 4,194,304 are reached. Reference only.
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    target_error: Option<f64>,
    /// Seed of the random numbers: the same one gives the same bytes. Reference only.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// GPU adapter whose name contains this, such as llvmpipe. With --solver gpu.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// A parameter of the air or the ground, such as air.aerosols=2 or ground.albedo=0.3; may be given several times.
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    /// Print JSON: a list of objects for a table.
    #[arg(long)]
    json: bool,
}

fn solver_name(text: &str) -> Result<&'static str, String> {
    ["reference", "moments", "gpu"]
        .into_iter()
        .find(|name| *name == text)
        .ok_or_else(|| "the solvers are reference, moments and gpu".into())
}

impl Args {
    fn solver(&self) -> Result<Solver, Failure> {
        if self.solver != "reference" {
            if self.samples.is_some() || self.target_error.is_some() {
                return Err(Failure::usage(
                    "moments and gpu are not left to chance: --samples and --target-error go with --solver reference",
                ));
            }
            return Ok(Solver::Moments(Quality::default()));
        }
        let samples = self.samples.unwrap_or(if self.target_error.is_some() { 1024 } else { 4096 });
        let effort = Effort { samples, target_relative_error: self.target_error, seed: self.seed, ..Effort::default() };
        effort.check().map_err(|error| Failure::usage(error.to_string()))?;
        Ok(Solver::Reference(effort))
    }

    /// The scene that --set makes.
    fn scene(&self) -> Result<Scene, Failure> {
        let mut scene = Scene::default();
        for pair in &self.set {
            let (key, value) = key_and_value(pair)?;
            scene.set(key, value)?;
            let table = key.rsplit_once('.').map_or("", |(table, _)| table);
            let of_gpu = key == "air.steps" || key == "air.quality";
            let unknown = !["air", "ground"].contains(&table) || key.starts_with("air.wavelength_");
            if unknown || (of_gpu && self.solver != "gpu") {
                return Err(Failure::usage(format!(
                    "{key} does not change what this solver computes; --set takes air.enabled, air.molecules, air.aerosols, air.absorbers, ground.enabled and ground.albedo here, and with --solver gpu air.quality and air.steps"
                )));
            }
        }
        Ok(scene)
    }

    /// The medium with --set applied.
    fn medium(&self) -> Result<Medium, Failure> {
        let scene = self.scene()?;
        Ok(super::optics::preset(&self.preset)?.medium_with(&scene.air, &scene.ground))
    }

    /// Answers by the renderer.
    fn on_gpu(&self, questions: &[Question], quiet: bool) -> Result<(Vec<Row>, String), Failure> {
        let scene = self.scene()?;
        let preset = super::optics::preset(&self.preset)?;
        let gpu = Gpu::open(self.adapter.as_deref())?;
        let progress = Progress::new("radiance", quiet);
        let go_on = &mut |share| progress.update(share);
        let seen = himmel::rays_on_gpu(&gpu, &preset, &scene.air, &scene.ground, questions, go_on)?;
        let row = |seen: himmel::Seen| {
            let answer = Answer {
                radiance_per_sr: seen.radiance_per_sr,
                standard_error_per_sr: None,
                orders_per_sr: Vec::new(),
                samples: 0,
            };
            (answer, self.transmittance.then_some(seen.transmittance))
        };
        Ok((seen.into_iter().map(row).collect(), gpu.report().to_string()))
    }
}

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let solver = args.solver()?;
    if args.adapter.is_some() && args.solver != "gpu" {
        return Err(Failure::usage("--adapter goes with --solver gpu"));
    }
    let to_file = args.output.as_deref().filter(|path| *path != Path::new("-"));
    match &args.input {
        Some(input) => {
            if let Some(path) = to_file {
                himmel::picture::check_writable(path)?;
            }
            table(args, solver, input, to_file, quiet)
        }
        None if args.output.is_some() => {
            Err(Failure::usage("--output goes with --input; for one question, send the output where you want it"))
        }
        None => one(args, &solver, quiet),
    }
}

/// One question, for people.
fn one(args: &Args, solver: &Solver, quiet: bool) -> Result<(), Failure> {
    let (Some(sun), Some(view)) = (args.sun_zenith, args.view_zenith) else {
        return Err(Failure::usage(
            "give a table with --input, or one question with --sun-zenith and --view-zenith (and --azimuth, --altitude, --wavelength)",
        ));
    };
    let (altitude, azimuth, wavelength) =
        (args.altitude.unwrap_or(0.0), args.azimuth.unwrap_or(0.0), args.wavelength.unwrap_or(550.0));
    let question =
        Question::new([altitude, sun, view, azimuth, wavelength]).map_err(|e| Failure::usage(e.to_string()))?;
    let started;
    let (mut air, mut adapter) = (None, None);
    let (answer, transmittance) = if args.solver == "gpu" {
        started = Instant::now();
        let (rows, name) = args.on_gpu(&[question], quiet)?;
        adapter = Some(name);
        rows.into_iter().next().ok_or_else(|| Failure::failed("no answer"))?
    } else {
        let prepared = OneWavelength::new(Arc::new(args.medium()?), question.wavelength_nm, solver)?;
        started = Instant::now();
        let answer = prepared.answer(&question, 0)?;
        let transmittance = if args.transmittance { Some(prepared.transmittance(&question)?) } else { None };
        air = Some(prepared);
        (answer, transmittance)
    };
    let seconds = started.elapsed().as_secs_f64();
    if args.json {
        let mut object = serde_json::json!({
            "preset": args.preset,
            "solver": args.solver,
            "radiance_per_sr": answer.radiance_per_sr,
        });
        for (name, value) in Question::COLUMNS.iter().zip([altitude, sun, view, azimuth, wavelength]) {
            object[*name] = value.into();
        }
        if let Some(error) = answer.standard_error_per_sr {
            object["standard_error_per_sr"] = error.into();
            object["orders_per_sr"] = answer.orders_per_sr.clone().into();
            object["samples"] = answer.samples.into();
            object["seed"] = args.seed.into();
        }
        if let Some(transmittance) = transmittance {
            object["transmittance"] = transmittance.into();
        }
        out!("{}", serde_json::to_string_pretty(&object).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    let value = answer.radiance_per_sr;
    out!("radiance        {value:.6e} /sr at {wavelength} nm, per unit irradiance of the Sun above the air");
    if let Some(error) = answer.standard_error_per_sr {
        out!("standard error  {error:.1e} /sr ({:.2} %)", 100.0 * answer.relative_error());
    }
    if let Some(transmittance) = transmittance {
        out!("transmittance   {transmittance:.6}");
    }
    for (index, order) in answer.orders_per_sr.iter().enumerate().filter(|(_, order)| **order > 1e-4 * value) {
        let name = format!("order {}", index + 1);
        out!("{name:<15} {order:.4e} /sr ({:.2} %)", 100.0 * order / value);
    }
    if answer.samples > 0 {
        out!("paths           {} in {seconds:.2} s, {:.0} a second", answer.samples, answer.samples as f64 / seconds);
    }
    match (&air, adapter) {
        (_, Some(adapter)) => out!("solver          gpu, {adapter}"),
        (Some(air), None) => match air.moments() {
            Some(moments) => {
                out!("solver          moments, {} orders and their tail", moments.orders());
                warn_of_slow_orders(air);
            }
            None => out!("solver          reference, seed {}", args.seed),
        },
        (None, None) => {}
    }
    Ok(())
}

/// Moments whose orders ran out say so.
fn warn_of_slow_orders(air: &OneWavelength) -> bool {
    let late = air.moments().filter(|moments| moments.last_change() > Quality::default().tolerance);
    if let Some(moments) = late {
        eprintln!(
            "himmel: after {} orders of scattering the light still changes by {:.1} %: trust the reference here",
            moments.orders(),
            100.0 * moments.last_change()
        );
    }
    late.is_some()
}

/// A table of questions as it was read.
struct Questions {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    questions: Vec<Question>,
}

impl Questions {
    /// Reads and checks every row before any work is done; `file` stands in error messages.
    fn read(bytes: &[u8], file: &str) -> Result<Self, Failure> {
        let fail = |text: String| Failure::failed(format!("{file}: {text}"));
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut reader = csv::ReaderBuilder::new().flexible(true).has_headers(false).from_reader(bytes);
        let mut records = reader.byte_records();
        let text = |record: &csv::ByteRecord, line: u64| -> Result<Vec<String>, Failure> {
            let field = |field: &[u8]| String::from_utf8(field.to_vec());
            record
                .iter()
                .map(field)
                .collect::<Result<_, _>>()
                .map_err(|_| fail(format!("line {line}: this is no text (UTF-8)")))
        };
        let header = match records.next() {
            Some(record) => text(&record.map_err(|e| fail(e.to_string()))?, 1)?,
            None => {
                return Err(fail(format!("it is empty; it needs a header line with {}", Question::COLUMNS.join(", "))));
            }
        };
        let header: Vec<String> = header.iter().map(|name| name.trim().to_owned()).collect();
        let missing: Vec<&str> =
            Question::COLUMNS.into_iter().filter(|name| !header.iter().any(|known| known == name)).collect();
        if !missing.is_empty() {
            let s = if missing.len() == 1 { "" } else { "s" };
            return Err(fail(format!("line 1: missing column{s} {}", missing.join(", "))));
        }
        if let Some(twice) = (1..header.len()).find(|i| header[..*i].contains(&header[*i])) {
            return Err(fail(format!("line 1: column {} stands twice", himmel::params::shorten(&header[twice]))));
        }
        let place = Question::COLUMNS.map(|name| header.iter().position(|known| known == name).unwrap_or(0));
        let (mut rows, mut questions) = (Vec::new(), Vec::new());
        for record in records {
            let record = record.map_err(|e| fail(e.to_string()))?;
            let line = record.position().map_or(0, csv::Position::line);
            let (got, wanted) = (record.len(), header.len());
            if got != wanted {
                let why = if got < wanted {
                    "is the line cut off?"
                } else {
                    "decimals take a point, texts with commas take quotes"
                };
                return Err(fail(format!("line {line}: {got} fields, the header has {wanted} ({why})")));
            }
            let row = text(&record, line)?;
            let mut values = [0.0; 5];
            for ((value, column), name) in values.iter_mut().zip(place).zip(Question::COLUMNS) {
                let field = row[column].trim();
                *value = field.parse().map_err(|_| {
                    let got = himmel::params::shorten(field);
                    fail(format!("line {line}: {name} takes a number, got \"{got}\""))
                })?;
            }
            questions.push(Question::new(values).map_err(|e| fail(format!("line {line}: {e}")))?);
            rows.push(row);
        }
        Ok(Self { header, rows, questions })
    }
}

/// An answer and the transmittance, if it was asked for.
type Row = (Answer, Option<f64>);

/// What the threads share.
struct Work {
    medium: Arc<Medium>,
    solver: Solver,
    questions: Vec<Question>,
    /// For each question, which of the wavelengths is its.
    group: Vec<usize>,
    /// A place for each wavelength, filled by whoever needs it first.
    wavelengths: Vec<(f64, OnceLock<Result<OneWavelength, AirError>>)>,
    transmittance: bool,
}

impl Work {
    fn new(medium: Medium, solver: Solver, questions: Vec<Question>, transmittance: bool) -> Self {
        let mut sorted: Vec<f64> = questions.iter().map(|question| question.wavelength_nm).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let group = questions.iter().map(|q| sorted.partition_point(|nm| *nm < q.wavelength_nm)).collect();
        let wavelengths = sorted.into_iter().map(|nm| (nm, OnceLock::new())).collect();
        Self { medium: Arc::new(medium), solver, questions, group, wavelengths, transmittance }
    }

    fn answer(&self, index: usize) -> Result<Row, AirError> {
        let (wavelength_nm, cell) = &self.wavelengths[self.group[index]];
        let air = cell.get_or_init(|| OneWavelength::new(Arc::clone(&self.medium), *wavelength_nm, &self.solver));
        let air = air.as_ref().map_err(Clone::clone)?;
        let question = &self.questions[index];
        let answer = air.answer(question, index as u64)?;
        Ok((answer, if self.transmittance { Some(air.transmittance(question)?) } else { None }))
    }
}

/// A whole table.
fn table(args: &Args, solver: Solver, input: &Path, output: Option<&Path>, quiet: bool) -> Result<(), Failure> {
    let started = Instant::now();
    let medium = args.medium()?;
    let Questions { header, rows, questions } = Questions::read(&read_table(input)?, &input.display().to_string())?;
    let count = questions.len();
    if args.solver == "gpu" {
        let (answers, adapter) = args.on_gpu(&questions, quiet)?;
        let answers: Vec<Option<Row>> = answers.into_iter().map(Some).collect();
        write_answers(args, &header, &rows, &answers, output)?;
        if !quiet {
            eprintln!("{count} rows in {:.2} s; gpu, {adapter}", started.elapsed().as_secs_f64());
        }
        return Ok(());
    }
    let work = Arc::new(Work::new(medium, solver, questions, args.transmittance));
    let progress = Progress::new("radiance", quiet);
    // On a thread of its own, so that Ctrl-C need not wait for rows that take long: they end with the program.
    let (sender, receiver) = channel();
    {
        let work = Arc::clone(&work);
        std::thread::spawn(move || {
            for_each_parallel(count, |index| work.answer(index), |index, row| sender.send((index, row)).is_ok());
        });
    }
    let mut answers: Vec<Option<Row>> = vec![None; count];
    let (mut finished, mut samples) = (0, 0);
    while progress.update(finished as f64 / count.max(1) as f64) {
        match receiver.recv_timeout(Duration::from_millis(50)) {
            Ok((index, row)) => {
                let row = row?;
                samples += row.0.samples;
                answers[index] = Some(row);
                finished += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    drop(progress);
    if finished == 0 && count > 0 {
        return Err(Failure::failed("stopped before a row was finished; nothing is written"));
    }
    write_answers(args, &header, &rows, &answers, output)?;
    if !quiet {
        let seconds = started.elapsed().as_secs_f64();
        let worst = answers.iter().flatten().map(|row| row.0.relative_error()).fold(0.0, f64::max);
        report(args, finished, samples, seconds, worst);
        let mut prepared = work.wavelengths.iter().filter_map(|(_, cell)| cell.get()?.as_ref().ok());
        prepared.any(warn_of_slow_orders);
        if let Some(target) = args.target_error {
            let late = answers.iter().flatten().filter(|row| row.0.relative_error() > target).count();
            if late > 0 {
                eprintln!(
                    "himmel: {late} of {finished} rows reached {} paths before the target error",
                    Effort::default().most_samples
                );
            }
        }
    }
    if finished < count {
        return Err(Failure::failed(format!("stopped: {finished} of {count} rows are answered and written")));
    }
    Ok(())
}

fn write_answers(
    args: &Args,
    header: &[String],
    rows: &[Vec<String>],
    answers: &[Option<Row>],
    output: Option<&Path>,
) -> Result<(), Failure> {
    let bytes = if args.json { as_json(header, rows, answers)? } else { as_csv(args, header, rows, answers)? };
    match output {
        Some(path) => himmel::picture::save_bytes(&bytes, path)?,
        None => print_bytes(&bytes),
    }
    Ok(())
}

fn report(args: &Args, rows: usize, samples: u64, seconds: f64, worst: f64) {
    let s = if rows == 1 { "" } else { "s" };
    if args.solver == "moments" {
        eprintln!("{rows} row{s} in {seconds:.2} s; moments");
        return;
    }
    eprintln!(
        "{rows} row{s} in {seconds:.2} s: {samples} paths, {:.0} a second; reference, seed {}, largest relative error {:.2} %",
        samples as f64 / seconds,
        args.seed,
        100.0 * worst
    );
}

/// Columns that answers bring: they replace those of the same name.
const ANSWERS: [&str; 3] = ["radiance_per_sr", "standard_error_per_sr", "transmittance"];

fn kept(header: &[String]) -> Vec<usize> {
    (0..header.len()).filter(|i| !ANSWERS.contains(&header[*i].as_str())).collect()
}

/// Finished rows in the order of the questions, numbers with every digit.
fn as_csv(args: &Args, header: &[String], rows: &[Vec<String>], answers: &[Option<Row>]) -> Result<Vec<u8>, Failure> {
    let fail = |e: csv::Error| Failure::failed(e.to_string());
    let kept = kept(header);
    let mut written = csv::Writer::from_writer(Vec::new());
    let mut head: Vec<&str> = kept.iter().map(|i| header[*i].as_str()).collect();
    head.push(ANSWERS[0]);
    if args.solver == "reference" {
        head.push(ANSWERS[1]);
    }
    if args.transmittance {
        head.push(ANSWERS[2]);
    }
    written.write_record(&head).map_err(fail)?;
    for (row, answer) in rows.iter().zip(answers) {
        let Some((answer, transmittance)) = answer else { continue };
        let mut fields: Vec<String> = kept.iter().map(|i| row[*i].clone()).collect();
        let numbers = [Some(answer.radiance_per_sr), answer.standard_error_per_sr, *transmittance];
        // The shortest text that reads back as the same number.
        fields.extend(numbers.iter().flatten().map(|number| format!("{number:e}")));
        written.write_record(&fields).map_err(fail)?;
    }
    written.into_inner().map_err(|e| Failure::failed(e.to_string()))
}

/// The same as a list of objects; columns that are not ours stay text.
fn as_json(header: &[String], rows: &[Vec<String>], answers: &[Option<Row>]) -> Result<Vec<u8>, Failure> {
    let kept = kept(header);
    let mut objects = Vec::new();
    for (row, answer) in rows.iter().zip(answers) {
        let Some((answer, transmittance)) = answer else { continue };
        let mut object = serde_json::Map::new();
        for i in &kept {
            let number =
                row[*i].trim().parse::<f64>().ok().filter(|_| Question::COLUMNS.contains(&header[*i].as_str()));
            object.insert(header[*i].clone(), number.map_or_else(|| row[*i].clone().into(), Into::into));
        }
        let numbers = [Some(answer.radiance_per_sr), answer.standard_error_per_sr, *transmittance];
        for (name, number) in ANSWERS.iter().zip(numbers) {
            if let Some(number) = number {
                object.insert((*name).to_owned(), number.into());
            }
        }
        objects.push(object);
    }
    let mut bytes = serde_json::to_vec_pretty(&objects).map_err(|e| Failure::failed(e.to_string()))?;
    bytes.push(b'\n');
    Ok(bytes)
}
