//! The host's device, pipelines, textures and read-back: nothing of it knows the sky but the shape of its exposure texel.

use std::mem::size_of;

use himmel::DepthDirection;

use crate::mesh::Vertex;
use crate::{DEPTH, DISPLAY, HDR, LIGHT_LOW, LIGHTS, Result, SHADOW_PIXELS};

/// The host's device: nothing beyond WebGPU's defaults.
pub async fn open_device() -> Result<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = instance.request_adapter(&Default::default()).await?;
    Ok(adapter.request_device(&Default::default()).await?)
}

/// Ground as the camera sees it and as the Sun sees it.
pub struct TerrainPipelines {
    pub terrain: wgpu::RenderPipeline,
    pub shadow: wgpu::RenderPipeline,
}

impl TerrainPipelines {
    pub fn new(device: &wgpu::Device, direction: DepthDirection) -> Self {
        let constants = format!("const LIGHTS = {LIGHTS}u;\nconst LIGHT_LOW = {LIGHT_LOW:?};\n");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("host: terrain"),
            source: wgpu::ShaderSource::Wgsl((constants + include_str!("terrain.wgsl")).into()),
        });
        let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let layout = |entries: &[wgpu::BindGroupLayoutEntry]| {
            let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries });
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&group)],
                immediate_size: 0,
            })
        };
        let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
        // The sky's exposure is not filterable, so the layout is written out.
        let terrain_layout = layout(&[
            entry(0, vertex | fragment, uniform),
            entry(1, fragment, texture(wgpu::TextureSampleType::Float { filterable: false })),
            entry(2, fragment, texture(wgpu::TextureSampleType::Depth)),
            entry(3, fragment, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
        ]);
        let shadow_layout = layout(&[entry(0, vertex, uniform)]);
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32];
        let buffers = [wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        }];
        let pipeline = |label, layout: &wgpu::PipelineLayout, entry_point, depth_compare, bias, targets: &[_]| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(label),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    buffers: &buffers,
                },
                primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(depth_compare),
                    stencil: Default::default(),
                    bias,
                }),
                multisample: Default::default(),
                fragment: (!targets.is_empty()).then_some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("terrain_fragment"),
                    compilation_options: Default::default(),
                    targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let nearer = match direction {
            DepthDirection::Standard => wgpu::CompareFunction::Less,
            DepthDirection::Reversed => wgpu::CompareFunction::Greater,
        };
        let behind_slopes = wgpu::DepthBiasState { constant: 2, slope_scale: 2.0, clamp: 0.0 };
        Self {
            terrain: pipeline(
                "host: terrain",
                &terrain_layout,
                "terrain_vertex",
                nearer,
                Default::default(),
                &[Some(HDR.into())],
            ),
            shadow: pipeline(
                "host: shadow",
                &shadow_layout,
                "shadow_vertex",
                wgpu::CompareFunction::Less,
                behind_slopes,
                &[],
            ),
        }
    }
}

pub fn display_pipeline(device: &wgpu::Device) -> Result<wgpu::RenderPipeline> {
    use himmel::parts::gpu::shader;
    // Himmel's own tone mappers, so that both look alike; any other would do.
    let parts = [shader::module("output/tonemap.wgsl")?, shader::module("output/dither.wgsl")?];
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("host: display"),
        source: wgpu::ShaderSource::Wgsl((parts.concat() + include_str!("display.wgsl")).into()),
    });
    Ok(device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("host: display"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(DISPLAY.into())],
        }),
        multiview_mask: None,
        cache: None,
    }))
}

pub fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, r)| wgpu::BindGroupEntry { binding, resource: r.clone() }).collect();
    let layout = pipeline.get_bind_group_layout(0);
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
}

pub fn texture(
    device: &wgpu::Device,
    (width, height): (u32, u32),
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

/// The Sun's depth buffer.
pub fn shadow_texture(device: &wgpu::Device) -> wgpu::Texture {
    texture(device, (SHADOW_PIXELS, SHADOW_PIXELS), DEPTH, wgpu::TextureUsages::TEXTURE_BINDING)
}

/// Smooth between texels: each tap is the share of four that lie farther from the Sun.
pub fn shadow_sampler(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("host: shadow"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        compare: Some(wgpu::CompareFunction::LessEqual),
        ..Default::default()
    })
}

pub fn filled_buffer(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes.len() as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// Starts a pass that clears what it draws to.
pub fn begin_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    colour: Option<&wgpu::TextureView>,
    depth: Option<(&wgpu::TextureView, f32)>,
) -> wgpu::RenderPass<'a> {
    let attachment = colour.map(|view| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        // Red would show wherever neither ground nor sky was drawn.
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::RED), store: wgpu::StoreOp::Store },
    });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: if attachment.is_some() { std::slice::from_ref(&attachment) } else { &[] },
        depth_stencil_attachment: depth.map(|(view, far)| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(far), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// Submits the frame, waits for it, and fetches the picture.
pub fn read_rgb(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut encoder: wgpu::CommandEncoder,
    picture: &wgpu::Texture,
) -> Result<Vec<u8>> {
    let (width, height) = (picture.width(), picture.height());
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("host: read back"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(picture.as_image_copy(), destination, picture.size());
    queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver below outlives the wait.
        let _ = sender.send(result);
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    receiver.recv()??;
    let rows = buffer.get_mapped_range(..);
    let pixels = rows.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].chunks_exact(4));
    Ok(pixels.flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect())
}
