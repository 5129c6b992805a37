//! How fast the sky is, measured beside the approximation that most engines draw: what `himmel bench` asks.
//!
//! Four frames are drawn in turn into the same target on the same adapter, so that whatever else the machine does hits
//! all of them: an empty one, ours, and [`Hillaire`]'s with a moving Sun and with all its tables. Each is timed from the
//! beginning of its recording until the device is idle; every number is a median. The exposure is fixed, so nobody
//! meters. The Sun moves with every frame.

use std::time::Instant;

use himmel_air::AirQuality;
use himmel_gpu::comparison::{Hillaire, Redo, Stage, TimedFrame};
use himmel_gpu::{AdapterReport, AirSizes, Exposure, FrameState, Gpu, GpuError, PassTimes, SkyRenderer, View};

use crate::error::Result;
use crate::model::SkyModel;
use crate::scene::Scene;

/// The exposure of a scene that names none: a sunlit day.
const DAY: Exposure = Exposure::Ev100(14.0);
/// The Sun goes round a circle of this radius in azimuth and altitude …
const SWING_DEG: f64 = 0.5;
/// … in so many frames: 0.05° a frame, its way in 12 s.
const SWING_FRAMES: usize = 64;
/// Edits of the medium: up and down in turn.
const EDITS: usize = 6;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Frames of each kind to take the median of; at least 1.
    pub frames: usize,
    /// Frames of each kind before those.
    pub warm_up: usize,
}

/// Medians of one kind of frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Medians {
    /// From recording to an idle device, ms.
    pub frame_ms: f64,
    /// The fastest of them, ms: what is left where other work disturbs the medians.
    pub fastest_ms: f64,
    /// Passes, where the adapter offers time stamps.
    pub passes: PassTimes,
}

/// What an edit of the medium (aerosols × 1.3, and back) costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edit {
    /// From the new setting until the first frame that shows it is finished: the median of some edits, ms.
    pub first_frame_ms: f64,
    /// Frames until all orders of scattering are there.
    pub complete_frames: u32,
    /// The same as time, ms.
    pub complete_ms: f64,
}

/// All that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Where.
    pub adapter: AdapterReport,
    /// How finely our air is computed.
    pub quality: AirQuality,
    /// Samples along a ray of ours.
    pub samples_per_ray: u32,
    /// Rays of our sky view; `None`: each pixel marches its own.
    pub sky_view: Option<[u32; 2]>,
    /// A frame that clears the target and draws one colour.
    pub empty: Medians,
    /// Our sky.
    pub sky: Medians,
    /// The approximation, whose tables of Sun and camera are made anew.
    pub hillaire: Medians,
    /// The approximation, with all of its tables made anew.
    pub hillaire_everything: Medians,
    /// An edit of the medium under our sky.
    pub edit: Edit,
    /// Memory of our tables.
    pub table_bytes: u64,
    /// Memory of the approximation's tables.
    pub hillaire_table_bytes: u64,
}

impl Report {
    /// How many times as long as `other` a frame of ours takes.
    pub fn ratio(&self, other: &Medians) -> f64 {
        self.sky.frame_ms / other.frame_ms
    }

    /// The same of what they take above an empty frame.
    pub fn ratio_above_empty(&self, other: &Medians) -> f64 {
        (self.sky.frame_ms - self.empty.frame_ms) / (other.frame_ms - self.empty.frame_ms)
    }

    /// Samples along our rays, for each of so many pixels.
    pub fn samples_per_pixel(&self, pixels: f64) -> f64 {
        let rays = self.sky_view.map_or(1.0, |[across, up]| f64::from(across * up) / pixels);
        f64::from(self.samples_per_ray) * rays
    }

    /// The first frame after an edit in normal frames of ours.
    pub fn edit_ratio(&self) -> f64 {
        self.edit.first_frame_ms / self.sky.frame_ms
    }
}

/// Measures a scene. `progress` is told the share done and answers whether to go on.
///
/// The scene must be one that the approximation can draw: perspective, the camera within the air.
pub fn run(gpu: &Gpu, scene: &Scene, options: Options, progress: &mut dyn FnMut(f64) -> bool) -> Result<Report> {
    let mut scene = scene.clone();
    if scene.output.exposure.is_none_or(|exposure| exposure == Exposure::Auto) {
        scene.output.exposure = Some(DAY);
    }
    // The approximation draws none.
    scene.stars.enabled = false;
    scene.planets.enabled = false;
    let mut model = SkyModel::new(&scene)?;
    let view = model.view()?;
    let frames = moving_sun(&mut model)?;
    let (device, queue, target) = (&gpu.device, &gpu.queue, Stage::target());
    let mut stage = Stage::new(gpu, scene.output.width_px, scene.output.height_px)?;
    let mut renderer = SkyRenderer::new(device, queue, &target, model.atmosphere())?;
    let mut hillaire = Hillaire::new(device, queue, &target, model.atmosphere(), model.scene().output.tonemap)?;
    // How many orders of scattering the tables hold does not change what a frame costs.
    stage.sky(&mut renderer, &frames[0], &view)?;
    renderer.cancel_rebuild();

    let rounds = options.warm_up + options.frames.max(1);
    let all = (rounds + EDITS + 1) as f64;
    let mut samples: [Vec<TimedFrame>; 4] = Default::default();
    for round in 0..rounds {
        let frame = &frames[round % frames.len()];
        for turn in 0..4 {
            // Each kind is first, second, third and fourth equally often.
            let kind = (round + turn) % 4;
            let timed = match kind {
                0 => stage.empty()?,
                1 => stage.sky(&mut renderer, frame, &view)?,
                2 => stage.hillaire(&mut hillaire, frame, &view, Redo::SkyOnly)?,
                _ => stage.hillaire(&mut hillaire, frame, &view, Redo::Everything)?,
            };
            if round >= options.warm_up {
                samples[kind].push(timed);
            }
        }
        if !progress((round + 1) as f64 / all) {
            return Err(GpuError::Cancelled.into());
        }
    }
    let [empty, sky, hillaire_moving, hillaire_everything] = samples.map(|samples| medians(&samples));
    let mut first_frames = Vec::new();
    for index in 0..EDITS {
        first_frames.push(edit(&mut stage, &mut model, &mut renderer, &frames[index], &view)?);
        if !progress((rounds + index + 1) as f64 / all) {
            return Err(GpuError::Cancelled.into());
        }
    }
    // A rasteriser on the CPU needs half a minute for all orders: one edit is followed to its end.
    let started = Instant::now();
    edit(&mut stage, &mut model, &mut renderer, &frames[0], &view)?;
    let mut complete_frames = 1;
    while let Some(rebuild) = renderer.rebuilding() {
        if !progress((all - 1.0 + f64::from(rebuild.progress.clamp(0.0, 1.0))) / all) {
            return Err(GpuError::Cancelled.into());
        }
        stage.sky(&mut renderer, &frames[complete_frames as usize % frames.len()], &view)?;
        complete_frames += 1;
    }
    let complete_ms = started.elapsed().as_secs_f64() * 1e3;
    let (quality, steps) = (model.atmosphere().quality().unwrap_or(AirQuality::High), model.atmosphere().steps());
    let sizes = AirSizes::of(quality);
    Ok(Report {
        adapter: gpu.report(),
        quality,
        samples_per_ray: steps.unwrap_or(sizes.steps),
        sky_view: sizes.sky_view,
        empty,
        sky,
        hillaire: hillaire_moving,
        hillaire_everything,
        edit: Edit { first_frame_ms: median(first_frames), complete_frames, complete_ms },
        table_bytes: renderer.table_bytes(),
        hillaire_table_bytes: hillaire.table_bytes(),
    })
}

/// Frames of a Sun that goes round a small circle about its place. The model's settings are afterwards what they were.
fn moving_sun(model: &mut SkyModel) -> Result<Vec<FrameState>> {
    let (scene, sun) = (model.scene().clone(), model.sun()?);
    let mut moved = scene.clone();
    let mut frames = Vec::with_capacity(SWING_FRAMES);
    for index in 0..SWING_FRAMES {
        let (sine, cosine) = (index as f64 / SWING_FRAMES as f64 * std::f64::consts::TAU).sin_cos();
        moved.sun.azimuth_deg = Some((sun.azimuth_deg + SWING_DEG * cosine).rem_euclid(360.0));
        moved.sun.altitude_deg = Some((sun.airless_altitude_deg + SWING_DEG * sine).clamp(-90.0, 90.0));
        model.set_scene(&moved)?;
        frames.push(model.frame()?);
    }
    model.set_scene(&scene)?;
    Ok(frames)
}

/// Changes the aerosols and draws the first frame that shows it; ms.
fn edit(
    stage: &mut Stage,
    model: &mut SkyModel,
    renderer: &mut SkyRenderer,
    frame: &FrameState,
    view: &View,
) -> Result<f64> {
    // An earlier edit's rebuild must not be in the way.
    renderer.cancel_rebuild();
    let mut scene = model.scene().clone();
    let amount = scene.air.aerosols;
    // 1.3 times as much, or back; from nothing to a little.
    scene.air.aerosols = if amount > 1.0 { amount / 1.3 } else { 1.3 * amount.max(0.1) };
    let started = Instant::now();
    model.set_scene(&scene)?;
    renderer.set_atmosphere(model.atmosphere())?;
    stage.sky(renderer, frame, view)?;
    Ok(started.elapsed().as_secs_f64() * 1e3)
}

pub(crate) fn medians(samples: &[TimedFrame]) -> Medians {
    let mut passes: Vec<(&'static str, Vec<f64>)> = Vec::new();
    for (label, ms) in samples.iter().flat_map(|sample| &sample.times.passes) {
        match passes.iter_mut().find(|(known, _)| known == label) {
            Some((_, times)) => times.push(*ms),
            None => passes.push((label, vec![*ms])),
        }
    }
    Medians {
        fastest_ms: samples.iter().map(|sample| sample.ms).fold(f64::INFINITY, f64::min),
        frame_ms: median(samples.iter().map(|sample| sample.ms).collect()),
        passes: PassTimes { passes: passes.into_iter().map(|(label, times)| (label, median(times))).collect() },
    }
}

/// The middle one, or the mean of the two in the middle.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let (low, high) = ((values.len() - 1) / 2, values.len() / 2);
    0.5 * (values[low] + values[high])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_stand_in_the_middle() {
        assert_eq!(median(vec![3.0]), 3.0);
        assert_eq!(median(vec![5.0, 1.0, 3.0]), 3.0);
        assert_eq!(median(vec![5.0, 1.0, 3.0, 2.0]), 2.5);
        let timed =
            |ms, passes: &[(&'static str, f64)]| TimedFrame { ms, times: PassTimes { passes: passes.to_vec() } };
        let samples = [timed(2.0, &[("a", 1.0)]), timed(4.0, &[("a", 3.0), ("b", 9.0)]), timed(9.0, &[("a", 2.0)])];
        let medians = medians(&samples);
        assert_eq!((medians.frame_ms, medians.fastest_ms), (4.0, 2.0));
        assert_eq!(medians.passes.passes, [("a", 2.0), ("b", 9.0)]);
    }

    #[test]
    fn the_sun_moves_and_the_model_stays() {
        let mut scene = Scene::default();
        scene.set("light.sun.altitude_deg", "90").unwrap();
        let mut model = SkyModel::new(&scene).unwrap();
        let frames = moving_sun(&mut model).unwrap();
        assert_eq!(model.scene(), &scene);
        for pair in frames.windows(2) {
            assert_ne!(pair[0].sun.direction, pair[1].sun.direction);
        }
        assert!(frames.iter().all(|frame| frame.sun.direction.z > 0.5f64.to_radians().cos() - 1e-12));
    }
}
