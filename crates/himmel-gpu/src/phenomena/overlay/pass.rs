//! The lines on the GPU, and the names after them.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DMat3;

use super::model::{LineKind, LineList, LinePiece, Overlay};
use super::names_pass::NamesPass;
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, bind, layout, module};
use crate::phenomena::stars::{ADDED, PointsUniform, pipeline_over_sky, view_of_points};
use crate::phenomena::sun::BendingUniform;
use crate::target::Target;
use crate::view::{Projection, View};

/// Views of a frame that have lines.
const MOST_VIEWS: usize = 64;

gpu_struct! {
    /// A piece of a line; the fields are explained in `lines.wgsl`.
    pub struct LineSegment {
        /// One end.
        pub start: [f32; 3],
        /// Of its colour.
        pub red: f32,
        /// The other end.
        pub end: [f32; 3],
        /// Of its colour.
        pub green: f32,
        /// Of its colour.
        pub blue: f32,
        /// Fills up.
        pub padding_0: f32,
        /// Fills up.
        pub padding_1: f32,
        /// Fills up.
        pub padding_2: f32,
    }
}

fn segment(piece: &LinePiece) -> LineSegment {
    let [red, green, blue] = match piece.kind {
        LineKind::Figure => [0.45, 0.6, 1.0],
        LineKind::Border => [0.8, 0.35, 0.35],
        LineKind::Equatorial => [0.35, 0.75, 0.85],
        LineKind::Horizontal => [0.4, 0.8, 0.4],
        LineKind::Ecliptic => [1.0, 0.8, 0.2],
    };
    let [start, end] = piece.ends.map(|end| end.as_vec3().to_array());
    LineSegment { start, red, end, green, blue, ..LineSegment::default() }
}

/// What is on the GPU of an overlay.
struct Uploaded {
    lines: Arc<LineList>,
    buffers: [(wgpu::Buffer, u32); 2],
    groups: Vec<wgpu::BindGroup>,
}

/// Draws lines and names into the host's pass.
pub(crate) struct Lines {
    device: wgpu::Device,
    target: Target,
    /// Made when lines are first drawn.
    module: Option<wgpu::ShaderModule>,
    layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    /// By whether the projection is a matrix, and whether lines are refracted.
    pipelines: HashMap<(bool, bool), wgpu::RenderPipeline>,
    uniforms: wgpu::Buffer,
    stride: u64,
    capacity: usize,
    uploaded: Option<Uploaded>,
    /// Whether each view's projection is a matrix.
    views: Vec<bool>,
    /// The layouts of the air and of a view.
    groups: [wgpu::BindGroupLayout; 2],
    /// Made when names are first drawn.
    names: Option<NamesPass>,
    /// Whether the target blends at all; points warn where it does not.
    blends: bool,
}

fn uniforms(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("lines"),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl Lines {
    /// `groups`: the layouts of the air and of a view.
    pub(crate) fn new(device: &wgpu::Device, target: &Target, groups: [&wgpu::BindGroupLayout; 2]) -> Self {
        let slots = [(0, Slot::Uniform(size_of::<PointsUniform>() as u64, true)), (4, Slot::Buffer(false))];
        let layout = layout(device, "lines", wgpu::ShaderStages::VERTEX_FRAGMENT, &slots);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("lines"),
            bind_group_layouts: &[Some(groups[0]), Some(groups[1]), Some(&layout)],
            immediate_size: 0,
        });
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let stride = (size_of::<PointsUniform>() as u64).next_multiple_of(alignment);
        let features = target.colour.guaranteed_format_features(device.features());
        Self {
            device: device.clone(),
            target: *target,
            module: None,
            layout,
            pipeline_layout,
            pipelines: HashMap::new(),
            uniforms: uniforms(device, 2 * stride),
            stride,
            capacity: 2,
            uploaded: None,
            views: Vec::new(),
            groups: groups.map(Clone::clone),
            names: None,
            blends: features.flags.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE),
        }
    }

    fn upload(&mut self, queue: &wgpu::Queue, lines: &Arc<LineList>) {
        if self.uploaded.as_ref().is_some_and(|uploaded| Arc::ptr_eq(&uploaded.lines, lines)) {
            return;
        }
        let buffers = [&lines.fixed, &lines.local].map(|pieces| {
            let segments: Vec<LineSegment> = pieces.iter().map(segment).collect();
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("line segments"),
                size: (segments.len().max(1) * size_of::<LineSegment>()) as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            if !segments.is_empty() {
                queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&segments));
            }
            (buffer, segments.len() as u32)
        });
        self.uploaded = Some(Uploaded { lines: Arc::clone(lines), buffers, groups: Vec::new() });
        self.bind();
    }

    fn bind(&mut self) {
        let Some(uploaded) = &mut self.uploaded else { return };
        let uniform = Bound::Part(&self.uniforms, size_of::<PointsUniform>() as u64);
        uploaded.groups = (uploaded.buffers.iter())
            .map(|(buffer, _)| bind(&self.device, "lines", &self.layout, &[(0, uniform), (4, Bound::Buffer(buffer))]))
            .collect();
    }

    /// Prepares a frame; `write` records an upload.
    pub(crate) fn prepare(
        &mut self,
        queue: &wgpu::Queue,
        overlay: Option<&Overlay>,
        lift: BendingUniform,
        views: &[View],
        write: &mut dyn FnMut(&wgpu::Buffer, u64, &[u8]),
    ) -> Result<(), GpuError> {
        self.views.clear();
        if let Some(names) = &mut self.names {
            names.clear();
        }
        let Some(overlay) = overlay.filter(|_| self.blends) else { return Ok(()) };
        let views = &views[..views.len().min(MOST_VIEWS)];
        if let Some(names) = &overlay.names {
            let pass = match &mut self.names {
                Some(pass) => pass,
                none => none.insert(NamesPass::new(&self.device, &self.target, self.groups.each_ref())?),
            };
            pass.prepare(queue, names, overlay.enu_from_icrs, lift, views, write)?;
        }
        if !overlay.params.any() {
            return Ok(());
        }
        self.upload(queue, &overlay.lines);
        if 2 * views.len() > self.capacity {
            self.capacity = (2 * views.len()).next_power_of_two();
            self.uniforms = uniforms(&self.device, self.stride * self.capacity as u64);
            self.bind();
        }
        let shader = match &self.module {
            Some(shader) => shader.clone(),
            None => self.module.insert(module(&self.device, "phenomena/overlay/lines.wgsl")?).clone(),
        };
        for (index, view) in views.iter().enumerate() {
            let Some(mut uniform) = view_of_points(view)? else { return Ok(()) };
            // The same uniform as points have: what lines do not need holds their width and strength.
            uniform.lift = lift;
            uniform.glare_floor = overlay.params.width_px as f32;
            uniform.seeing = overlay.params.strength as f32;
            let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
            for (list, turn) in [view_from_enu * overlay.enu_from_icrs, view_from_enu].into_iter().enumerate() {
                [uniform.view_from_list_x, uniform.view_from_list_y, uniform.view_from_list_z] =
                    [turn.x_axis, turn.y_axis, turn.z_axis].map(|axis| axis.as_vec3().to_array());
                write(&self.uniforms, (2 * index + list) as u64 * self.stride, bytemuck::bytes_of(&uniform));
            }
            let linear = matches!(view.projection, Projection::Matrix(_));
            for refracted in [true, false] {
                if !self.pipelines.contains_key(&(linear, refracted)) {
                    let on = |yes: bool| f64::from(u8::from(yes));
                    let constants = [("linear", on(linear)), ("refracted", on(refracted))];
                    let entries = ["line_vertex", "line_fragment"];
                    let pipeline = pipeline_over_sky(
                        &self.device,
                        &self.target,
                        &shader,
                        &self.pipeline_layout,
                        entries,
                        &constants,
                        ADDED,
                    );
                    self.pipelines.insert((linear, refracted), pipeline);
                }
            }
            self.views.push(linear);
        }
        Ok(())
    }

    /// Draws the lines and names of a view; groups 0 and 1 are those of its sky.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        self.draw_lines(pass, view_index);
        if let Some(names) = &self.names {
            names.draw(pass, view_index);
        }
    }

    fn draw_lines(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        let (Some(&linear), Some(uploaded)) = (self.views.get(view_index), &self.uploaded) else { return };
        for (list, ((_, count), group)) in uploaded.buffers.iter().zip(&uploaded.groups).enumerate() {
            let Some(pipeline) = self.pipelines.get(&(linear, list == 0)) else { continue };
            if *count > 0 {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(2, group, &[((2 * view_index + list) as u64 * self.stride) as u32]);
                pass.draw(0..6 * count, 0..1);
            }
        }
    }
}
