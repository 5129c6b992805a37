//! The approximation's tables, and the pipelines that fill and show them.

use crate::output::params::Tonemap;
use crate::target::{Output, Target};

/// A pipeline that fills one table (the froxels: two), with what it is bound to.
pub(crate) struct TablePass {
    label: &'static str,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 2],
}

/// Side of a workgroup, in texels.
const WORKGROUP: u32 = 8;

impl TablePass {
    /// `size`: texels, or columns of froxels. The layout is the shader's own: `bindings` are those that its entry point
    /// `label_pass` uses.
    pub(crate) fn new(
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        (label, entry_point): (&'static str, &str),
        phase_count: usize,
        bindings: &[wgpu::BindGroupEntry<'_>],
        size: (u32, u32),
    ) -> Self {
        let constants = [("phase_count", phase_count as f64)];
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: None,
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            cache: None,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &pipeline.get_bind_group_layout(0),
            entries: bindings,
        });
        Self { label, pipeline, group, workgroups: [size.0.div_ceil(WORKGROUP), size.1.div_ceil(WORKGROUP)] }
    }

    /// The profiler's name for it.
    pub(crate) fn label(&self) -> &'static str {
        self.label
    }

    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some(self.label), timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.workgroups[0], self.workgroups[1], 1);
    }
}

/// A table of half floats that a pass writes and later ones sample. `depth` above 1: froxels.
pub(crate) fn table(device: &wgpu::Device, label: &str, (width, height, depth): (u32, u32, u32)) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: depth },
        mip_level_count: 1,
        sample_count: 1,
        dimension: if depth > 1 { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
        format: wgpu::TextureFormat::Rgba16Float,
        // COPY_SRC: tests read it back.
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// The picture's pipeline for a host's target, with the layout of its shader.
pub(crate) fn picture_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    target: &Target,
    tonemap: Tonemap,
) -> wgpu::RenderPipeline {
    let far_depth = [("far_depth", target.far_depth())];
    let finished = [
        ("finished", f64::from(u8::from(target.output == Output::Display))),
        ("tonemap_operator", f64::from(tonemap as u32)),
    ];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("hillaire sky"),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("sky_vertex"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &far_depth, ..Default::default() },
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: target.behind(),
        multisample: wgpu::MultisampleState { count: target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("sky_fragment"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &finished, ..Default::default() },
            targets: &[Some(target.colour.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
