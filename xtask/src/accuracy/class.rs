//! Questions of one kind, and the tracer's answers to them, kept in files: tracing takes nearly all of the time, so what is
//! known is never traced again, and a run that was stopped goes on where it was.

use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write as _;
use std::path::Path;

use glam::DVec3;
use himmel_air::Preset;
use himmel_air::reference::{Effort, Source, Tracer, for_each_parallel};
use himmel_air::single::Ray;

use super::{Random, view};

/// Where errors are measured.
pub const WAVELENGTHS_NM: [f64; 3] = [680.0, 550.0, 440.0];

/// Questions of one kind.
#[derive(Clone, Debug)]
pub struct Class {
    /// Its name for `--class` and its file.
    pub key: String,
    /// Its name in tables.
    pub name: String,
    pub preset: &'static str,
    /// Ranges of the Sun's zenith angle, the view's zenith angle (degrees) and the altitude (m).
    pub sun_deg: (f64, f64),
    pub view_deg: (f64, f64),
    pub altitude_m: (f64, f64),
    /// Standard error of the tracer that is asked for, %.
    pub error: f64,
    /// The most paths of a question, so that the hardest ones end.
    pub most_samples: u64,
    /// Seed of the questions.
    pub seed: u64,
}

/// A line of sight.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    pub ray: Ray,
    direction: DVec3,
    sun_deg: f64,
}

/// What the tracer says, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    pub value: [f64; 3],
    pub standard_error: [f64; 3],
}

impl Class {
    /// The first `count` questions: fewer are the beginning of more.
    pub fn questions(&self, count: usize) -> Vec<Question> {
        let mut random = Random::new(self.seed);
        let mut within = |(low, high): (f64, f64)| random.within(low, high);
        let question = |_| {
            let sun_deg = within(self.sun_deg);
            let zenith_deg = within(self.view_deg);
            let direction = view(zenith_deg, within((0.0, 180.0)));
            let altitude_m = within(self.altitude_m);
            let sun = view(sun_deg, 0.0);
            let ray = Ray { altitude_m, mu: direction.z, mu_s: sun.z, nu: direction.dot(sun) };
            Question { ray, direction, sun_deg }
        };
        (0..count).map(question).collect()
    }

    /// The tracer's answers to the first `count` questions, one by one from `kept` or traced and appended to it.
    pub fn truths(&self, preset: &Preset, count: usize, kept: &Path) -> Result<Vec<Truth>, String> {
        let file = kept.join(format!("{}.csv", self.key));
        let mut known = Kept::open(&file, &self.fingerprint(preset))?;
        let questions = self.questions(count);
        known.truths.resize(known.truths.len().max(count), None);
        let missing: Vec<usize> = (0..count).filter(|i| known.truths[*i].is_none()).collect();
        let air = preset.medium.sampled(&WAVELENGTHS_NM);
        let tracer = Tracer::new(&air).map_err(|error| error.to_string())?;
        let effort = Effort {
            samples: 4096,
            target_relative_error: Some(self.error / 100.0),
            most_samples: self.most_samples,
            seed: 77,
        };
        let started = std::time::Instant::now();
        let (mut done, mut failed) = (0, None);
        for_each_parallel(
            missing.len(),
            |m| {
                let i = missing[m];
                let Question { ray, direction, sun_deg } = questions[i];
                let sources = [Source::at_zenith_angle(sun_deg.to_radians())];
                tracer
                    .radiance(&sources, ray.altitude_m, direction, &effort, i as u64)
                    .map_err(|error| error.to_string())
            },
            |m, answer| {
                let kept = answer.and_then(|answer| {
                    known.add(missing[m], Truth { value: answer.value, standard_error: answer.standard_error })
                });
                done += 1;
                eprint!(
                    "\r{}: {done} of {} traced, {:.0} s ",
                    self.key,
                    missing.len(),
                    started.elapsed().as_secs_f64()
                );
                failed = kept.err();
                failed.is_none()
            },
        );
        if !missing.is_empty() {
            eprintln!();
        }
        match failed {
            Some(error) => Err(error),
            None => Ok(known.truths.into_iter().take(count).flatten().collect()),
        }
    }

    /// Tells whether kept answers belong to these questions: the air, the class and the effort.
    fn fingerprint(&self, preset: &Preset) -> String {
        let mut hasher = DefaultHasher::new();
        format!("{:?}", preset.medium).hash(&mut hasher);
        let Self { key: _, name: _, preset: name, sun_deg, view_deg, altitude_m, error, most_samples, seed } = self;
        format!(
            "# {name} {:016x}; Sun {sun_deg:?}, view {view_deg:?}, altitude {altitude_m:?}; error {error}, at most {most_samples}; seed {seed}",
            hasher.finish()
        )
    }
}

/// A file of answers: a line that says what they answer, then `number,values,standard errors`.
struct Kept {
    file: std::fs::File,
    truths: Vec<Option<Truth>>,
}

impl Kept {
    /// Reads what is there; a file for other questions begins anew.
    fn open(path: &Path, fingerprint: &str) -> Result<Self, String> {
        let failed = |error: std::io::Error| format!("cannot keep answers: {error}: {}", path.display());
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let mut lines = text.lines();
        let mut truths = Vec::new();
        let fits = lines.next() == Some(fingerprint);
        if !fits {
            std::fs::write(path, format!("{fingerprint}\n")).map_err(failed)?;
        }
        for line in lines.filter(|_| fits) {
            // A line that was cut when the run was stopped is traced again.
            let numbers: Vec<f64> = line.split(',').map_while(|field| field.parse().ok()).collect();
            if let [i, a, b, c, sa, sb, sc] = numbers[..] {
                let i = i as usize;
                truths.resize(truths.len().max(i + 1), None);
                truths[i] = Some(Truth { value: [a, b, c], standard_error: [sa, sb, sc] });
            }
        }
        let mut file = std::fs::OpenOptions::new().append(true).open(path).map_err(failed)?;
        if fits && !text.ends_with('\n') {
            writeln!(file).map_err(failed)?;
        }
        Ok(Self { file, truths })
    }

    fn add(&mut self, i: usize, truth: Truth) -> Result<(), String> {
        let mut line = i.to_string();
        for number in truth.value.iter().chain(&truth.standard_error) {
            let _ = write!(line, ",{number:e}");
        }
        self.truths[i] = Some(truth);
        writeln!(self.file, "{line}").map_err(|error| format!("cannot keep an answer: {error}"))
    }
}
