//! Small words for making passes: layouts, bind groups, compute pipelines.

use crate::error::GpuError;
use crate::shader;

/// What a binding of a compute pass is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slot {
    /// A uniform buffer; `true`: with a dynamic offset.
    Uniform(u64, bool),
    /// A table of floats, read texel by texel.
    Table,
    /// The same with layers.
    Layers,
    /// Layers that a sampler filters.
    Filtered,
    /// A table that a sampler filters.
    FilteredTable,
    /// Layers of whole numbers.
    Codes,
    /// A table of whole numbers.
    CodeTable,
    /// A sampler that filters.
    Sampler,
    /// Depth, read texel by texel.
    Depth,
    /// A storage buffer; `true`: that may be written.
    Buffer(bool),
    /// A texture with layers that is written.
    WriteLayers(wgpu::TextureFormat),
    /// A texture that is written.
    Write(wgpu::TextureFormat),
    /// A texture of three dimensions that is written.
    WriteVolume(wgpu::TextureFormat),
    /// A texture of three dimensions, read texel by texel.
    Volume,
}

fn entry(binding: u32, slot: Slot, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    use wgpu::{BindingType, BufferBindingType, StorageTextureAccess, TextureSampleType, TextureViewDimension};
    let texture =
        |sample_type, view_dimension| BindingType::Texture { sample_type, view_dimension, multisampled: false };
    let float = TextureSampleType::Float { filterable: false };
    let write = |format, view_dimension| BindingType::StorageTexture {
        access: StorageTextureAccess::WriteOnly,
        format,
        view_dimension,
    };
    let buffer = |ty, has_dynamic_offset, size| BindingType::Buffer {
        ty,
        has_dynamic_offset,
        min_binding_size: wgpu::BufferSize::new(size),
    };
    let ty = match slot {
        Slot::Uniform(size, dynamic) => buffer(BufferBindingType::Uniform, dynamic, size),
        Slot::Table => texture(float, TextureViewDimension::D2),
        Slot::Layers => texture(float, TextureViewDimension::D2Array),
        Slot::Filtered => texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2Array),
        Slot::FilteredTable => texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2),
        Slot::Codes => texture(TextureSampleType::Uint, TextureViewDimension::D2Array),
        Slot::CodeTable => texture(TextureSampleType::Uint, TextureViewDimension::D2),
        Slot::Sampler => BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        Slot::Volume => texture(float, TextureViewDimension::D3),
        Slot::Depth => texture(TextureSampleType::Depth, TextureViewDimension::D2),
        Slot::Buffer(write) => buffer(BufferBindingType::Storage { read_only: !write }, false, 0),
        Slot::WriteLayers(format) => write(format, TextureViewDimension::D2Array),
        Slot::Write(format) => write(format, TextureViewDimension::D2),
        Slot::WriteVolume(format) => write(format, TextureViewDimension::D3),
    };
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

/// A layout from bindings and what they are.
pub(crate) fn layout(
    device: &wgpu::Device,
    label: &str,
    visibility: wgpu::ShaderStages,
    slots: &[(u32, Slot)],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = slots.iter().map(|&(binding, slot)| entry(binding, slot, visibility)).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// What is bound.
#[derive(Clone, Copy)]
pub(crate) enum Bound<'a> {
    Buffer(&'a wgpu::Buffer),
    /// A slot of a buffer with dynamic offsets: its size.
    Part(&'a wgpu::Buffer, u64),
    View(&'a wgpu::TextureView),
    Sampler(&'a wgpu::Sampler),
}

/// A bind group from bindings and what is bound.
pub(crate) fn bind(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    bound: &[(u32, Bound<'_>)],
) -> wgpu::BindGroup {
    let entries: Vec<_> = bound
        .iter()
        .map(|&(binding, bound)| {
            let resource = match bound {
                Bound::Buffer(buffer) => buffer.as_entire_binding(),
                Bound::Part(buffer, size) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(size),
                }),
                Bound::View(view) => wgpu::BindingResource::TextureView(view),
                Bound::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
            };
            wgpu::BindGroupEntry { binding, resource }
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// A view of all layers of a texture.
pub(crate) fn layers(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// A shader module of one of the roots.
pub(crate) fn module(device: &wgpu::Device, root: &str) -> Result<wgpu::ShaderModule, GpuError> {
    Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(root),
        source: wgpu::ShaderSource::Wgsl(shader::module(root)?.into()),
    }))
}

/// A pipeline whose vertices cover the target, without depth and blending; its label is its fragment's entry point.
pub(crate) fn full_screen(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    [vertex, fragment]: [&str; 2],
    constants: &[(&str, f64)],
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A compute pipeline; its label is its entry point's name. `constants`: values of overrides.
pub(crate) fn compute(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry_point: &str,
    constants: &[(&str, f64)],
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::ComputePipeline {
    let groups: Vec<_> = groups.iter().map(|&group| Some(group)).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry_point),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&layout),
        module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}
