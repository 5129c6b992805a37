//! Radiance along one line of sight as tables ask for it: angles, an altitude, a wavelength.

use std::sync::Arc;

use glam::DVec3;

use crate::columns::Columns;
use crate::error::AirError;
use crate::medium::Medium;
use crate::moments::{self, Moments, Quality};
use crate::reference::{Effort, Source, Tracer};
use crate::single::{Ray, enter, sun_transmittance};

/// Wavelengths that may be asked for, nm: those that the presets' spectra, ozone and spheres are tabulated for.
pub const WAVELENGTHS_NM: std::ops::RangeInclusive<f64> = 360.0..=830.0;

/// Cells of a ray that [`moments::radiance`] marches: its recipe.
const MOMENT_STEPS: usize = 32;

/// What does one see from there, in that direction? The Sun is a parallel beam; nothing is refracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Height of the observer above the ground, m.
    pub altitude_m: f64,
    /// Zenith angle of the Sun at the observer, degrees.
    pub sun_zenith_deg: f64,
    /// Zenith angle of the line of sight, degrees.
    pub view_zenith_deg: f64,
    /// Azimuth of the line of sight minus that of the Sun, degrees.
    pub azimuth_deg: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
}

impl Question {
    /// Names of the quantities, in the order of [`new`](Self::new).
    pub const COLUMNS: [&str; 5] = ["altitude_m", "sun_zenith_deg", "view_zenith_deg", "azimuth_deg", "wavelength_nm"];

    /// Checks the quantities; the error names the column.
    pub fn new(values: [f64; 5]) -> Result<Self, AirError> {
        let rules = [
            (0.0..=1e12, "lie in 0..=1e12 m (below 0 is a camera inside the ground)"),
            (0.0..=180.0, "lie in 0..=180 degrees (0: the Sun in the zenith, 90: at the level)"),
            (0.0..=180.0, "lie in 0..=180 degrees (0: straight up, 180: straight down)"),
            (-720.0..=720.0, "lie in -720..=720 degrees"),
            (WAVELENGTHS_NM, "lie in 360..=830 nm, which the spectra cover"),
        ];
        for ((name, (range, law)), got) in Self::COLUMNS.iter().zip(rules).zip(values) {
            if !range.contains(&got) {
                return Err(AirError::Optics { what: (*name).into(), law, got });
            }
        }
        let [altitude_m, sun_zenith_deg, view_zenith_deg, azimuth_deg, wavelength_nm] = values;
        Ok(Self { altitude_m, sun_zenith_deg, view_zenith_deg, azimuth_deg, wavelength_nm })
    }

    /// The line of sight as a unit vector: z is the zenith, the Sun's azimuth lies along x.
    pub fn direction(&self) -> DVec3 {
        let (sin_v, cos_v) = self.view_zenith_deg.to_radians().sin_cos();
        let (sin_a, cos_a) = self.azimuth_deg.to_radians().sin_cos();
        DVec3::new(sin_v * cos_a, sin_v * sin_a, cos_v)
    }

    /// The Sun: a parallel beam of unit irradiance.
    pub fn sun(&self) -> Source<1> {
        Source::at_zenith_angle(self.sun_zenith_deg.to_radians())
    }

    /// The same as a ray with its cosines.
    pub fn ray(&self) -> Ray {
        let (direction, sun) = (self.direction(), self.sun().direction);
        Ray { altitude_m: self.altitude_m, mu: direction.z, mu_s: sun.z, nu: direction.dot(sun).clamp(-1.0, 1.0) }
    }
}

/// What answers.
#[derive(Clone, Debug, PartialEq)]
pub enum Solver {
    /// The Monte Carlo tracer, [`crate::reference`]: all orders, without approximation but chance.
    Reference(Effort),
    /// The table of moments, [`crate::moments`]: fast and without noise, within about a percent in clear air.
    Moments(Quality),
}

/// Light along a line of sight.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Per unit spectral irradiance of the Sun above the air, its disc excluded, sr⁻¹.
    pub radiance_per_sr: f64,
    /// Standard error of it, sr⁻¹; `None` where nothing is left to chance (moments).
    pub standard_error_per_sr: Option<f64>,
    /// It by order: light scattered (or reflected by the ground) once, twice …; the last holds the rest. Empty for moments.
    pub orders_per_sr: Vec<f64>,
    /// Paths that were followed.
    pub samples: u64,
}

impl Answer {
    /// Standard error as a share of the value; 0 where there is none.
    pub fn relative_error(&self) -> f64 {
        match self.standard_error_per_sr {
            Some(error) if error > 0.0 => error / self.radiance_per_sr.abs(),
            _ => 0.0,
        }
    }
}

/// A medium at one wavelength, ready to be asked.
///
/// ```
/// use himmel_air::query::{OneWavelength, Question, Solver};
/// use himmel_air::{Preset, reference::Effort};
/// let medium = std::sync::Arc::new(Preset::named("bruneton2017")?.medium);
/// let effort = Effort { samples: 256, ..Effort::default() };
/// let air = OneWavelength::new(medium, 550.0, &Solver::Reference(effort))?;
/// let question = Question::new([0.0, 60.0, 45.0, 90.0, 550.0])?;
/// let answer = air.answer(&question, 0)?;
/// assert!(answer.radiance_per_sr > answer.orders_per_sr[0]);
/// # Ok::<(), himmel_air::AirError>(())
/// ```
pub struct OneWavelength {
    medium: Arc<Medium>,
    wavelength_nm: f64,
    solved: Solved,
}

enum Solved {
    Reference(Box<Tracer<1>>, Effort),
    Moments(Box<(Columns, Moments<1>)>),
}

impl OneWavelength {
    /// Prepares it: tens of milliseconds for the reference, seconds for moments.
    ///
    /// Errors: an effort that makes no sense, a medium whose coefficients are no numbers.
    pub fn new(medium: Arc<Medium>, wavelength_nm: f64, solver: &Solver) -> Result<Self, AirError> {
        let air = medium.sampled(&[wavelength_nm]);
        let solved = match solver {
            Solver::Reference(effort) => {
                effort.check()?;
                Solved::Reference(Box::new(Tracer::new(&air)?), *effort)
            }
            Solver::Moments(quality) => {
                let columns = Columns::new(&medium);
                let moments = Moments::build(&air, &columns, quality);
                Solved::Moments(Box::new((columns, moments)))
            }
        };
        Ok(Self { medium, wavelength_nm, solved })
    }

    /// The moments, if they are what answers.
    pub fn moments(&self) -> Option<&Moments<1>> {
        match &self.solved {
            Solved::Moments(tables) => Some(&tables.1),
            Solved::Reference(..) => None,
        }
    }

    /// Answers a question; its own wavelength is not looked at. `stream`: which random numbers to take, such as the row of
    /// a table: the same one gives the same answer.
    pub fn answer(&self, question: &Question, stream: u64) -> Result<Answer, AirError> {
        match &self.solved {
            Solved::Reference(tracer, effort) => {
                let (sources, direction) = ([question.sun()], question.direction());
                let found = tracer.radiance(&sources, question.altitude_m, direction, effort, stream)?;
                Ok(Answer {
                    radiance_per_sr: found.value[0],
                    standard_error_per_sr: Some(found.standard_error[0]),
                    orders_per_sr: found.orders.iter().map(|order| order[0]).collect(),
                    samples: found.samples,
                })
            }
            Solved::Moments(tables) => {
                let air = self.medium.sampled(&[self.wavelength_nm]);
                let [radiance_per_sr] = moments::radiance(&air, &tables.0, &tables.1, &question.ray(), MOMENT_STEPS);
                Ok(Answer { radiance_per_sr, standard_error_per_sr: None, orders_per_sr: Vec::new(), samples: 0 })
            }
        }
    }

    /// Transmittance from the observer along the line of sight to space; 0 where the ground is in the way.
    pub fn transmittance(&self, question: &Question) -> Result<f64, AirError> {
        match &self.solved {
            Solved::Reference(tracer, _) => Ok(tracer.transmittance(question.altitude_m, question.direction())?[0]),
            Solved::Moments(tables) => {
                let medium = &self.medium;
                let Some(ray) = enter(medium.bottom_radius_m, medium.top_altitude_m, &question.ray()) else {
                    return Ok(1.0);
                };
                let air = medium.sampled(&[self.wavelength_nm]);
                Ok(sun_transmittance(&air, &tables.0, ray.altitude_m, ray.mu)[0])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    #[test]
    fn questions_that_make_no_sense_name_their_column() {
        let good = [0.0, 60.0, 45.0, 90.0, 550.0];
        assert!(Question::new(good).is_ok());
        for (index, value, words) in [
            (0, -1.0, "inside the ground"),
            (0, f64::NAN, "altitude_m"),
            (1, 180.1, "sun_zenith_deg"),
            (2, -0.1, "view_zenith_deg"),
            (3, 1e30, "azimuth_deg"),
            (4, 300.0, "360..=830 nm"),
            (4, f64::INFINITY, "wavelength_nm"),
        ] {
            let mut values = good;
            values[index] = value;
            let error = Question::new(values).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    /// The two solvers know nothing of each other; in clear air they agree within 2 % and the error. Transmittances are
    /// integrated in two ways, too.
    #[test]
    fn solvers_agree() {
        let medium = Arc::new(Preset::named("bruneton2017").unwrap().medium);
        let effort = Effort { samples: 2048, ..Effort::default() };
        let quality = Quality { rows: 16, columns: 32, ..Quality::default() };
        let reference = OneWavelength::new(Arc::clone(&medium), 550.0, &Solver::Reference(effort)).unwrap();
        let moments = OneWavelength::new(medium, 550.0, &Solver::Moments(quality)).unwrap();
        for (altitude_m, sun, view, azimuth) in
            [(0.0, 60.0, 45.0, 90.0), (5000.0, 30.0, 85.0, 150.0), (0.0, 60.0, 120.0, 10.0), (4e5, 40.0, 150.0, 0.0)]
        {
            let question = Question::new([altitude_m, sun, view, azimuth, 550.0]).unwrap();
            let (a, b) = (reference.answer(&question, 7).unwrap(), moments.answer(&question, 0).unwrap());
            let ratio = b.radiance_per_sr / a.radiance_per_sr;
            assert!((ratio - 1.0).abs() < 0.02 + 4.0 * a.relative_error(), "{question:?}: {ratio}");
            let (t, u) = (reference.transmittance(&question).unwrap(), moments.transmittance(&question).unwrap());
            assert!((t - u).abs() < 1e-3, "{question:?}: {t} {u}");
        }
    }
}
