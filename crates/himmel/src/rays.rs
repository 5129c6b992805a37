//! Radiance along lines of sight by the renderer itself: its tables, its shaders, the adapter at hand.

use himmel_air::query::Question;
use himmel_air::{AirParams, Atmosphere, GroundParams, Preset};
use himmel_gpu::{Gpu, GpuError, RayAnswer, RayMeter};

use crate::error::Result;

/// What the renderer shows along a line of sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Per unit spectral irradiance of the Sun above the air, its disc excluded, sr⁻¹.
    pub radiance_per_sr: f64,
    /// From the observer along the line of sight to space; 0 where the ground is in the way.
    pub transmittance: f64,
}

/// Answers questions at any wavelengths: four at a time, the renderer's own tables filled for each four.
///
/// `air`: its wavelengths are not looked at. `progress` is told the share done and answers whether to go on.
pub fn rays_on_gpu(
    gpu: &Gpu,
    preset: &Preset,
    air: &AirParams,
    ground: &GroundParams,
    questions: &[Question],
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<Seen>> {
    let mut wavelengths: Vec<f64> = questions.iter().map(|question| question.wavelength_nm).collect();
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    let mut seen = vec![Seen::default(); questions.len()];
    let groups = wavelengths.chunks(4);
    let count = groups.len();
    for (done, group) in groups.enumerate() {
        let last = group[group.len() - 1];
        let four: [f64; 4] = std::array::from_fn(|k| group.get(k).copied().unwrap_or(last));
        let air = AirParams {
            wavelength_1_nm: four[0],
            wavelength_2_nm: four[1],
            wavelength_3_nm: four[2],
            wavelength_4_nm: four[3],
            ..air.clone()
        };
        let atmosphere = Atmosphere::new(preset, &air, ground);
        let share = |part: f64| (done as f64 + part) / count as f64;
        let mut meter = RayMeter::new(gpu, &atmosphere, &mut |part| progress(share(0.9 * part)))?;
        let mine: Vec<(usize, usize)> = questions
            .iter()
            .enumerate()
            .filter_map(|(i, question)| Some((i, group.iter().position(|nm| *nm == question.wavelength_nm)?)))
            .collect();
        let rays: Vec<_> = mine.iter().map(|&(i, _)| questions[i].ray()).collect();
        let answers: Vec<RayAnswer> = meter.answer(&rays)?;
        for ((i, k), answer) in mine.into_iter().zip(answers) {
            seen[i] = Seen {
                radiance_per_sr: f64::from(answer.radiance_per_sr[k]),
                transmittance: f64::from(answer.transmittance[k]),
            };
        }
        if !progress(share(1.0)) {
            return Err(GpuError::Cancelled.into());
        }
    }
    Ok(seen)
}
