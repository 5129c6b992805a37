//! Automatic exposure: draws a small picture and averages its luminance into one texel, without a read-back.

use crate::error::GpuError;
use crate::shader;

/// Size of the metering picture: 2,304 rays, a 400th of a 1280×720 frame.
pub(crate) const SIZE: (u32, u32) = (64, 36);
/// Floats, so that the Sun's disc does not overflow.
pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The pass that averages; one for a renderer.
pub(crate) struct Meter {
    pub picture: wgpu::TextureView,
    pub exposure: wgpu::Texture,
    exposure_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
}

impl Meter {
    pub(crate) fn new(device: &wgpu::Device) -> Result<Self, GpuError> {
        let texture = |label, (width, height), usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | usage,
                view_formats: &[],
            })
        };
        let picture = texture("metering picture", SIZE, wgpu::TextureUsages::empty()).create_view(&Default::default());
        let exposure = texture("exposure", (1, 1), wgpu::TextureUsages::COPY_SRC);
        let exposure_view = exposure.create_view(&Default::default());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("meter"),
            source: wgpu::ShaderSource::Wgsl(shader::module("output/meter.wgsl")?.into()),
        });
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("meter"),
            entries: &[crate::phenomena::table_entry(0)],
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("meter"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&picture) }],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("meter"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("meter"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("meter_vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("meter_fragment"),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Ok(Self { picture, exposure, exposure_view, pipeline, bind_group })
    }

    pub(crate) fn exposure_view(&self) -> &wgpu::TextureView {
        &self.exposure_view
    }

    /// Keeps a fixed factor where the metered one would be, so that hosts find either in the same place.
    pub(crate) fn set(&self, encoder: &mut wgpu::CommandEncoder, factor: f64) {
        let ev100 = -(factor * 1.2).log2();
        let texel = wgpu::Color { r: factor, g: ev100, b: 0.0, a: 1.0 };
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(texel), store: wgpu::StoreOp::Store };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("exposure"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                ops,
                ..crate::phenomena::cleared(&self.exposure_view)
            })],
            ..Default::default()
        });
    }

    /// Averages the picture that was drawn into [`Meter::picture`].
    pub(crate) fn reduce(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("meter"),
            color_attachments: &[Some(crate::phenomena::cleared(&self.exposure_view))],
            timestamp_writes: timestamps,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
