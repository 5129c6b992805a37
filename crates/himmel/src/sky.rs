//! The sky in the host's own render pass.

use himmel_air::Preset;
use himmel_gpu::{ApplyAir, Rebuild, SkyRenderer, Target, View};

use crate::error::Result;
use crate::light::Light;
use crate::model::SkyModel;
use crate::observer::Observer;
use crate::scene::Scene;

/// The sky, drawn into your pass behind your geometry.
///
/// Make it once, [`prepare`](Self::prepare) it each frame for any number of views, [`draw`](Self::draw) each view. You
/// keep your device, your pass, your depth convention and your formats. `examples/own_renderer` is a complete host.
pub struct Sky {
    model: SkyModel,
    renderer: SkyRenderer,
    frame_seconds: Option<f64>,
}

impl Sky {
    /// Compiles the pipelines for a target and uploads the air's tables. Stands in Potsdam, now; see [`set_observer`](Self::set_observer).
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target: &Target, preset: &Preset) -> Result<Self> {
        let scene = Scene { preset: preset.name.clone(), ..Scene::default() };
        Self::with_model(device, queue, target, SkyModel::with_preset(&scene, preset.clone())?)
    }

    /// As [`new`](Self::new), from a scene.
    pub fn with_scene(device: &wgpu::Device, queue: &wgpu::Queue, target: &Target, scene: &Scene) -> Result<Self> {
        Self::with_model(device, queue, target, SkyModel::new(scene)?)
    }

    fn with_model(device: &wgpu::Device, queue: &wgpu::Queue, target: &Target, model: SkyModel) -> Result<Self> {
        let mut renderer = SkyRenderer::new(device, queue, target, model.atmosphere())?;
        renderer.set_far_airs(&model.far_airs())?;
        Ok(Self { model, renderer, frame_seconds: None })
    }

    /// Everything but the GPU: settings, clock, the Sun's place, numbers.
    pub fn model(&self) -> &SkyModel {
        &self.model
    }

    /// The clock, to run, stop or set it.
    pub fn clock_mut(&mut self) -> &mut crate::clock::Clock {
        self.model.clock_mut()
    }

    /// Stands elsewhere.
    pub fn set_observer(&mut self, observer: Observer) -> &mut Self {
        self.model.set_observer(observer);
        self
    }

    /// Sets the clock: ISO 8601; bare times are local to the observer.
    pub fn set_time(&mut self, text: &str) -> Result<&mut Self> {
        self.model.set_time(text)?;
        Ok(self)
    }

    /// Sets a parameter by name: `air.aerosols`, `2`. An edit of the air integrates its tables anew (about 40 ms); all
    /// others cost nothing. On an error nothing changes.
    pub fn set(&mut self, key: &str, value: &str) -> Result<&mut Self> {
        let mut scene = self.model.scene().clone();
        scene.set(key, value)?;
        self.set_scene(&scene)?;
        Ok(self)
    }

    /// Takes all settings from a scene.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<()> {
        let before = self.model.atmosphere().wavelengths_nm();
        if self.model.set_scene(scene)? {
            if self.model.atmosphere().wavelengths_nm() != before {
                self.renderer.set_far_airs(&[])?;
            }
            self.renderer.set_atmosphere(self.model.atmosphere())?;
        }
        Ok(self.renderer.set_far_airs(&self.model.far_airs())?)
    }

    /// Records this frame's small uploads. Any number of views: stereo, cube faces, split screens.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder, views: &[View]) -> Result<()> {
        let frame = himmel_gpu::FrameState { seconds: self.frame_seconds, ..self.model.frame()? };
        Ok(self.renderer.prepare(encoder, &frame, views)?)
    }

    /// Real seconds that the next frames are apart: automatic exposure then follows the light as `output.adaptation` says.
    /// Without them every frame is adapted at once.
    pub fn set_frame_seconds(&mut self, seconds: Option<f64>) {
        self.frame_seconds = seconds;
    }

    /// Draws a prepared view into your pass, at infinite depth.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        self.renderer.draw(pass, view_index);
    }

    /// Puts the air before a picture that you have drawn from a prepared view, by its depth; see
    /// [`SkyRenderer::apply_air`]. `examples/terrain_host` is a complete host.
    pub fn apply_air(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        colour_in: &wgpu::TextureView,
        depth: &wgpu::TextureView,
        colour_out: &wgpu::TextureView,
        view_index: usize,
        air: &ApplyAir<'_>,
    ) -> Result<()> {
        Ok(self.renderer.apply_air(encoder, colour_in, depth, colour_out, view_index, air)?)
    }

    /// How far the rebuilding of the air's tables is after an edit; `None` once all orders of scattering are there.
    pub fn rebuilding(&self) -> Option<Rebuild> {
        self.renderer.rebuilding()
    }

    /// The renderer, for its pace and its memory.
    pub fn renderer_mut(&mut self) -> &mut SkyRenderer {
        &mut self.renderer
    }

    /// The exposure that the prepared frame is drawn with, for your shaders: one texel, see
    /// [`SkyRenderer::exposure_view`]. Multiply its red by 2^`output.compensation_ev` if you set that.
    pub fn exposure_view(&self) -> &wgpu::TextureView {
        self.renderer.exposure_view()
    }

    /// Direction, colour and illuminance of the Sun and the sky, for your scene. Computed in f64 on the CPU (some
    /// milliseconds): ask when time or air changed, not for every object.
    pub fn light(&self) -> Result<Light> {
        self.model.light()
    }
}
