//! The names on the GPU.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::names::{Anchor, LabelKind, LabelList, MOST_NAMED_BODIES, Names, beside, faintest};
use super::names_params::NameColour;
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::output::tonemap::srgb_decode;
use crate::pass::{Bound, Slot, bind, layout, module};
use crate::phenomena::stars::{PointsUniform, pipeline_over_sky, view_of_points};
use crate::phenomena::sun::BendingUniform;
use crate::target::{Output, Target};
use crate::view::{Projection, View};

/// Magnitude of what is no star: never too faint.
const NO_STAR: f32 = -1e9;

gpu_struct! {
    /// A name; the fields are explained in `names.wgsl`.
    pub struct NameLabel {
        /// Where what it names is.
        pub place: [f32; 3],
        /// Annual parallax.
        pub parallax: f32,
        /// Motion.
        pub velocity: [f32; 3],
        /// Magnitude.
        pub magnitude: f32,
        /// What it stands beside.
        pub anchor: u32,
        /// Which body.
        pub number: u32,
        /// Shown from this scale on.
        pub from_scale: f32,
        /// Colour.
        pub kind: u32,
        /// Farthest left and right of what it names.
        pub reach: [f32; 2],
        /// Fills up.
        pub padding_0: u32,
        /// Fills up.
        pub padding_1: u32,
    }
}

gpu_struct! {
    /// A letter of a name; the fields are explained in `names.wgsl`.
    pub struct NameLetter {
        /// Its box.
        pub box_em: [f32; 4],
        /// Its box in the atlas.
        pub uv: [f32; 4],
        /// Its name.
        pub label: u32,
        /// Fills up.
        pub padding_0: u32,
        /// Fills up.
        pub padding_1: u32,
        /// Fills up.
        pub padding_2: u32,
    }
}

gpu_struct! {
    /// What the names of a view share; the fields are explained in `names.wgsl`.
    pub struct NamesUniform {
        /// First column of view-from-(east-north-up).
        pub view_from_enu_x: [f32; 3],
        /// Size of letters.
        pub em_px: f32,
        /// Second column.
        pub view_from_enu_y: [f32; 3],
        /// Em of a radian.
        pub scale: f32,
        /// Third column.
        pub view_from_enu_z: [f32; 3],
        /// Faintest star with a name.
        pub faintest: f32,
        /// Bodies.
        pub bodies: [[f32; 4]; MOST_NAMED_BODIES],
        /// On which side their names stand.
        pub beside: [[f32; 4]; MOST_NAMED_BODIES],
        /// By kind.
        pub colours: [[f32; 4]; LabelKind::COUNT],
    }
}

/// A list on the GPU.
struct Uploaded {
    list: Arc<LabelList>,
    labels: wgpu::Buffer,
    letters: wgpu::Buffer,
    /// Where each name's letters begin, and where the last one's end.
    starts: Vec<u32>,
    /// How far names of bodies reach, em.
    reaches: [f64; MOST_NAMED_BODIES],
    atlas: wgpu::TextureView,
    group: wgpu::BindGroup,
}

/// Uniforms of views: those of points, those of names.
struct Uniforms {
    buffers: [wgpu::Buffer; 2],
    strides: [u64; 2],
    capacity: usize,
}

const SIZES: [usize; 2] = [size_of::<PointsUniform>(), size_of::<NamesUniform>()];

impl Uniforms {
    fn new(device: &wgpu::Device, capacity: usize) -> Self {
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let strides = SIZES.map(|size| (size as u64).next_multiple_of(alignment));
        let buffers = strides.map(|stride| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("names"),
                size: stride * capacity as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        Self { buffers, strides, capacity }
    }
}

/// Draws names into the host's pass. Made when a frame first has some.
pub(super) struct NamesPass {
    device: wgpu::Device,
    target: Target,
    module: wgpu::ShaderModule,
    sampler: wgpu::Sampler,
    layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    /// By whether the projection is a matrix.
    pipelines: HashMap<bool, wgpu::RenderPipeline>,
    uniforms: Uniforms,
    uploaded: Option<Uploaded>,
    /// Of each view: whether its projection is a matrix, and how many letters are drawn.
    views: Vec<Option<(bool, u32)>>,
}

impl NamesPass {
    /// `groups`: the layouts of the air and of a view.
    pub(super) fn new(
        device: &wgpu::Device,
        target: &Target,
        groups: [&wgpu::BindGroupLayout; 2],
    ) -> Result<Self, GpuError> {
        let slots = [
            (0, Slot::Uniform(SIZES[0] as u64, true)),
            (8, Slot::Buffer(false)),
            (9, Slot::Buffer(false)),
            (10, Slot::Uniform(SIZES[1] as u64, true)),
            (11, Slot::FilteredTable),
            (12, Slot::Sampler),
        ];
        let layout = layout(device, "names", wgpu::ShaderStages::VERTEX_FRAGMENT, &slots);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("names"),
            bind_group_layouts: &[Some(groups[0]), Some(groups[1]), Some(&layout)],
            immediate_size: 0,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("letters"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Ok(Self {
            device: device.clone(),
            target: *target,
            module: module(device, "phenomena/overlay/names.wgsl")?,
            sampler,
            layout,
            pipeline_layout,
            pipelines: HashMap::new(),
            uniforms: Uniforms::new(device, 1),
            uploaded: None,
            views: Vec::new(),
        })
    }

    /// Nothing is drawn until the next frame with names.
    pub(super) fn clear(&mut self) {
        self.views.clear();
    }

    fn upload(&mut self, queue: &wgpu::Queue, list: &Arc<LabelList>) {
        if self.uploaded.as_ref().is_some_and(|uploaded| Arc::ptr_eq(&uploaded.list, list)) {
            return;
        }
        let labels: Vec<NameLabel> = list.laid().iter().map(label_of).collect();
        let mut reaches = [0.0; MOST_NAMED_BODIES];
        for laid in list.laid() {
            if let Anchor::Body(index) = laid.label.anchor
                && let Some(reach) = reaches.get_mut(index)
            {
                *reach = laid.reach[1];
            }
        }
        let (letters, atlas) = list.letters();
        let mut starts = vec![0; labels.len() + 1];
        for letter in &letters {
            starts[letter.label + 1] += 1;
        }
        for index in 0..labels.len() {
            starts[index + 1] += starts[index];
        }
        let letters: Vec<NameLetter> = (letters.iter())
            .map(|letter| NameLetter {
                box_em: letter.box_em,
                uv: letter.uv,
                label: letter.label as u32,
                ..NameLetter::default()
            })
            .collect();
        let size = wgpu::Extent3d { width: atlas.width, height: atlas.height, depth_or_array_layers: 1 };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("letters"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(atlas.width), rows_per_image: None };
        queue.write_texture(texture.as_image_copy(), &atlas.texels, rows, size);
        let (labels, letters) = (
            filled(&self.device, queue, "labels", bytemuck::cast_slice(&labels), size_of::<NameLabel>()),
            filled(&self.device, queue, "letters", bytemuck::cast_slice(&letters), size_of::<NameLetter>()),
        );
        let atlas = texture.create_view(&Default::default());
        let group = self.group(&labels, &letters, &atlas);
        self.uploaded = Some(Uploaded { list: Arc::clone(list), labels, letters, starts, reaches, atlas, group });
    }

    fn group(&self, labels: &wgpu::Buffer, letters: &wgpu::Buffer, atlas: &wgpu::TextureView) -> wgpu::BindGroup {
        let [points, names] = &self.uniforms.buffers;
        let bound = [
            (0, Bound::Part(points, SIZES[0] as u64)),
            (8, Bound::Buffer(labels)),
            (9, Bound::Buffer(letters)),
            (10, Bound::Part(names, SIZES[1] as u64)),
            (11, Bound::View(atlas)),
            (12, Bound::Sampler(&self.sampler)),
        ];
        bind(&self.device, "names", &self.layout, &bound)
    }

    /// Prepares a frame; `write` records an upload.
    pub(super) fn prepare(
        &mut self,
        queue: &wgpu::Queue,
        names: &Names,
        enu_from_icrs: DMat3,
        lift: BendingUniform,
        views: &[View],
        write: &mut dyn FnMut(&wgpu::Buffer, u64, &[u8]),
    ) -> Result<(), GpuError> {
        self.views.clear();
        self.upload(queue, &names.list);
        if views.len() > self.uniforms.capacity {
            self.uniforms = Uniforms::new(&self.device, views.len().next_power_of_two());
            let Some(uploaded) = &self.uploaded else { return Ok(()) };
            let group = self.group(&uploaded.labels, &uploaded.letters, &uploaded.atlas);
            if let Some(uploaded) = &mut self.uploaded {
                uploaded.group = group;
            }
        }
        let Some(uploaded) = &self.uploaded else { return Ok(()) };
        let colours = colours(names, &self.target);
        for (index, view) in views.iter().enumerate() {
            let Some(mut points) = view_of_points(view)? else {
                self.views.push(None);
                continue;
            };
            points.lift = lift;
            points.years = names.years_since_j2000 as f32;
            points.beta = names.beta.as_vec3().to_array();
            points.observer_au = names.observer_au.as_vec3().to_array();
            let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
            let columns = |turn: DMat3| [turn.x_axis, turn.y_axis, turn.z_axis].map(|axis| axis.as_vec3().to_array());
            [points.view_from_list_x, points.view_from_list_y, points.view_from_list_z] =
                columns(view_from_enu * enu_from_icrs);
            let pixel_rad = view.degrees_per_pixel(view.rows_or_fewest()).to_radians();
            let scale = 1.0 / (names.params.size_px * pixel_rad.max(1e-12));
            let faintest = faintest(names.params.magnitude, view).min(names.limiting_magnitude);
            let seen: Vec<(DVec3, f64)> = (names.bodies.iter().take(MOST_NAMED_BODIES))
                .map(|body| {
                    let radius_rad = if body.radius_rad.is_finite() { body.radius_rad.clamp(0.0, 3.0) } else { 0.0 };
                    (view_from_enu * body.direction.normalize_or(DVec3::Z), radius_rad)
                })
                .collect();
            let mut bodies = [[0.0, 0.0, 1.0, -1.0]; MOST_NAMED_BODIES];
            for (slot, (direction, radius_rad)) in bodies.iter_mut().zip(&seen) {
                *slot = direction.as_vec3().extend(*radius_rad as f32).to_array();
            }
            let mut sides = [[0f32; 4]; MOST_NAMED_BODIES];
            for (slot, side) in sides.iter_mut().zip(beside(view, &seen, &uploaded.reaches, scale)) {
                let numbers = [side.ends[0], side.ends[1], side.shift, f64::from(u8::from(side.shown))];
                *slot = numbers.map(|number| number as f32);
            }
            let [view_from_enu_x, view_from_enu_y, view_from_enu_z] = columns(view_from_enu);
            let uniform = NamesUniform {
                view_from_enu_x,
                view_from_enu_y,
                view_from_enu_z,
                em_px: names.params.size_px as f32,
                scale: scale as f32,
                faintest: faintest as f32,
                bodies,
                beside: sides,
                colours,
            };
            let [points_buffer, names_buffer] = &self.uniforms.buffers;
            write(points_buffer, index as u64 * self.uniforms.strides[0], bytemuck::bytes_of(&points));
            write(names_buffer, index as u64 * self.uniforms.strides[1], bytemuck::bytes_of(&uniform));
            let letters = uploaded.starts.get(uploaded.list.count_to(faintest)).copied().unwrap_or(0);
            let linear = matches!(view.projection, Projection::Matrix(_));
            self.pipelines.entry(linear).or_insert_with(|| {
                // Colours are multiplied by their alpha already.
                let covering = wgpu::BlendComponent::OVER;
                let entries = ["name_vertex", "name_fragment"];
                let constants = [("linear", f64::from(u8::from(linear)))];
                let (module, layout) = (&self.module, &self.pipeline_layout);
                pipeline_over_sky(&self.device, &self.target, module, layout, entries, &constants, covering)
            });
            self.views.push(Some((linear, letters)));
        }
        Ok(())
    }

    /// Draws the names of a view; groups 0 and 1 are those of its sky.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        let Some((linear, letters)) = self.views.get(view_index).copied().flatten() else { return };
        let (Some(uploaded), Some(pipeline)) = (&self.uploaded, self.pipelines.get(&linear)) else { return };
        if letters > 0 {
            pass.set_pipeline(pipeline);
            let offsets = self.uniforms.strides.map(|stride| (view_index as u64 * stride) as u32);
            pass.set_bind_group(2, &uploaded.group, &offsets);
            pass.draw(0..6 * letters, 0..1);
        }
    }
}

fn filled(device: &wgpu::Device, queue: &wgpu::Queue, label: &str, bytes: &[u8], least: usize) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.len().max(least) as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    if !bytes.is_empty() {
        queue.write_buffer(&buffer, 0, bytes);
    }
    buffer
}

fn label_of(laid: &super::names::Laid) -> NameLabel {
    let label = &laid.label;
    let still = (DVec3::ZERO, 0.0);
    let (anchor, place, (velocity, parallax)) = match label.anchor {
        Anchor::Sky { place, velocity_per_year, parallax_rad } => (0, place, (velocity_per_year, parallax_rad)),
        Anchor::Seen(place) => (1, place.normalize_or(DVec3::Z), still),
        Anchor::Horizon(place) => (2, place.normalize_or(DVec3::Z), still),
        Anchor::Body(_) => (3, DVec3::Z, still),
    };
    let number = match label.anchor {
        Anchor::Body(index) => index.min(MOST_NAMED_BODIES - 1),
        _ => MOST_NAMED_BODIES,
    };
    NameLabel {
        place: place.as_vec3().to_array(),
        parallax: parallax as f32,
        velocity: velocity.as_vec3().to_array(),
        magnitude: if label.kind == LabelKind::Star { label.magnitude as f32 } else { NO_STAR },
        anchor,
        number: number as u32,
        from_scale: laid.from_scale as f32,
        kind: label.kind.index() as u32,
        reach: laid.reach.map(|reach| reach as f32),
        ..NameLabel::default()
    }
}

/// Colours by kind, as the target blends them.
fn colours(names: &Names, target: &Target) -> [[f32; 4]; LabelKind::COUNT] {
    let kinds = [
        // Stars, constellations, bodies, cardinal points, the grids like their lines.
        [0.95, 0.95, 0.9],
        [0.6, 0.75, 1.0],
        [1.0, 0.85, 0.5],
        [1.0, 0.6, 0.45],
        [0.5, 0.85, 0.95],
        [0.55, 0.95, 0.55],
    ];
    let encoded = target.output == Output::Display && !target.colour.is_srgb();
    kinds.map(|kind| {
        let colour = match names.params.colour {
            NameColour::Kinds => DVec3::from(kind),
            NameColour::White => DVec3::ONE,
            NameColour::Amber => DVec3::new(1.0, 0.75, 0.3),
            NameColour::Red => DVec3::new(1.0, 0.15, 0.1),
        };
        let colour = colour * names.params.strength;
        let shown = if encoded { colour } else { srgb_decode(colour) };
        shown.as_vec3().extend(1.0).to_array()
    })
}
