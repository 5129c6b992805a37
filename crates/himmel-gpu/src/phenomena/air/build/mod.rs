//! Fills the tables that depend on the medium alone: optical depth, then the moments, order by order.
//!
//! An edit of the air is a list of steps; every frame does as many as its budget allows. The first are the optical
//! depth and a draft of order 1, so that the next frame is right to order 2 already; then the sums proper.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use himmel_air::moments::Quality;
use himmel_core::quadrature::gauss_legendre_unit;

use super::sizes::AirSizes;
use super::tables::Tables;
use super::uniform::AirUniform;
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::pass::{self, Bound, Slot, bind, compute, layers, layout};

gpu_struct! {
    /// Of one pass; the fields are explained in `build.wgsl`.
    pub struct BuildUniform {
        /// Rows of the moment table.
        pub rows: u32,
        /// Its columns.
        pub columns: u32,
        /// Directions above the horizon.
        pub up: u32,
        /// Below it.
        pub down: u32,
        /// Azimuths over half a circle.
        pub azimuths: u32,
        /// The same for deep Suns.
        pub deep_up: u32,
        /// Below the horizon.
        pub deep_down: u32,
        /// Azimuths.
        pub deep_azimuths: u32,
        /// Cells of the march that prepares a ray.
        pub fine_cells: u32,
        /// Cells of a ray.
        pub cells: u32,
        /// Cells of its cumulative table.
        pub cumulative_cells: u32,
        /// Samples in its lit part.
        pub lit_samples: u32,
        /// Which body.
        pub body: u32,
        /// Which order.
        pub order: u32,
        /// First row of the pass.
        pub first_row: u32,
        /// Rows of the pass.
        pub row_count: u32,
        /// When the orders end.
        pub tolerance: f32,
        /// Fills up.
        pub padding_0: u32,
        /// Fills up.
        pub padding_1: u32,
        /// Fills up.
        pub padding_2: u32,
    }
}

/// Orders that the buffer of changes has room for.
pub(crate) const MOST_ORDERS: usize = 256;
/// Rows whose cumulative tables exist at a time: bounds the memory of order 1.
const SLICE: u32 = 8;
/// Passes that one frame may record: slots of the uniform buffer.
const MOST_PASSES: usize = 256;

/// One pass of a rebuild.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Depth,
    /// Rays and order 1 of some rows; draft or not.
    First {
        draft: bool,
        first_row: u32,
        row_count: u32,
    },
    Next {
        order: u32,
        first_row: u32,
        row_count: u32,
    },
    /// Adds an order to the tables.
    Resolve {
        draft: bool,
        order: u32,
    },
}

/// Uploads bytes to a place in a buffer, in the order of the encoder.
pub(crate) type Upload<'a> = dyn FnMut(&mut wgpu::CommandEncoder, &wgpu::Buffer, u64, &[u8]) + 'a;

/// How much of a rebuild a frame does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// All orders at once: for pictures.
    AtOnce,
    /// About so many samples a frame (an order of the default table has 4 to 5 million); at least one pass.
    Samples(f64),
}

/// How far a rebuild is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rebuild {
    /// Orders of scattering that the tables hold; the sky shows one more.
    pub orders: u32,
    /// The most that it will compute; it ends earlier once they no longer change anything.
    pub most_orders: u32,
    /// Largest relative change by the last order that is known.
    pub last_change: Option<f32>,
    /// Share of the work that is done, as far as can be told.
    pub progress: f32,
    /// Samples of all orders so far.
    pub samples: f64,
}

/// Largest change by each order as read back, without waiting.
#[derive(Default)]
struct Changes {
    in_flight: bool,
    values: Vec<f32>,
}

/// The passes and their buffers.
pub(crate) struct Builder {
    quality: Quality,
    draft: Quality,
    depth_size: [u32; 2],
    depth_pipeline: wgpu::ComputePipeline,
    rays_pipeline: wgpu::ComputePipeline,
    first_pipeline: wgpu::ComputePipeline,
    next_pipeline: wgpu::ComputePipeline,
    resolve_pipeline: wgpu::ComputePipeline,
    /// Layouts of the groups that hold tables: medium, with depth, depth, resolve.
    table_layouts: [wgpu::BindGroupLayout; 4],
    medium_group: wgpu::BindGroup,
    with_depth_group: wgpu::BindGroup,
    depth_group: wgpu::BindGroup,
    uniform_group: wgpu::BindGroup,
    rays_groups: [wgpu::BindGroup; 2],
    first_group: wgpu::BindGroup,
    next_group: wgpu::BindGroup,
    resolve_group: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    uniform_stride: u64,
    body_uniform: wgpu::Buffer,
    moments: wgpu::Buffer,
    stored: wgpu::Buffer,
    changes: wgpu::Buffer,
    read_back: wgpu::Buffer,
    bytes: u64,
    read: Arc<Mutex<Changes>>,
    steps: VecDeque<Step>,
    body: u32,
    total_cost: f64,
    done_cost: f64,
    orders: u32,
    /// Whether it was stopped before its end.
    cancelled: bool,
}

fn directions(quality: &Quality) -> (u32, u32) {
    let [up, down, _] = quality.directions;
    let [deep_up, deep_down, _] = quality.deep_directions;
    ((up + down) as u32, (deep_up + deep_down) as u32)
}

fn rays_per_row(quality: &Quality) -> u64 {
    let (day, deep) = directions(quality);
    u64::from(day + deep)
}

/// The groups that hold tables: medium, with depth, depth, resolve.
fn table_groups(
    device: &wgpu::Device,
    [medium, with_depth, depth, resolve]: &[wgpu::BindGroupLayout; 4],
    [body, moments, stored, changes]: [&wgpu::Buffer; 4],
    tables: &Tables,
) -> [wgpu::BindGroup; 4] {
    let density_view = layers(&tables.density);
    let depth_view = layers(&tables.depth);
    let moments_view = layers(&tables.moments);
    let ground_view = tables.ground.create_view(&Default::default());
    let bound = [(1, Bound::Buffer(&tables.uniforms)), (2, Bound::View(&density_view)), (3, Bound::View(&depth_view))];
    [
        bind(device, "medium", medium, &bound[..2]),
        bind(device, "medium and depth", with_depth, &bound),
        bind(device, "depth", depth, &[(0, Bound::Buffer(body)), (1, Bound::View(&depth_view))]),
        bind(
            device,
            "resolve",
            resolve,
            &[
                (0, Bound::Buffer(moments)),
                (1, Bound::Buffer(stored)),
                (2, Bound::Buffer(changes)),
                (3, Bound::View(&moments_view)),
                (4, Bound::View(&ground_view)),
            ],
        ),
    ]
}

impl Builder {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        sizes: &AirSizes,
        tables: &Tables,
        body: usize,
    ) -> Result<Self, GpuError> {
        let quality = sizes.moments.sane();
        let draft = Quality {
            directions: [4, 3, 3],
            deep_directions: [5, 4, 4],
            fine_cells: 60,
            cells: 1,
            cumulative_cells: 24,
            lit_samples: 6,
            ..quality.clone()
        };
        let buffer = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let rows = quality.rows as u64;
        let texels = rows * quality.columns as u64;
        let per_ray = (3 + 5 * quality.cells as u64) * 16;
        let rays = buffer("moment rays", rows * rays_per_row(&quality) * per_ray, storage);
        let per_cumulative = (quality.cumulative_cells as u64 + 1) * 4 * 16;
        // The draft takes all rows at once, with far fewer directions and entries.
        let draft_cumulative = rows * rays_per_row(&draft) * (draft.cumulative_cells as u64 + 1) * 4 * 16;
        let cumulative_bytes = (u64::from(SLICE) * rays_per_row(&quality) * per_cumulative).max(draft_cumulative);
        let cumulative = buffer("moment ray sums", cumulative_bytes, storage);
        let moments = buffer("moment orders", texels * (3 * 7 + 1) * 16, storage);
        let stored = buffer("moment order before", texels * 7 * 16, storage);
        let changes = buffer("moment changes", MOST_ORDERS as u64 * 4, storage);
        let read_back = buffer(
            "moment changes, read back",
            MOST_ORDERS as u64 * 4,
            wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        );
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let uniform_stride = (size_of::<BuildUniform>() as u64).next_multiple_of(alignment);
        let uniform_usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniforms = buffer("moment passes", uniform_stride * MOST_PASSES as u64, uniform_usage);
        let body_uniform = buffer("moment body", 16, uniform_usage);
        let node_list = |quality: &Quality| -> Vec<[f32; 2]> {
            let [up, down, _] = quality.directions;
            let [deep_up, deep_down, _] = quality.deep_directions;
            [up, down, deep_up, deep_down]
                .into_iter()
                .flat_map(gauss_legendre_unit)
                .map(|(x, w)| [x as f32, w as f32])
                .collect()
        };
        let nodes = [&quality, &draft].map(|quality| {
            let list = node_list(quality);
            let nodes = buffer("moment directions", list.len() as u64 * 8, storage);
            queue.write_buffer(&nodes, 0, bytemuck::cast_slice(&list));
            nodes
        });

        let only = wgpu::ShaderStages::COMPUTE;
        let airs = Slot::Uniform((super::uniform::MOST_BODIES * size_of::<AirUniform>()) as u64, false);
        let medium_layout = layout(device, "medium", only, &[(1, airs), (2, Slot::Layers)]);
        let with_depth_layout =
            layout(device, "medium and depth", only, &[(1, airs), (2, Slot::Layers), (3, Slot::Layers)]);
        let format = wgpu::TextureFormat::Rgba32Float;
        let depth_layout =
            layout(device, "depth", only, &[(0, Slot::Uniform(16, false)), (1, Slot::WriteLayers(format))]);
        let uniform_layout =
            layout(device, "moment pass", only, &[(0, Slot::Uniform(size_of::<BuildUniform>() as u64, true))]);
        let (read, write) = (Slot::Buffer(false), Slot::Buffer(true));
        let rays_layout = layout(device, "rays", only, &[(0, read), (1, write), (2, write)]);
        let first_layout = layout(device, "first", only, &[(0, write), (1, write), (4, read)]);
        let next_layout = layout(device, "next", only, &[(0, write), (1, write), (2, write), (3, write)]);
        let resolve_layout = layout(
            device,
            "resolve",
            only,
            &[(0, write), (1, write), (2, write), (3, Slot::WriteLayers(format)), (4, Slot::Write(format))],
        );
        let constants = tables.constants(body..body + 1);
        let pipeline = |root, entry, groups: &[&wgpu::BindGroupLayout]| -> Result<_, GpuError> {
            Ok(compute(device, &pass::module(device, root)?, entry, &constants[..1], groups))
        };
        let rays_groups = [&nodes[0], &nodes[1]].map(|nodes| {
            let bound = [(0, Bound::Buffer(nodes)), (1, Bound::Buffer(&rays)), (2, Bound::Buffer(&cumulative))];
            bind(device, "rays", &rays_layout, &bound)
        });
        let table_layouts =
            [medium_layout.clone(), with_depth_layout.clone(), depth_layout.clone(), resolve_layout.clone()];
        let buffers = [&body_uniform, &moments, &stored, &changes];
        let [medium_group, with_depth_group, depth_group, resolve_group] =
            table_groups(device, &table_layouts, buffers, tables);
        Ok(Self {
            depth_size: sizes.depth,
            depth_pipeline: pipeline("phenomena/air/depth.wgsl", "fill_depth", &[&medium_layout, &depth_layout])?,
            rays_pipeline: pipeline(
                "phenomena/air/build/rays.wgsl",
                "follow_rays",
                &[&medium_layout, &uniform_layout, &rays_layout],
            )?,
            first_pipeline: pipeline(
                "phenomena/air/build/first.wgsl",
                "fill_first",
                &[&with_depth_layout, &uniform_layout, &first_layout],
            )?,
            next_pipeline: pipeline(
                "phenomena/air/build/next.wgsl",
                "fill_next",
                &[&medium_layout, &uniform_layout, &next_layout],
            )?,
            resolve_pipeline: pipeline(
                "phenomena/air/build/resolve.wgsl",
                "resolve",
                &[&medium_layout, &uniform_layout, &resolve_layout],
            )?,
            medium_group,
            with_depth_group,
            depth_group,
            resolve_group,
            table_layouts,
            uniform_group: bind(
                device,
                "moment pass",
                &uniform_layout,
                &[(0, Bound::Part(&uniforms, size_of::<BuildUniform>() as u64))],
            ),
            rays_groups,
            first_group: bind(
                device,
                "first",
                &first_layout,
                &[(0, Bound::Buffer(&rays)), (1, Bound::Buffer(&moments)), (4, Bound::Buffer(&cumulative))],
            ),
            next_group: bind(
                device,
                "next",
                &next_layout,
                &[
                    (0, Bound::Buffer(&rays)),
                    (1, Bound::Buffer(&moments)),
                    (2, Bound::Buffer(&stored)),
                    (3, Bound::Buffer(&changes)),
                ],
            ),
            bytes: [&rays, &cumulative, &moments, &stored, &changes, &uniforms].iter().map(|b| b.size()).sum(),
            uniforms,
            uniform_stride,
            body_uniform,
            moments,
            stored,
            changes,
            read_back,
            read: Arc::default(),
            steps: VecDeque::new(),
            body: 0,
            total_cost: 0.0,
            done_cost: 0.0,
            orders: 0,
            cancelled: false,
            quality,
            draft,
        })
    }

    /// Fills other tables from now on, which hold what the old ones did.
    pub(crate) fn rebind(&mut self, device: &wgpu::Device, tables: &Tables) {
        let buffers = [&self.body_uniform, &self.moments, &self.stored, &self.changes];
        [self.medium_group, self.with_depth_group, self.depth_group, self.resolve_group] =
            table_groups(device, &self.table_layouts, buffers, tables);
    }

    /// Memory of the buffers in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Starts anew for a body. `draft`: whether a coarse order 1 comes first.
    pub(crate) fn begin(&mut self, body: u32, draft: bool) {
        let rows = self.quality.rows as u32;
        let orders = self.quality.max_orders.min(MOST_ORDERS - 1) as u32;
        let mut steps = VecDeque::from([Step::Depth]);
        if draft && orders > 0 {
            steps.push_back(Step::First { draft: true, first_row: 0, row_count: rows });
            steps.push_back(Step::Resolve { draft: true, order: 1 });
        }
        let slices = |of: &dyn Fn(u32, u32) -> Step| -> Vec<Step> {
            (0..rows).step_by(SLICE as usize).map(|row| of(row, SLICE.min(rows - row))).collect()
        };
        for order in 1..=orders {
            steps.extend(slices(&|first_row, row_count| match order {
                1 => Step::First { draft: false, first_row, row_count },
                _ => Step::Next { order, first_row, row_count },
            }));
            steps.push_back(Step::Resolve { draft: false, order });
        }
        self.body = body;
        self.total_cost = steps.iter().map(|step| self.cost(step)).sum();
        self.done_cost = 0.0;
        self.orders = 0;
        self.cancelled = false;
        self.steps = steps;
        if let Ok(mut read) = self.read.lock() {
            read.values.clear();
        }
    }

    /// Stops; the tables keep the orders that they have.
    pub(crate) fn cancel(&mut self) {
        self.cancelled |= !self.steps.is_empty();
        self.steps.clear();
    }

    /// The tables are filled from elsewhere: nothing is left to do.
    pub(crate) fn finish(&mut self) {
        self.steps.clear();
        self.cancelled = false;
    }

    /// Whether the tables hold all orders.
    pub(crate) fn is_complete(&self) -> bool {
        self.steps.is_empty() && !self.cancelled
    }

    /// How far it is; `None` if nothing is left to do.
    pub(crate) fn state(&self) -> Option<Rebuild> {
        if self.steps.is_empty() {
            return None;
        }
        let last_change = self.read.lock().ok().and_then(|read| read.values.last().copied());
        // Orders fall by about the same factor each: how many are left follows from the last change.
        let by_cost = self.done_cost / self.total_cost.max(1.0);
        let by_change = match last_change {
            Some(change) if change > 0.0 && change < 1.0 => {
                (f64::from(change).ln() / self.quality.tolerance.max(1e-6).ln()).clamp(0.0, 1.0)
            }
            _ => 0.0,
        };
        Some(Rebuild {
            orders: self.orders,
            most_orders: self.quality.max_orders as u32,
            last_change,
            progress: by_cost.max(by_change).min(0.99) as f32,
            samples: self.done_cost,
        })
    }

    /// Samples of a pass.
    fn cost(&self, step: &Step) -> f64 {
        let (quality, rows, samples) = match *step {
            Step::Depth => return f64::from(self.depth_size[0] * self.depth_size[1]) * 96.0 * 0.25,
            Step::Resolve { .. } => return 2e3,
            Step::First { draft, row_count, .. } => {
                let quality = if draft { &self.draft } else { &self.quality };
                (quality, row_count, quality.lit_samples)
            }
            Step::Next { row_count, .. } => (&self.quality, row_count, self.quality.cells),
        };
        let [up, down, azimuths] = quality.directions;
        let [deep_up, deep_down, deep_azimuths] = quality.deep_directions;
        // About a third of the columns are deep.
        let directions = ((up + down) * azimuths) as f64 * 0.67 + ((deep_up + deep_down) * deep_azimuths) as f64 * 0.33;
        f64::from(rows) * quality.columns as f64 * directions * samples as f64
    }

    fn uniform(&self, step: &Step) -> BuildUniform {
        let draft = matches!(step, Step::First { draft: true, .. } | Step::Resolve { draft: true, .. });
        let quality = if draft { &self.draft } else { &self.quality };
        let (order, first_row, row_count) = match *step {
            Step::First { first_row, row_count, .. } => (1, first_row, row_count),
            Step::Next { order, first_row, row_count } => (order, first_row, row_count),
            Step::Resolve { order, .. } => (order, 0, quality.rows as u32),
            Step::Depth => (0, 0, 0),
        };
        let [up, down, azimuths] = quality.directions.map(|count| count as u32);
        let [deep_up, deep_down, deep_azimuths] = quality.deep_directions.map(|count| count as u32);
        BuildUniform {
            rows: quality.rows as u32,
            columns: quality.columns as u32,
            up,
            down,
            azimuths,
            deep_up,
            deep_down,
            deep_azimuths,
            fine_cells: quality.fine_cells as u32,
            cells: quality.cells as u32,
            cumulative_cells: quality.cumulative_cells as u32,
            lit_samples: quality.lit_samples as u32,
            body: self.body,
            order,
            first_row,
            row_count,
            tolerance: quality.tolerance as f32,
            ..BuildUniform::default()
        }
    }

    /// Records passes until the budget is used up. `write`: uploads bytes to a buffer in the order of the encoder.
    pub(crate) fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pace: Pace,
        write: &mut Upload<'_>,
    ) {
        if self.steps.is_empty() {
            return;
        }
        if self.has_converged(device) {
            self.steps.clear();
            return;
        }
        let mut budget = match pace {
            Pace::AtOnce => f64::INFINITY,
            Pace::Samples(samples) => samples.max(1.0),
        };
        let mut taken = Vec::new();
        while taken.len() < MOST_PASSES {
            let Some(step) = self.steps.front().copied() else { break };
            let cost = self.cost(&step);
            if !taken.is_empty() && cost > budget {
                break;
            }
            budget -= cost;
            self.done_cost += cost;
            taken.push(step);
            self.steps.pop_front();
            // One order a frame at most, unless all are wanted at once.
            let ends_frame = matches!(step, Step::Resolve { .. }) && pace != Pace::AtOnce;
            if ends_frame {
                break;
            }
        }
        for (slot, step) in taken.iter().enumerate() {
            let uniform = self.uniform(step);
            write(encoder, &self.uniforms, slot as u64 * self.uniform_stride, bytemuck::bytes_of(&uniform));
        }
        write(encoder, &self.body_uniform, 0, bytemuck::cast_slice(&[self.body, 0, 0, 0]));
        if taken.iter().any(|step| matches!(step, Step::Depth)) {
            encoder.clear_buffer(&self.changes, 0, None);
        }
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("air tables"), ..Default::default() });
        let mut resolved = false;
        for (slot, step) in taken.iter().enumerate() {
            let offset = (slot as u64 * self.uniform_stride) as u32;
            pass.set_bind_group(1, &self.uniform_group, &[offset]);
            match *step {
                Step::Depth => {
                    pass.set_pipeline(&self.depth_pipeline);
                    pass.set_bind_group(0, &self.medium_group, &[]);
                    pass.set_bind_group(1, &self.depth_group, &[]);
                    pass.dispatch_workgroups(self.depth_size[0].div_ceil(8), self.depth_size[1].div_ceil(8), 1);
                }
                Step::First { draft, row_count, .. } => {
                    let quality = if draft { &self.draft } else { &self.quality };
                    pass.set_pipeline(&self.rays_pipeline);
                    pass.set_bind_group(0, &self.medium_group, &[]);
                    pass.set_bind_group(2, &self.rays_groups[usize::from(draft)], &[]);
                    pass.dispatch_workgroups((rays_per_row(quality) as u32).div_ceil(16), row_count, 1);
                    pass.set_pipeline(&self.first_pipeline);
                    pass.set_bind_group(0, &self.with_depth_group, &[]);
                    pass.set_bind_group(2, &self.first_group, &[]);
                    pass.dispatch_workgroups(quality.columns as u32, row_count, 1);
                }
                Step::Next { row_count, .. } => {
                    pass.set_pipeline(&self.next_pipeline);
                    pass.set_bind_group(0, &self.medium_group, &[]);
                    pass.set_bind_group(2, &self.next_group, &[]);
                    pass.dispatch_workgroups(self.quality.columns as u32, row_count, 1);
                }
                Step::Resolve { order, .. } => {
                    pass.set_pipeline(&self.resolve_pipeline);
                    pass.set_bind_group(0, &self.medium_group, &[]);
                    pass.set_bind_group(2, &self.resolve_group, &[]);
                    let (columns, rows) = (self.quality.columns as u32, self.quality.rows as u32);
                    pass.dispatch_workgroups(columns.div_ceil(8), rows.div_ceil(8), 1);
                    self.orders = order;
                    resolved = true;
                }
            }
        }
        drop(pass);
        if resolved && !self.steps.is_empty() {
            self.ask_for_changes(encoder);
        }
    }

    /// Asks for the changes so far, unless an answer is still on its way.
    fn ask_for_changes(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let Ok(mut read) = self.read.lock() else { return };
        if read.in_flight {
            return;
        }
        read.in_flight = true;
        let size = self.read_back.size();
        encoder.copy_buffer_to_buffer(&self.changes, 0, &self.read_back, 0, size);
        let (shared, buffer, orders) = (Arc::clone(&self.read), self.read_back.clone(), self.orders as usize);
        encoder.map_buffer_on_submit(&self.read_back, wgpu::MapMode::Read, .., move |result| {
            let Ok(mut read) = shared.lock() else { return };
            read.in_flight = false;
            if result.is_ok() {
                let mapped = buffer.slice(..).get_mapped_range();
                let values: &[f32] = bytemuck::cast_slice(&mapped);
                read.values = values.get(1..=orders).unwrap_or_default().to_vec();
                drop(mapped);
                buffer.unmap();
            }
        });
    }

    /// Whether an order is known to have changed next to nothing. Does not wait.
    fn has_converged(&self, device: &wgpu::Device) -> bool {
        // An error here is a lost device, which the caller finds out anyway.
        let _ = device.poll(wgpu::PollType::Poll);
        let Ok(read) = self.read.lock() else { return false };
        // Order 1 is all new.
        read.values.iter().skip(1).any(|&change| change < self.quality.tolerance as f32)
    }
}
