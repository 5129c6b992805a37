//! Automatic exposure: draws a small picture and averages its luminance into one texel, without a read-back.

use crate::error::GpuError;
use crate::shader;

/// Pixels darker than this share of the mean do not count, and the luminance of nothing at all, cd m⁻²; as in `meter.wgsl`.
const DARK_SHARE: f64 = 1e-3;
const DARKEST: f64 = 1e-5;

/// The exposure value that makes a picture's geometric mean luminance middle grey, 0.18: the f64 twin of `meter.wgsl`,
/// without compensation.
///
/// `luminance_cd_m2`: of every pixel, `None` outside the picture (the corners of a fisheye).
/// Laws tested: an even picture becomes 0.18; twice as bright is one more; black space beside it changes nothing.
pub fn metered_ev100(luminance_cd_m2: impl Iterator<Item = Option<f64>> + Clone) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for value in luminance_cd_m2.clone() {
        sum += value.unwrap_or(0.0).max(0.0);
        all += 1.0;
    }
    let dark = (DARK_SHARE * sum / f64::max(all, 1.0)).max(DARKEST);
    let (mut logs, mut count) = (0.0, 0.0);
    for value in luminance_cd_m2.flatten().filter(|value| *value >= dark) {
        logs += value.log2();
        count += 1.0;
    }
    let log_mean = if count > 0.0 { logs / count } else { DARKEST.log2() };
    (log_mean - (1.2 * 0.18f64).log2()).clamp(-10.0, 24.0)
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::params::Exposure;

    #[test]
    fn the_mean_becomes_middle_grey() {
        let even = |value: f64| metered_ev100(std::iter::repeat_n(Some(value), 100));
        let factor = Exposure::Ev100(even(4000.0)).factor().unwrap();
        assert!((4000.0 * factor - 0.18).abs() < 1e-12);
        assert!((even(8000.0) - even(4000.0) - 1.0).abs() < 1e-12);
        let pair = [Some(1000.0), Some(4000.0)];
        assert!((metered_ev100(pair.into_iter()) - even(2000.0)).abs() < 1e-12, "the geometric mean");
        let space = [Some(1000.0), Some(4000.0), Some(0.0), Some(1e-2), None];
        assert!((metered_ev100(space.into_iter()) - even(2000.0)).abs() < 1e-12, "space does not count");
        assert_eq!(metered_ev100([None, Some(0.0)].into_iter()), -10.0);
    }
}
