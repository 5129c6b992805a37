//! Radiance along single rays by the renderer's own tables and march: `himmel radiance --solver gpu`.

use himmel_air::single::Ray;
use himmel_air::{AirQuality, Atmosphere};

use super::build::Pace;
use super::stations::{CELL_COLUMNS, view_slot};
use super::uniform::{AirUniform, MOST_BODIES};
use super::{Air, layers};
use crate::error::GpuError;
use crate::frame::{FrameUniform, ViewUniform};
use crate::gpu::Gpu;
use crate::layout::gpu_struct;
use crate::pass::{self, Bound, Slot, bind, compute, layout};

gpu_struct! {
    /// A ray that is asked for; the fields are explained in `query.wgsl`.
    pub struct Query {
        /// Altitude of the observer, m.
        pub altitude_m: f32,
        /// Zenith cosine of the ray.
        pub mu: f32,
        /// Its sine.
        pub sine: f32,
        /// Zenith cosine of the Sun.
        pub mu_s: f32,
        /// Cosine between the two.
        pub nu: f32,
        /// Angle between the two, rad.
        pub theta: f32,
        /// Fills up.
        pub padding_0: f32,
        /// Fills up.
        pub padding_1: f32,
    }
}

/// Rays of a dispatch: rows of their cell table.
const BATCH: usize = 1024;

/// What a ray sees, at the four wavelengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayAnswer {
    /// Per unit irradiance of the Sun, its disc excluded, sr⁻¹.
    pub radiance_per_sr: [f32; 4],
    /// From the observer to space; 0 where the ground is in the way.
    pub transmittance: [f32; 4],
}

/// The air of a renderer without a picture: answers rays.
pub struct RayMeter {
    gpu: Gpu,
    air: Air,
    frame: FrameUniform,
    frame_buffer: wgpu::Buffer,
    view_buffer: wgpu::Buffer,
    place: wgpu::ComputePipeline,
    answer: wgpu::ComputePipeline,
    medium_group: wgpu::BindGroup,
    view_groups: [wgpu::BindGroup; 2],
    query_group: [wgpu::BindGroup; 2],
    queries: wgpu::Buffer,
    answers: wgpu::Buffer,
    readable: wgpu::Buffer,
}

impl RayMeter {
    /// Compiles the passes and fills the air's tables to the last order. `progress` is told the share done and answers
    /// whether to go on.
    pub fn new(gpu: &Gpu, atmosphere: &Atmosphere, progress: &mut dyn FnMut(f64) -> bool) -> Result<Self, GpuError> {
        let device = &gpu.device;
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let readable = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let buffer = |label, size: usize, usage| {
            let size = size as u64;
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let frame_buffer = buffer("query frame", size_of::<FrameUniform>(), uniform);
        let view_buffer = buffer("query view", size_of::<ViewUniform>(), uniform);
        let queries = buffer("queries", BATCH * size_of::<Query>(), storage);
        let answers = buffer("answers", BATCH * 32, storage);
        let readable = buffer("answers, readable", BATCH * 32, readable);
        let texture = |label, [width, height]: [u32; 2], format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | usage,
                view_formats: &[],
            })
        };
        let written = wgpu::TextureUsages::STORAGE_BINDING;
        let format = wgpu::TextureFormat::Rg32Float;
        let cells = texture("query cells", [CELL_COLUMNS, BATCH as u32 + 1], format, written);
        let exposure = texture("query exposure", [1, 1], wgpu::TextureFormat::Rgba32Float, written);
        let exposure = exposure.create_view(&Default::default());
        let quality = atmosphere.quality().unwrap_or(AirQuality::Film);
        let sizes = Air::sizes_of(quality, atmosphere.steps());
        let air = Air::new(device, &gpu.queue, sizes, atmosphere, &frame_buffer, &exposure)?;

        let only = wgpu::ShaderStages::COMPUTE;
        let airs = Slot::Uniform((MOST_BODIES * size_of::<AirUniform>()) as u64, false);
        let medium_layout = layout(device, "medium", only, &[(1, airs), (2, Slot::Layers)]);
        let view_layout = layout(device, "query view", only, &[(0, view_slot())]);
        let marching_layout = layout(device, "query view, marching", only, &[(0, view_slot()), (1, Slot::Layers)]);
        let place_layout =
            layout(device, "query cells", only, &[(0, Slot::WriteLayers(format)), (1, Slot::Buffer(false))]);
        let answer_layout = layout(device, "queries", only, &[(1, Slot::Buffer(false)), (2, Slot::Buffer(true))]);
        let module = pass::module(device, "phenomena/air/query.wgsl")?;
        let constants = air.constants();
        let place =
            compute(device, &module, "place_queries", &constants, &[&medium_layout, &view_layout, &place_layout]);
        let answer =
            compute(device, &module, "answer_queries", &constants, &[&air.layout, &marching_layout, &answer_layout]);
        let density = layers(&air.tables.density);
        let medium = [(1, Bound::Buffer(&air.tables.uniforms)), (2, Bound::View(&density))];
        let cells = layers(&cells);
        let view = (0, Bound::Part(&view_buffer, size_of::<ViewUniform>() as u64));
        let mut meter = Self {
            gpu: gpu.clone(),
            frame: FrameUniform { steps: air.sizes.steps, light_count: 1, ..FrameUniform::default() },
            medium_group: bind(device, "medium", &medium_layout, &medium),
            view_groups: [
                bind(device, "query view", &view_layout, &[view]),
                bind(device, "query view, marching", &marching_layout, &[view, (1, Bound::View(&cells))]),
            ],
            query_group: [
                bind(device, "query cells", &place_layout, &[(0, Bound::View(&cells)), (1, Bound::Buffer(&queries))]),
                bind(device, "queries", &answer_layout, &[(1, Bound::Buffer(&queries)), (2, Bound::Buffer(&answers))]),
            ],
            air,
            frame_buffer,
            view_buffer,
            place,
            answer,
            queries,
            answers,
            readable,
        };
        meter.build(progress)?;
        Ok(meter)
    }

    fn build(&mut self, progress: &mut dyn FnMut(f64) -> bool) -> Result<(), GpuError> {
        let queue = self.gpu.queue.clone();
        while let Some(state) = self.air.rebuilding() {
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            // Written before the submission, so one submission for each set of passes.
            self.air.build(&self.gpu.device, &mut encoder, Pace::Samples(1e7), &mut |_, buffer, offset, bytes| {
                queue.write_buffer(buffer, offset, bytes);
            });
            queue.submit([encoder.finish()]);
            self.gpu.wait()?;
            if !progress(f64::from(state.progress)) {
                return Err(GpuError::Cancelled);
            }
        }
        Ok(())
    }

    /// Memory of the tables in bytes.
    pub fn table_bytes(&self) -> u64 {
        self.air.bytes()
    }

    /// What each ray sees, with the Sun's disc left out.
    pub fn answer(&mut self, rays: &[Ray]) -> Result<Vec<RayAnswer>, GpuError> {
        let mut found = Vec::with_capacity(rays.len());
        let queue = &self.gpu.queue;
        queue.write_buffer(&self.frame_buffer, 0, bytemuck::bytes_of(&self.frame));
        queue.write_buffer(&self.view_buffer, 0, bytemuck::bytes_of(&ViewUniform::default()));
        for batch in rays.chunks(BATCH) {
            let mut queries: Vec<Query> = batch.iter().map(query).collect();
            queries.resize(BATCH, Query::default());
            queue.write_buffer(&self.queries, 0, bytemuck::cast_slice(&queries));
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_compute_pass(&Default::default());
            let groups = (BATCH as u32).div_ceil(64);
            pass.set_pipeline(&self.place);
            pass.set_bind_group(0, &self.medium_group, &[]);
            pass.set_bind_group(1, &self.view_groups[0], &[0]);
            pass.set_bind_group(2, &self.query_group[0], &[]);
            pass.dispatch_workgroups(groups, 1, 1);
            pass.set_pipeline(&self.answer);
            pass.set_bind_group(0, &self.air.group, &[]);
            pass.set_bind_group(1, &self.view_groups[1], &[0]);
            pass.set_bind_group(2, &self.query_group[1], &[]);
            pass.dispatch_workgroups(groups, 1, 1);
            drop(pass);
            encoder.copy_buffer_to_buffer(&self.answers, 0, &self.readable, 0, self.readable.size());
            queue.submit([encoder.finish()]);
            let bytes = self.gpu.read_buffer(&self.readable, batch.len() as u64 * 32)?;
            found.extend(bytes.chunks_exact(32).map(|chunk| {
                let [radiance_per_sr, transmittance]: [[f32; 4]; 2] = bytemuck::pod_read_unaligned(chunk);
                RayAnswer { radiance_per_sr, transmittance }
            }));
        }
        Ok(found)
    }
}

fn query(ray: &Ray) -> Query {
    let nu = ray.nu.clamp(-1.0, 1.0);
    Query {
        altitude_m: ray.altitude_m as f32,
        mu: ray.mu as f32,
        sine: (1.0 - ray.mu * ray.mu).max(0.0).sqrt() as f32,
        mu_s: ray.mu_s as f32,
        nu: nu as f32,
        theta: nu.acos() as f32,
        ..Query::default()
    }
}
