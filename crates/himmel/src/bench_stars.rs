//! What the points of a night cost on top of the air: what `himmel bench --stars` asks.
//!
//! Frames with and without them are drawn in turn into the same target. The catalogue's stars are laid evenly over the
//! picture, so that all of them are on screen whatever the field of view.

use std::sync::Arc;

use himmel_astro::Catalogue;
use himmel_core::constants::ILLUMINANCE_OF_V_0_LX;
use himmel_gpu::comparison::{Stage, TimedFrame};
use himmel_gpu::{AdapterReport, Exposure, FrameState, Gpu, GpuError, SkyRenderer, StarList, StarPoint, View};

use crate::bench::{Medians, Options, medians};
use crate::error::Result;
use crate::model::SkyModel;
use crate::scene::Scene;

/// An exposure for a dark night.
const NIGHT: Exposure = Exposure::Ev100(-8.0);

/// All that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Where.
    pub adapter: AdapterReport,
    /// Stars on screen.
    pub stars: usize,
    /// A frame without points.
    pub without: Medians,
    /// A frame with them.
    pub with: Medians,
}

impl Report {
    /// What the points add, by the fastest frames, ms.
    pub fn cost_ms(&self) -> f64 {
        self.with.fastest_ms - self.without.fastest_ms
    }
}

/// Measures a scene. `progress` is told the share done and answers whether to go on.
pub fn run(gpu: &Gpu, scene: &Scene, options: Options, progress: &mut dyn FnMut(f64) -> bool) -> Result<Report> {
    let mut scene = scene.clone();
    if scene.output.exposure.is_none_or(|exposure| exposure == Exposure::Auto) {
        scene.output.exposure = Some(NIGHT);
    }
    scene.stars.enabled = true;
    let model = SkyModel::new(&scene)?;
    let view = model.view()?;
    let mut stage = Stage::new(gpu, scene.output.width_px, scene.output.height_px)?;
    let mut renderer = SkyRenderer::new(&gpu.device, &gpu.queue, &Stage::target(), model.atmosphere())?;
    let with = on_screen(model.frame()?, &view);
    let without = FrameState { stars: None, bodies: Vec::new(), planets: Vec::new(), ..with.clone() };
    let stars = with.stars.as_ref().map_or(0, |field| field.list.count_to(field.params.limiting_magnitude));
    stage.sky(&mut renderer, &with, &view)?;
    renderer.cancel_rebuild();
    let rounds = options.warm_up + options.frames.max(1);
    let mut samples: [Vec<TimedFrame>; 2] = Default::default();
    for round in 0..rounds {
        for turn in 0..2 {
            let kind = (round + turn) % 2;
            let timed = stage.sky(&mut renderer, if kind == 0 { &without } else { &with }, &view)?;
            if round >= options.warm_up {
                samples[kind].push(timed);
            }
        }
        if !progress((round + 1) as f64 / rounds as f64) {
            return Err(GpuError::Cancelled.into());
        }
    }
    let [without, with] = samples.map(|samples| medians(&samples));
    Ok(Report { adapter: gpu.report(), stars, without, with })
}

/// The catalogue's 9,000 brightest over the picture, by an even sequence [roberts2018]; each keeps magnitude and colour.
fn on_screen(mut frame: FrameState, view: &View) -> FrameState {
    let Some(field) = &mut frame.stars else { return frame };
    let stars = Catalogue::embedded().stars().iter().take(9000).enumerate().filter_map(|(index, star)| {
        let at = |step: f64| 1.98 * (0.5 + step * index as f64).fract() - 0.99;
        let direction = view.direction([at(0.754_877_666_2), at(0.569_840_291)])?;
        Some(StarPoint {
            place: field.enu_from_icrs.transpose() * direction,
            velocity_per_year: glam::DVec3::ZERO,
            parallax_rad: 0.0,
            v_magnitude: star.v_magnitude,
            illuminance_lx: ILLUMINANCE_OF_V_0_LX * 10f64.powf(-0.4 * star.v_magnitude),
            temperature_k: star.temperature_k().unwrap_or(0.0),
        })
    });
    field.list = Arc::new(StarList::new(stars.collect()));
    field.params.limiting_magnitude = 40.0;
    frame
}
