//! One frame after another into the same target, each timed until the device is idle.

use std::time::Instant;

use super::hillaire::{Hillaire, Redo};
use crate::error::GpuError;
use crate::gpu::Gpu;
use crate::phenomena::cleared;
use crate::renderer::{FrameState, SkyRenderer};
use crate::shader;
use crate::target::{Output, Target};
use crate::timing::{PassTimes, Stamps};
use crate::view::View;

/// What a frame took.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedFrame {
    /// From the beginning of its recording until the device was idle, ms.
    pub ms: f64,
    /// Its passes, where the adapter measures them.
    pub times: PassTimes,
}

/// A target of finished 8-bit colour that all contenders draw to.
pub struct Stage {
    gpu: Gpu,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    empty: wgpu::RenderPipeline,
    stamps: Option<Stamps>,
}

impl Stage {
    /// What contenders must be made for.
    pub fn target() -> Target {
        Target::new(wgpu::TextureFormat::Rgba8Unorm, Output::Display)
    }

    /// Makes the target.
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self, GpuError> {
        let (most, device) = (gpu.device.limits().max_texture_dimension_2d, &gpu.device);
        if width == 0 || height == 0 || width > most || height > most {
            let max_pixels = u64::from(most) * u64::from(most);
            return Err(GpuError::Size { width, height, max: most, max_pixels });
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("stage"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::target().colour,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("empty frame"),
            source: wgpu::ShaderSource::Wgsl(shader::module("comparison/empty.wgsl")?.into()),
        });
        let empty = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("empty frame"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("empty_vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("empty_fragment"),
                compilation_options: Default::default(),
                targets: &[Some(Self::target().colour.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let view = texture.create_view(&Default::default());
        Ok(Self { gpu: gpu.clone(), texture, view, empty, stamps: Stamps::new(gpu) })
    }

    /// A frame that clears the target and draws one colour.
    pub fn empty(&mut self) -> Result<TimedFrame, GpuError> {
        let pipeline = self.empty.clone();
        self.timed(|recording| {
            let mut pass = recording.pass("empty");
            pass.set_pipeline(&pipeline);
            pass.draw(0..3, 0..1);
            Ok(())
        })
    }

    /// A frame of our sky.
    pub fn sky(&mut self, renderer: &mut SkyRenderer, frame: &FrameState, view: &View) -> Result<TimedFrame, GpuError> {
        self.timed(|recording| {
            let stamps = recording.stamps.as_deref_mut();
            renderer.prepare_timed(&mut recording.encoder, frame, std::slice::from_ref(view), stamps)?;
            renderer.draw(&mut recording.pass("sky"), 0);
            Ok(())
        })
    }

    /// A frame of the approximation.
    pub fn hillaire(
        &mut self,
        hillaire: &mut Hillaire,
        frame: &FrameState,
        view: &View,
        redo: Redo,
    ) -> Result<TimedFrame, GpuError> {
        self.timed(|recording| {
            let stamps = recording.stamps.as_deref_mut();
            hillaire.prepare_timed(&mut recording.encoder, frame, view, redo, stamps)?;
            hillaire.draw(&mut recording.pass("hillaire sky"));
            Ok(())
        })
    }

    /// The texture that was drawn to last.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    fn timed(
        &mut self,
        record: impl FnOnce(&mut Recording<'_>) -> Result<(), GpuError>,
    ) -> Result<TimedFrame, GpuError> {
        let started = Instant::now();
        let encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut recording = Recording { encoder, stamps: self.stamps.as_mut(), target: &self.view };
        record(&mut recording)?;
        let Recording { mut encoder, stamps, .. } = recording;
        if let Some(stamps) = stamps {
            stamps.resolve(&mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        let ms = started.elapsed().as_secs_f64() * 1e3;
        let times = match &mut self.stamps {
            Some(stamps) => stamps.read(&self.gpu)?,
            None => PassTimes::default(),
        };
        Ok(TimedFrame { ms, times })
    }
}

/// A frame that is being recorded.
struct Recording<'a> {
    encoder: wgpu::CommandEncoder,
    stamps: Option<&'a mut Stamps>,
    target: &'a wgpu::TextureView,
}

impl Recording<'_> {
    /// The pass into the target.
    fn pass(&mut self, label: &'static str) -> wgpu::RenderPass<'_> {
        self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(cleared(self.target))],
            timestamp_writes: self.stamps.as_deref_mut().and_then(|stamps| stamps.next(label)),
            ..Default::default()
        })
    }
}
