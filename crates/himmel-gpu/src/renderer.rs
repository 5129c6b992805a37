//! The renderer: made once for a target, prepared each frame, drawn for each view.

use std::sync::OnceLock;

use glam::DVec3;
use himmel_air::{Atmosphere, sun};
use wgpu::util::StagingBelt;

use crate::error::GpuError;
use crate::frame::{FrameUniform, ViewUniform};
use crate::output::meter::{self, Meter};
use crate::output::params::OutputParams;
use crate::phenomena::air::Tables;
use crate::phenomena::{cleared, table_entry};
use crate::shader;
use crate::target::{DepthDirection, Output, Target};
use crate::timing::Stamps;
use crate::view::{Projection, View};

/// The Sun as seen by the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunState {
    /// Unit vector towards it without refraction, east-north-up: lights the air.
    pub direction: DVec3,
    /// Unit vector towards its disc as refracted by the air, east-north-up.
    pub disc_direction: DVec3,
    /// Apparent radius of the disc, rad.
    pub radius_rad: f64,
    /// Irradiance above the air relative to the Earth's at 1 au.
    pub irradiance: f64,
    /// Whether the disc is drawn.
    pub disc: bool,
    /// Whether the disc darkens towards its limb.
    pub limb_darkening: bool,
}

/// What changes from frame to frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameState {
    /// The Sun.
    pub sun: SunState,
    /// Altitude of the observer above the ground sphere, m.
    pub altitude_m: f64,
    /// Exposure and tone mapping.
    pub output: OutputParams,
    /// Samples along a ray.
    pub steps: u32,
}

/// Coefficients of a disc that is equally bright everywhere.
const EVEN_DISC: [[f32; 4]; 6] = [[1.0; 4], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]];

/// Staging buffers that frames use in turn: three frames may be recorded before the first is submitted.
const BELTS: usize = 4;

/// Views that buffers hold at first; more make them grow once.
const FIRST_CAPACITY: usize = 8;
/// Most views of a frame: keeps the buffer below WebGPU's guaranteed 64 KiB of dynamic offsets many times over.
const MOST_VIEWS: usize = 4096;

/// Draws the sky into render passes of one kind.
pub struct SkyRenderer {
    device: wgpu::Device,
    target: Target,
    pipeline: wgpu::RenderPipeline,
    pipeline_layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    /// Made when automatic exposure is first asked for.
    metering_pipeline: OnceLock<wgpu::RenderPipeline>,
    meter: Meter,
    tables: Tables,
    frame_group: wgpu::BindGroup,
    frame_buffer: wgpu::Buffer,
    view_layout: wgpu::BindGroupLayout,
    view_group: wgpu::BindGroup,
    view_buffer: wgpu::Buffer,
    view_stride: u64,
    capacity: usize,
    prepared: usize,
    belts: [StagingBelt; BELTS],
    turn: usize,
    /// The part of the frame's uniform that follows from the medium.
    air: FrameUniform,
}

impl SkyRenderer {
    /// Compiles pipelines for a target and uploads the air's tables.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target: &Target,
        atmosphere: &Atmosphere,
    ) -> Result<Self, GpuError> {
        target.check(device)?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("sky"),
            source: wgpu::ShaderSource::Wgsl(shader::module("sky.wgsl")?.into()),
        });
        let uniform = |size: usize, dynamic| wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: dynamic,
                min_binding_size: wgpu::BufferSize::new(size as u64),
            },
            count: None,
        };
        let mut entries = vec![uniform(size_of::<FrameUniform>(), false)];
        entries.extend((1..=5).map(table_entry));
        let frame_layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("sky frame"), entries: &entries });
        let view_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("sky view"),
            entries: &[uniform(size_of::<ViewUniform>(), true)],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sky"),
            bind_group_layouts: &[Some(&frame_layout), Some(&view_layout)],
            immediate_size: 0,
        });
        let pipeline = sky_pipeline(device, &module, &pipeline_layout, target, false);
        let meter = Meter::new(device)?;
        let tables = Tables::new(device, atmosphere.depth_size());
        let frame_buffer = uniform_buffer(device, "sky frame", size_of::<FrameUniform>() as u64);
        let mut bindings = vec![wgpu::BindGroupEntry { binding: 0, resource: frame_buffer.as_entire_binding() }];
        let views = tables.views();
        for (binding, view) in (1..).zip(views.iter().chain([meter.exposure_view()])) {
            bindings.push(wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) });
        }
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sky frame"),
            layout: &frame_layout,
            entries: &bindings,
        });
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let view_stride = (size_of::<ViewUniform>() as u64).next_multiple_of(alignment);
        let (view_buffer, view_group) = view_buffer(device, &view_layout, view_stride, FIRST_CAPACITY);
        let mut renderer = Self {
            device: device.clone(),
            target: *target,
            pipeline,
            pipeline_layout,
            module,
            metering_pipeline: OnceLock::new(),
            meter,
            tables,
            frame_group,
            frame_buffer,
            view_layout,
            view_group,
            view_buffer,
            view_stride,
            capacity: FIRST_CAPACITY,
            prepared: 0,
            // Room for a frame's uniforms with a few views, so that one chunk serves a frame.
            belts: std::array::from_fn(|_| StagingBelt::new(device.clone(), 16 * 1024)),
            turn: 0,
            air: FrameUniform::default(),
        };
        renderer.set_atmosphere(queue, atmosphere);
        Ok(renderer)
    }

    /// Uploads the tables of another atmosphere (or of the same one after an edit).
    pub fn set_atmosphere(&mut self, queue: &wgpu::Queue, atmosphere: &Atmosphere) {
        self.tables.upload(queue, atmosphere);
        let [r, g, b] = atmosphere.rec709_from_four().map(|row| row.as_vec4().to_array());
        let coefficients = atmosphere.wavelengths_nm().map(sun::limb_darkening);
        let limb_darkening = std::array::from_fn(|k| coefficients.map(|c| c[k] as f32));
        self.air = FrameUniform {
            rec709_from_four_r: r,
            rec709_from_four_g: g,
            rec709_from_four_b: b,
            ground_albedo: atmosphere.sampled().ground_albedo.map(|albedo| albedo as f32),
            limb_darkening,
            bottom_radius_m: atmosphere.medium().bottom_radius_m as f32,
            top_altitude_m: atmosphere.medium().top_altitude_m as f32,
            ..FrameUniform::default()
        };
    }

    /// The target it draws to.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// Memory of its tables in bytes.
    pub fn table_bytes(&self) -> u64 {
        self.tables.bytes()
    }

    /// Records this frame's uploads, and the metering where exposure is automatic (by the first view). Call once a
    /// frame before [`draw`](Self::draw), with the encoder that is submitted before or with the pass that draws.
    ///
    /// At most three frames may be recorded before the first of them is submitted.
    /// Allocates nothing once running, unless there are more views than ever before.
    pub fn prepare(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameState,
        views: &[View],
    ) -> Result<(), GpuError> {
        self.prepare_timed(encoder, frame, views, None)
    }

    pub(crate) fn prepare_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameState,
        views: &[View],
        stamps: Option<&mut Stamps>,
    ) -> Result<(), GpuError> {
        self.prepared = 0;
        if views.is_empty() || views.len() > MOST_VIEWS {
            return Err(GpuError::View(format!("a frame has 1 to {MOST_VIEWS} views, got {}", views.len())));
        }
        let finite = frame.sun.direction.is_finite()
            && frame.sun.disc_direction.is_finite()
            && frame.sun.radius_rad.is_finite()
            && frame.sun.irradiance.is_finite()
            && frame.altitude_m.is_finite();
        if !finite {
            return Err(GpuError::View("the Sun and the observer's altitude must be finite".into()));
        }
        // The first slot is the metering view: the first view's whole picture.
        let whole = View { part: [0.0, 0.0, 1.0, 1.0], first_pixel: [0, 0], ..views[0] };
        let mut uniforms = Vec::with_capacity(views.len() + 1);
        for view in std::iter::once(&whole).chain(views) {
            view.check()?;
            uniforms.push(self.view_uniform(frame, view)?);
        }
        if uniforms.len() > self.capacity {
            self.capacity = uniforms.len().next_power_of_two();
            (self.view_buffer, self.view_group) =
                view_buffer(&self.device, &self.view_layout, self.view_stride, self.capacity);
        }
        self.turn = (self.turn + 1) % BELTS;
        let exposure = frame.output.exposure_for(self.target.output).factor();
        let compensation = frame.output.compensation_ev.exp2();
        let uniform = FrameUniform {
            sun_irradiance: frame.sun.irradiance as f32,
            exposure: exposure.map_or(0.0, |factor| (factor * compensation) as f32),
            steps: frame.steps.clamp(4, 4096),
            tonemap: frame.output.tonemap as u32,
            encoding: if self.target.colour.is_srgb() { 2 } else { 1 },
            dither_levels: if frame.output.dither { self.target.levels() } else { 0.0 },
            largest: self.target.largest().unwrap_or(1.0),
            compensation: compensation as f32,
            limb_darkening: if frame.sun.limb_darkening { self.air.limb_darkening } else { EVEN_DISC },
            ..self.air
        };
        self.write(encoder, self.frame_buffer.clone(), 0, bytemuck::bytes_of(&uniform));
        for (slot, uniform) in uniforms.iter().enumerate() {
            let offset = slot as u64 * self.view_stride;
            self.write(encoder, self.view_buffer.clone(), offset, bytemuck::bytes_of(uniform));
        }
        self.belts[self.turn].finish();
        // The one that the next frame will write to: its last use was three frames ago. Asked for now, it is mapped by then.
        self.belts[(self.turn + 1) % BELTS].recall();
        match exposure {
            None => self.record_metering(encoder, stamps),
            Some(factor) => self.meter.set(encoder, factor),
        }
        self.prepared = views.len();
        Ok(())
    }

    /// Draws a view of the prepared frame into the host's pass, at infinite depth. Sets its own pipeline and bind
    /// groups 0 and 1; touches nothing else. A view that was not prepared is left out with a warning.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        if view_index >= self.prepared {
            tracing::warn!(view_index, prepared = self.prepared, "the sky was not prepared for this view");
            return;
        }
        self.draw_slot(pass, &self.pipeline, view_index + 1);
    }

    /// One `Rgba32Float` texel whose red is the prepared frame's exposure factor, metered or fixed, before
    /// compensation: for shaders that expose the host's geometry as the sky is exposed. Read it with `textureLoad`;
    /// the format is not filterable. The view stays the same for the renderer's life.
    pub fn exposure_view(&self) -> &wgpu::TextureView {
        self.meter.exposure_view()
    }

    /// The texel that automatic exposure is kept in: factor, EV100, mean luminance.
    pub(crate) fn exposure_texture(&self) -> &wgpu::Texture {
        &self.meter.exposure
    }

    fn draw_slot(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline, slot: usize) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.frame_group, &[]);
        pass.set_bind_group(1, &self.view_group, &[(slot as u64 * self.view_stride) as u32]);
        pass.draw(0..3, 0..1);
    }

    fn record_metering(&self, encoder: &mut wgpu::CommandEncoder, mut stamps: Option<&mut Stamps>) {
        let pipeline = self.metering_pipeline.get_or_init(|| {
            let target = Target::new(meter::FORMAT, Output::Radiance);
            sky_pipeline(&self.device, &self.module, &self.pipeline_layout, &target, true)
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("metering picture"),
            color_attachments: &[Some(cleared(&self.meter.picture))],
            timestamp_writes: stamps.as_mut().and_then(|stamps| stamps.next("metering picture")),
            ..Default::default()
        });
        self.draw_slot(&mut pass, pipeline, 0);
        drop(pass);
        self.meter.reduce(encoder, stamps.and_then(|stamps| stamps.next("meter")));
    }

    fn write(&mut self, encoder: &mut wgpu::CommandEncoder, buffer: wgpu::Buffer, offset: u64, bytes: &[u8]) {
        if let Some(size) = wgpu::BufferSize::new(bytes.len() as u64) {
            self.belts[self.turn].write_buffer(encoder, &buffer, offset, size).copy_from_slice(bytes);
        }
    }

    fn view_uniform(&self, frame: &FrameState, view: &View) -> Result<ViewUniform, GpuError> {
        let radius_m = f64::from(self.air.bottom_radius_m);
        let r = radius_m + frame.altitude_m;
        // Where the camera is from the planet's centre; altitude as (r² − R²) / (r + R), which cancels nothing.
        let shift = view.enu_from_view.w_axis.truncate();
        let centre = shift + DVec3::new(0.0, 0.0, r);
        let excess =
            frame.altitude_m * (2.0 * radius_m + frame.altitude_m) + 2.0 * r * shift.z + shift.length_squared();
        let altitude_m = excess / (radius_m + (radius_m * radius_m + excess).max(0.0).sqrt());
        let view_from_enu = glam::DMat3::from_mat4(view.enu_from_view).transpose();
        let up = centre.normalize_or(DVec3::Z);
        let [ray_origin, ray_x, ray_y] = view.rays()?.map(|ray| ray.as_vec3().to_array());
        // The camera's heading on the horizon, for equirectangular pictures.
        let forward = view.enu_from_view.transform_vector3(-DVec3::Z);
        let level = (forward - up * forward.dot(up)).normalize_or(DVec3::Y);
        let into_view = |direction: DVec3| (view_from_enu * direction).normalize_or(DVec3::Z).as_vec3().to_array();
        let (projection, half_angle) = match view.projection {
            Projection::Matrix(_) => (0, 0.0),
            Projection::Fisheye(span) => (1, 0.5 * span as f32),
            Projection::Equirectangular => (2, 0.0),
        };
        let [left, bottom, width, height] = view.part.map(|value| value as f32);
        Ok(ViewUniform {
            ray_origin,
            projection,
            ray_x,
            half_angle,
            ray_y,
            aspect: view.aspect as f32,
            up: into_view(up),
            // Half a metre: f32 cannot hold less above a planet, and eyes are higher.
            altitude_m: (altitude_m as f32).max(0.5),
            sun_disc: into_view(frame.sun.disc_direction),
            sun_radius: frame.sun.radius_rad as f32,
            sun: into_view(frame.sun.direction),
            sun_disc_visible: u32::from(frame.sun.disc),
            east: into_view(level.cross(up)),
            padding_0: 0.0,
            north: into_view(level),
            padding_1: 0.0,
            tile: [2.0 * left + width - 1.0, 2.0 * bottom + height - 1.0, width, height],
            pixel: view.first_pixel.map(|pixel| pixel as f32),
            padding_2: [0.0; 2],
        })
    }
}

fn uniform_buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn view_buffer(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    stride: u64,
    capacity: usize,
) -> (wgpu::Buffer, wgpu::BindGroup) {
    let buffer = uniform_buffer(device, "sky views", stride * capacity as u64);
    let binding = wgpu::BufferBinding {
        buffer: &buffer,
        offset: 0,
        size: wgpu::BufferSize::new(size_of::<ViewUniform>() as u64),
    };
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("sky views"),
        layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(binding) }],
    });
    (buffer, group)
}

fn sky_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    target: &Target,
    metering: bool,
) -> wgpu::RenderPipeline {
    let reversed = matches!(target.depth, Some((_, DepthDirection::Reversed)));
    let far_depth = [("far_depth", if reversed { 0.0 } else { 1.0 })];
    let constants = [
        ("finished", f64::from(u8::from(target.output == Output::Display))),
        ("metering", f64::from(u8::from(metering))),
    ];
    let options = |constants| wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(if metering { "sky, metering" } else { "sky" }),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("sky_vertex"),
            compilation_options: options(&far_depth),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: target.depth.map(|(format, direction)| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(false),
            depth_compare: Some(match direction {
                DepthDirection::Standard => wgpu::CompareFunction::LessEqual,
                DepthDirection::Reversed => wgpu::CompareFunction::GreaterEqual,
            }),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("sky_fragment"),
            compilation_options: options(&constants),
            targets: &[Some(target.colour.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
