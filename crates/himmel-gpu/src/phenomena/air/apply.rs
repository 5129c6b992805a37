//! The air before another renderer's picture: attenuates its colours by their depth and adds what is scattered in between.

use glam::DMat4;

use super::Air;
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::pass::{self, Bound, Slot, bind, compute, full_screen, layout};
use crate::target::DepthDirection;
use crate::view::{Projection, View};

gpu_struct! {
    /// Of one call; the fields are explained in `aerial.wgsl`.
    pub struct ApplyUniform {
        /// Inverse projection.
        pub view_from_clip: [[f32; 4]; 4],
        /// Into the host's shadow map.
        pub shadow_from_view: [[f32; 4]; 4],
        /// The longest way through the air, m.
        pub longest_m: f32,
        /// Depth of nothing.
        pub far_depth: f32,
        /// Whether rays are parallel.
        pub orthographic: u32,
        /// Factor on in-scattered light; 0: the frame's.
        pub exposure: f32,
    }
}

/// How the host's picture is to be read.
#[derive(Clone, Copy, Debug)]
pub struct ApplyAir<'a> {
    /// Which way its depth grows.
    pub depth_direction: DepthDirection,
    /// Whether its colours were multiplied by the exposure already (see
    /// [`SkyRenderer::exposure_view`](crate::SkyRenderer::exposure_view)); otherwise they are cd m⁻².
    pub exposed: bool,
    /// Shadows of the host's geometry in the air: light shafts, of light that is scattered once.
    pub shadow: Option<ShadowMap<'a>>,
}

/// The host's shadow map of the first sun.
#[derive(Clone, Copy, Debug)]
pub struct ShadowMap<'a> {
    /// Depth, 0 near to 1 far, of one layer and one sample.
    pub depth: &'a wgpu::TextureView,
    /// From metres east, north, up of the observer into the map's clip space.
    pub clip_from_enu: DMat4,
}

/// Slots of the uniform buffer: views of a frame that air can be applied to.
const SLOTS: u32 = 64;

/// The passes.
pub(crate) struct Apply {
    uniform_stride: u64,
    uniforms: wgpu::Buffer,
    view_layout: wgpu::BindGroupLayout,
    air_layout: wgpu::BindGroupLayout,
    apply_layout: wgpu::BindGroupLayout,
    constants: [(&'static str, f64); 2],
    module: wgpu::ShaderModule,
    pipelines: Vec<(wgpu::TextureFormat, [bool; 3], wgpu::RenderPipeline)>,
    froxels: Option<Froxels>,
    no_shadow: wgpu::TextureView,
    no_volume: wgpu::TextureView,
}

struct Froxels {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    light: wgpu::TextureView,
    through: wgpu::TextureView,
    side: u32,
}

fn uniform_slot() -> Slot {
    Slot::Uniform(size_of::<ApplyUniform>() as u64, true)
}

fn volume(device: &wgpu::Device, label: &str, side: u32) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: side },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

impl Apply {
    pub(crate) fn new(device: &wgpu::Device, air: &Air, view_layout: &wgpu::BindGroupLayout) -> Result<Self, GpuError> {
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let uniform_stride = (size_of::<ApplyUniform>() as u64).next_multiple_of(alignment);
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("apply air"),
            size: uniform_stride * u64::from(SLOTS),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let apply_layout = layout(
            device,
            "apply air",
            wgpu::ShaderStages::FRAGMENT,
            &[
                (0, uniform_slot()),
                (1, Slot::Table),
                (2, Slot::Depth),
                (3, Slot::Depth),
                (4, Slot::Volume),
                (5, Slot::Volume),
            ],
        );
        let no_shadow = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("no shadow"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Depth32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let constants = air.constants();
        let froxels = match air.sizes.froxels {
            None => None,
            Some(side) => {
                // 64: the shader's room for a column.
                let side = side.clamp(2, 64);
                let format = wgpu::TextureFormat::Rgba32Float;
                let slots = [(0, uniform_slot()), (6, Slot::WriteVolume(format)), (7, Slot::WriteVolume(format))];
                let froxel_layout = layout(device, "froxels", wgpu::ShaderStages::COMPUTE, &slots);
                let module = pass::module(device, "phenomena/air/froxels.wgsl")?;
                let groups = [&air.layout, view_layout, &froxel_layout];
                let pipeline = compute(device, &module, "fill_froxels", &constants, &groups);
                let (light, through) = (volume(device, "froxel light", side), volume(device, "froxel through", side));
                let bound = [
                    (0, Bound::Part(&uniforms, size_of::<ApplyUniform>() as u64)),
                    (6, Bound::View(&light)),
                    (7, Bound::View(&through)),
                ];
                let group = bind(device, "froxels", &froxel_layout, &bound);
                Some(Froxels { pipeline, group, light, through, side })
            }
        };
        Ok(Self {
            uniform_stride,
            uniforms,
            view_layout: view_layout.clone(),
            air_layout: air.layout.clone(),
            apply_layout,
            constants,
            module: pass::module(device, "phenomena/air/apply.wgsl")?,
            pipelines: Vec::new(),
            froxels,
            no_shadow: no_shadow.create_view(&Default::default()),
            no_volume: volume(device, "no froxels", 2),
        })
    }

    /// Memory of the froxels in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.froxels.as_ref().map_or(0, |froxels| 32 * u64::from(froxels.side).pow(3))
    }

    /// The uniform of a call: the buffer, where in it, and what.
    pub(crate) fn uniform(
        &self,
        view: &View,
        view_index: usize,
        apply: &ApplyAir<'_>,
        longest_m: f64,
    ) -> Result<(wgpu::Buffer, u64, ApplyUniform), GpuError> {
        let Projection::Matrix(clip_from_view) = view.projection else {
            return Err(GpuError::View("air is applied by depth, which only a projection matrix has".into()));
        };
        if view_index >= SLOTS as usize {
            return Err(GpuError::View(format!("air is applied to at most {SLOTS} views of a frame")));
        }
        let view_from_clip = clip_from_view.inverse();
        if !view_from_clip.is_finite() {
            return Err(GpuError::View("its projection matrix has no inverse".into()));
        }
        let orthographic = clip_from_view.row(3).truncate().length() < 1e-12;
        let shadow = apply.shadow.map_or(DMat4::IDENTITY, |map| map.clip_from_enu * view.enu_from_view);
        if !shadow.is_finite() {
            return Err(GpuError::View("the matrix of the shadow map is not finite".into()));
        }
        let uniform = ApplyUniform {
            view_from_clip: view_from_clip.as_mat4().to_cols_array_2d(),
            shadow_from_view: shadow.as_mat4().to_cols_array_2d(),
            longest_m: longest_m as f32,
            far_depth: match apply.depth_direction {
                DepthDirection::Standard => 1.0,
                DepthDirection::Reversed => 0.0,
            },
            orthographic: u32::from(orthographic),
            exposure: if apply.exposed { 0.0 } else { 1.0 },
        };
        Ok((self.uniforms.clone(), view_index as u64 * self.uniform_stride, uniform))
    }

    /// Records the passes. `marching`: every pixel marches its own ray.
    #[allow(clippy::too_many_arguments)] // Three pictures, two groups and what the caller knows of the view.
    pub(crate) fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        air_group: &wgpu::BindGroup,
        view_group: &wgpu::BindGroup,
        view_offset: u32,
        view_index: usize,
        pictures: [&wgpu::TextureView; 3],
        apply: &ApplyAir<'_>,
        marching: bool,
        eclipsed: bool,
    ) -> Result<(), GpuError> {
        let [colour_in, depth, colour_out] = pictures;
        check(pictures, apply)?;
        let offset = (view_index as u64 * self.uniform_stride) as u32;
        // Shadows are too fine for froxels.
        let shafts = apply.shadow.is_some();
        let from_froxels = self.froxels.is_some() && !marching && !shafts;
        if let (Some(froxels), true) = (&self.froxels, from_froxels) {
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("froxels"), ..Default::default() });
            pass.set_pipeline(&froxels.pipeline);
            pass.set_bind_group(0, air_group, &[]);
            pass.set_bind_group(1, view_group, &[view_offset]);
            pass.set_bind_group(2, &froxels.group, &[offset]);
            pass.dispatch_workgroups(froxels.side.div_ceil(8), froxels.side.div_ceil(8), 1);
        }
        let format = colour_out.texture().format();
        let kind = [from_froxels, shafts, eclipsed];
        let known = |(f, k, _): &(wgpu::TextureFormat, [bool; 3], _)| (*f, *k) == (format, kind);
        let index = match self.pipelines.iter().position(known) {
            Some(index) => index,
            None => {
                let pipeline = self.pipeline(device, format, kind);
                self.pipelines.push((format, kind, pipeline));
                self.pipelines.len() - 1
            }
        };
        let volumes = match (&self.froxels, from_froxels) {
            (Some(froxels), true) => [&froxels.light, &froxels.through],
            _ => [&self.no_volume, &self.no_volume],
        };
        let group = bind(
            device,
            "apply air",
            &self.apply_layout,
            &[
                (0, Bound::Part(&self.uniforms, size_of::<ApplyUniform>() as u64)),
                (1, Bound::View(colour_in)),
                (2, Bound::View(depth)),
                (3, Bound::View(apply.shadow.map_or(&self.no_shadow, |map| map.depth))),
                (4, Bound::View(volumes[0])),
                (5, Bound::View(volumes[1])),
            ],
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("apply air"),
            color_attachments: &[Some(crate::phenomena::cleared(colour_out))],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines[index].2);
        pass.set_bind_group(0, air_group, &[]);
        pass.set_bind_group(1, view_group, &[view_offset]);
        pass.set_bind_group(2, &group, &[offset]);
        pass.draw(0..3, 0..1);
        Ok(())
    }

    fn pipeline(
        &self,
        device: &wgpu::Device,
        format: wgpu::TextureFormat,
        [from_froxels, shafts, eclipsed]: [bool; 3],
    ) -> wgpu::RenderPipeline {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("apply air"),
            bind_group_layouts: &[Some(&self.air_layout), Some(&self.view_layout), Some(&self.apply_layout)],
            immediate_size: 0,
        });
        let constants = [
            self.constants[0],
            self.constants[1],
            ("from_froxels", f64::from(u8::from(from_froxels))),
            ("shafts", f64::from(u8::from(shafts))),
            ("eclipses", f64::from(u8::from(eclipsed))),
        ];
        full_screen(device, &self.module, &layout, ["apply_vertex", "apply_fragment"], &constants, format)
    }
}

/// Whether three pictures fit each other.
fn check([colour_in, depth, colour_out]: [&wgpu::TextureView; 3], apply: &ApplyAir<'_>) -> Result<(), GpuError> {
    let refuse = |what: String| Err(GpuError::Target(what));
    let [a, b, c] = [colour_in, depth, colour_out].map(wgpu::TextureView::texture);
    for (name, texture) in [("depth", b), ("colour out", c)] {
        if (texture.width(), texture.height()) != (a.width(), a.height()) {
            return refuse(format!(
                "colour in has {}×{} pixels, {name} {}×{}",
                a.width(),
                a.height(),
                texture.width(),
                texture.height()
            ));
        }
    }
    for (name, texture) in [("colour in", a), ("depth", b), ("colour out", c)] {
        if texture.sample_count() != 1 || texture.dimension() != wgpu::TextureDimension::D2 {
            return refuse(format!("{name} must be a 2D texture with one sample a pixel: resolve it first"));
        }
    }
    if !b.format().is_depth_stencil_format() || !b.format().has_depth_aspect() {
        return refuse(format!("{:?} holds no depth", b.format()));
    }
    for (name, texture, usage) in [
        ("colour in", a, wgpu::TextureUsages::TEXTURE_BINDING),
        ("depth", b, wgpu::TextureUsages::TEXTURE_BINDING),
        ("colour out", c, wgpu::TextureUsages::RENDER_ATTACHMENT),
    ] {
        if !texture.usage().contains(usage) {
            return refuse(format!("{name} was created without {usage:?}"));
        }
    }
    if a == c {
        return refuse("colour in and colour out must be two textures".into());
    }
    if a.format().sample_type(None, None).is_none_or(|kind| !matches!(kind, wgpu::TextureSampleType::Float { .. })) {
        return refuse(format!("colour in holds no floats but {:?}", a.format()));
    }
    if let Some(map) = &apply.shadow {
        let texture = map.depth.texture();
        if !texture.format().has_depth_aspect() || texture.sample_count() != 1 {
            return refuse(format!("the shadow map must hold depth with one sample, got {:?}", texture.format()));
        }
    }
    Ok(())
}
