//! The list of points on the GPU, its uniforms, its pipelines.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use himmel_air::Starlight;
use himmel_air::refraction::Bending;
use himmel_core::constants::ILLUMINANCE_OF_V_0_LX;

use super::bins::Bins;
use super::cells::{CELLS, Sight};
use super::model::{
    GLARE_FARTHEST_RAD, GLARE_FLOOR, GLARE_SOFT_RAD, Hider, PointBody, StarField, StarList, glare_coefficients,
    scintillation_at_zenith, thesis_core_scale, wave_phases, wavelength_shift, wavelength_strength,
};
use super::params::{Glare, PointSpread, StarsParams};
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::output::params::Tonemap;
use crate::pass::{Bound, Slot, bind, layout, module};
use crate::phenomena::planets::{Discs, PlanetDisc, disc_slots};
use crate::phenomena::sun::BendingUniform;
use crate::target::{Output, Target};
use crate::view::{Projection, View};

/// Most points of a frame besides stars.
pub const MOST_BODIES: usize = 128;
/// Most discs that hide points.
pub const MOST_HIDERS: usize = 4;
/// Views of a frame that have points: their prepared points stay below WebGPU's 128 MiB of a buffer.
const MOST_VIEWS: usize = 64;
/// How far the core of a star reaches, and the glare of the thesis, pixels: the brightest star's is 20.
const SPREAD_PX: f64 = 64.0;

gpu_struct! {
    /// A point as the list keeps it; the fields are explained in `points.wgsl`.
    pub struct PointLight {
        /// Unit vector.
        pub place: [f32; 3],
        /// Annual parallax, rad.
        pub parallax: f32,
        /// Change of the place per Julian year.
        pub velocity: [f32; 3],
        /// Share of scintillation.
        pub scintillation: f32,
        /// Irradiance relative to the preset's star at 1 au.
        pub four: [f32; 4],
        /// Full width of what is no point, rad.
        pub width: f32,
        /// A number of its own: how many are brighter.
        pub number: f32,
        /// Fills up.
        pub padding_0: f32,
        /// Fills up.
        pub padding_1: f32,
    }
}

gpu_struct! {
    /// What the points of a list and a view share; the fields are explained in `points.wgsl`.
    pub struct PointsUniform {
        /// First column of view-from-list.
        pub view_from_list_x: [f32; 3],
        /// Years since J2000.0.
        pub years: f32,
        /// Second column.
        pub view_from_list_y: [f32; 3],
        /// Seeing, rad.
        pub seeing: f32,
        /// Third column.
        pub view_from_list_z: [f32; 3],
        /// Scintillation at the zenith.
        pub scintillation: f32,
        /// Velocity by the speed of light.
        pub beta: [f32; 3],
        /// Exposed value at which glare ends.
        pub glare_floor: f32,
        /// Observer, au.
        pub observer_au: [f32; 3],
        /// Softening of glare, rad.
        pub glare_soft: f32,
        /// Glare.
        pub glare: [f32; 3],
        /// Whether all points are wide.
        pub all_wide: u32,
        /// Refraction over true elevation.
        pub lift: BendingUniform,
        /// Discs.
        pub hider: [[f32; 4]; MOST_HIDERS],
        /// Waves of scintillation.
        pub phases: [[f32; 4]; 2],
        /// How far wavelengths lie apart.
        pub shift: [f32; 4],
        /// How strongly each twinkles.
        pub strength: [f32; 4],
        /// A pixel in ndc.
        pub pixel: [f32; 2],
        /// Of a linear projection.
        pub area: f32,
        /// Illuminance of m_a.
        pub thesis_lx: f32,
        /// I_T.
        pub thesis_core_scale: f32,
        /// Radius of its glare.
        pub thesis_glare_px: f32,
        /// Points of the list.
        pub count: u32,
        /// Where its prepared points begin.
        pub first: u32,
        /// Points of the view.
        pub view_count: u32,
        /// Where they begin.
        pub view_first: u32,
        /// Bins along the sides of the picture.
        pub bins: [u32; 2],
        /// Where the view's begin.
        pub bins_first: u32,
        /// Where the lists of bins begin.
        pub lists_first: u32,
        /// Where wide points begin.
        pub wide_first: u32,
        /// Texel at which points in bins begin.
        pub binned_first: u32,
        /// Bits of points that are drawn as discs.
        pub discs: [u32; 4],
        /// Runs of the list, two in each: where they begin among the points that are moved, and in the list.
        pub runs: [[[u32; 4]; 24]; 2],
    }
}

gpu_struct! {
    /// A point as a view sees it; the fields are explained in `points.wgsl`.
    pub struct SeenPoint {
        /// In ndc.
        pub centre: [f32; 2],
        /// In ndc.
        pub half_size: [f32; 2],
        /// Illuminance, share of the core.
        pub light: [f32; 4],
        /// Widening across and upward.
        pub widen: [f32; 2],
        /// Solid angle per area of ndc.
        pub per_ndc: f32,
        /// Whether it is drawn as a square.
        pub wide: u32,
        /// Direction, radius of glare.
        pub seen: [f32; 4],
        /// Softening, own number, radius of the thesis' glare.
        pub own: [f32; 4],
        /// The sky behind.
        pub sky: [f32; 4],
        /// The same finished.
        pub finished_sky: [f32; 4],
    }
}

/// What pipelines of points differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Kind {
    linear: bool,
    marching: bool,
    lights: u32,
    eclipsed: bool,
    night: bool,
    tonemap: Tonemap,
    glare: bool,
    rays: bool,
    thesis: bool,
    twinkling: bool,
}

/// What the renderer tells about the frame.
pub(crate) struct PointsScene<'a> {
    pub stars: Option<&'a StarField>,
    pub bodies: &'a [PointBody],
    pub planets: &'a [PlanetDisc],
    pub hiders: &'a [Hider],
    /// Whether all points are drawn over the sky, none in its pixels.
    pub all_wide: bool,
    pub bending: &'a Arc<Bending>,
    pub altitude_m: f64,
    pub bottom_radius_m: f64,
    pub lights: u32,
    pub eclipsed: bool,
    pub night: bool,
    pub tonemap: Tonemap,
}

impl Kind {
    /// Of the pass that moves points: it does not ask for the sky behind them.
    fn moving(self) -> Self {
        Self { marching: false, lights: 1, eclipsed: false, night: false, tonemap: Tonemap::Linear, ..self }
    }

    /// Of what draws wide points.
    fn drawing(self) -> Self {
        Self { twinkling: false, ..self }
    }
}

/// What a view has of points: number of stars and of bodies, and their bins.
#[derive(Clone, Copy, Debug)]
struct Draw {
    kind: Kind,
    points: [u32; 2],
    bins: [u32; 2],
}

impl Draw {
    /// One that has a uniform.
    fn any_list(&self) -> usize {
        usize::from(self.points[0] == 0 && self.points[1] > 0)
    }

    /// Lists that have points.
    fn lists(&self) -> impl Iterator<Item = usize> {
        let points = self.points;
        (0..2).filter(move |&list| points[list] > 0)
    }
}

/// The discs of a view: pipeline, uniform slot of its points, first slot and number of discs.
#[derive(Clone, Copy, Debug)]
struct DiscDraw {
    kind: Kind,
    points_slot: u32,
    first: usize,
    count: usize,
}

/// Draws points into the host's pass.
pub(crate) struct Points {
    device: wgpu::Device,
    target: Target,
    /// That move points, and that draw wide ones.
    modules: [wgpu::ShaderModule; 2],
    /// Of moving points, of looking behind them, of drawing them.
    pipeline_layouts: [wgpu::PipelineLayout; 3],
    layouts: Layouts,
    constants: [(&'static str, f64); 2],
    moving: HashMap<Kind, wgpu::ComputePipeline>,
    /// Looking behind wide points of finished pictures, and drawing them.
    drawing: HashMap<Kind, (Option<wgpu::ComputePipeline>, wgpu::RenderPipeline)>,
    bins: Bins,
    uniforms: wgpu::Buffer,
    stride: u64,
    capacity: usize,
    stars: wgpu::Buffer,
    bodies: wgpu::Buffer,
    prepared: wgpu::Buffer,
    groups: Groups,
    /// The list that is on the GPU; none after an edit of the light.
    uploaded: Option<Arc<StarList>>,
    /// Refraction over true elevation, and what it was made from.
    lift: Option<(Arc<Bending>, BendingUniform)>,
    draws: Vec<Option<Draw>>,
    /// Views of the frame whose pixels read bins.
    reading: usize,
    /// Views that have bins at all.
    listing: usize,
    discs: Discs,
    /// Made when a disc is first drawn.
    disc_module: Option<wgpu::ShaderModule>,
    disc_pipeline_layout: wgpu::PipelineLayout,
    disc_pipelines: HashMap<Kind, wgpu::RenderPipeline>,
    disc_draws: Vec<Option<DiscDraw>>,
    /// Whether the target blends at all.
    blends: bool,
}

/// Layouts of group 2: moving points, looking behind the wide ones, drawing those.
struct Layouts {
    moving: wgpu::BindGroupLayout,
    behind: wgpu::BindGroupLayout,
    drawing: wgpu::BindGroupLayout,
}

/// Groups 2: moving stars, moving bodies, looking behind either, drawing either.
struct Groups {
    moving: [wgpu::BindGroup; 2],
    behind: wgpu::BindGroup,
    drawing: wgpu::BindGroup,
}

fn list(device: &wgpu::Device, label: &str, bytes: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn uniforms(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("points"),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl Points {
    /// `groups`: the layouts of the air and of a view.
    pub(crate) fn new(
        device: &wgpu::Device,
        target: &Target,
        groups: [&wgpu::BindGroupLayout; 2],
        constants: [(&'static str, f64); 2],
    ) -> Result<Self, GpuError> {
        let uniform = Slot::Uniform(size_of::<PointsUniform>() as u64, true);
        let moving = [(0, uniform), (1, Slot::Buffer(false)), (2, Slot::Buffer(true))].into_iter().chain(Bins::SLOTS);
        let moving: Vec<_> = moving.collect();
        let behind = [(0, uniform), (2, Slot::Buffer(true)), Bins::WIDE_SLOT];
        let drawing = [(0, uniform), (3, Slot::Buffer(false)), Bins::WIDE_SLOT];
        let layouts = Layouts {
            moving: layout(device, "moving points", wgpu::ShaderStages::COMPUTE, &moving),
            behind: layout(device, "behind points", wgpu::ShaderStages::COMPUTE, &behind),
            drawing: layout(device, "points", wgpu::ShaderStages::VERTEX_FRAGMENT, &drawing),
        };
        let pipeline_layout = |last| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("points"),
                bind_group_layouts: &[Some(groups[0]), Some(groups[1]), Some(last)],
                immediate_size: 0,
            })
        };
        let discs = Discs::new(device);
        let disc_pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("planets"),
            bind_group_layouts: &[Some(groups[0]), Some(groups[1]), Some(&layouts.drawing), Some(&discs.layout)],
            immediate_size: 0,
        });
        let pipeline_layouts = [&layouts.moving, &layouts.behind, &layouts.drawing].map(pipeline_layout);
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let stride = (size_of::<PointsUniform>() as u64).next_multiple_of(alignment);
        let capacity = 16;
        let uniforms = uniforms(device, stride * capacity as u64);
        let (stars, bodies) = (
            list(device, "stars", size_of::<PointLight>()),
            list(device, "bodies", MOST_BODIES * size_of::<PointLight>()),
        );
        let prepared = list(device, "seen points", size_of::<SeenPoint>());
        let features = target.colour.guaranteed_format_features(device.features());
        let blends = features.flags.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE);
        if !blends {
            tracing::warn!(
                format = ?target.colour,
                "stars with glare and discs of planets stand aside: this device cannot blend the target's format; ask for \
                 FLOAT32_BLENDABLE or use Rgba16Float"
            );
        }
        let bins = Bins::new(device, [groups[0], groups[1], &layouts.moving], &constants)?;
        let groups = bind_groups(device, &layouts, &uniforms, [&stars, &bodies], &prepared, &bins);
        Ok(Self {
            device: device.clone(),
            target: *target,
            modules: [module(device, "phenomena/stars/move.wgsl")?, module(device, "phenomena/stars/wide.wgsl")?],
            pipeline_layouts,
            layouts,
            constants,
            moving: HashMap::new(),
            drawing: HashMap::new(),
            bins,
            uniforms,
            stride,
            capacity,
            stars,
            bodies,
            prepared,
            groups,
            uploaded: None,
            lift: None,
            draws: Vec::new(),
            reading: 0,
            listing: 0,
            discs,
            disc_module: None,
            disc_pipeline_layout,
            disc_pipelines: HashMap::new(),
            disc_draws: Vec::new(),
            blends,
        })
    }

    /// After an edit of the air: pipelines know how many components it has, colours know its light.
    pub(crate) fn set_air(&mut self, constants: [(&'static str, f64); 2]) {
        if constants != self.constants {
            self.constants = constants;
            self.moving.clear();
            self.drawing.clear();
            self.disc_pipelines.clear();
        }
        self.uploaded = None;
    }

    /// Refraction over true elevation, of the prepared frame.
    pub(crate) fn lift(&self) -> BendingUniform {
        self.lift.as_ref().map_or_else(BendingUniform::default, |(_, lift)| *lift)
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.stars.size() + self.bodies.size() + self.prepared.size() + self.bins.bytes()
    }

    /// Uploads the list of stars if it is another one than before.
    fn upload(&mut self, queue: &wgpu::Queue, list_of_stars: &Arc<StarList>, starlight: &Starlight) {
        if self.uploaded.as_ref().is_some_and(|known| Arc::ptr_eq(known, list_of_stars)) {
            return;
        }
        let points: Vec<PointLight> = (list_of_stars.stars().iter().zip(list_of_stars.ranks()))
            .map(|(star, &rank)| PointLight {
                place: star.place.as_vec3().to_array(),
                parallax: star.parallax_rad as f32,
                velocity: star.velocity_per_year.as_vec3().to_array(),
                scintillation: 1.0,
                number: rank as f32,
                four: starlight.of_black_body(star.temperature_k, star.illuminance_lx).map(|value| value as f32),
                ..PointLight::default()
            })
            .collect();
        let size = size_of_val(points.as_slice()) as u64;
        if self.stars.size() < size {
            self.stars = list(&self.device, "stars", size as usize);
            self.bind();
        }
        if !points.is_empty() {
            queue.write_buffer(&self.stars, 0, bytemuck::cast_slice(&points));
        }
        self.uploaded = Some(Arc::clone(list_of_stars));
    }

    fn bind(&mut self) {
        let lists = [&self.stars, &self.bodies];
        self.groups = bind_groups(&self.device, &self.layouts, &self.uniforms, lists, &self.prepared, &self.bins);
    }

    /// Prepares a frame. `marching`: of each view, whether its pixels march. `write` records an upload.
    pub(crate) fn prepare(
        &mut self,
        queue: &wgpu::Queue,
        scene: &PointsScene<'_>,
        starlight: &Starlight,
        views: &[View],
        marching: &[bool],
        write: &mut dyn FnMut(&wgpu::Buffer, u64, &[u8]),
    ) -> Result<(), GpuError> {
        self.draws.clear();
        self.disc_draws.clear();
        (self.reading, self.listing) = (0, 0);
        let stars = scene.stars.filter(|field| field.params.enabled);
        if let Some(field) = stars {
            self.upload(queue, &field.list, starlight);
        }
        let body_count = scene.bodies.len().min(MOST_BODIES);
        // Room for all that any view may show: a frame allocates nothing.
        let listed = stars.map_or(0, |field| field.list.count_to(field.params.limiting_magnitude));
        let each = listed + body_count;
        let most = MOST_VIEWS.min(Bins::most_views(&self.device, each));
        if views.len() > most && each > 0 {
            tracing::warn!(views = views.len(), most, "only the first views of a frame have stars");
        }
        let views = &views[..views.len().min(most)];
        let any = stars.is_some() || body_count > 0;
        self.listing = if any { views.len() } else { 0 };
        self.reading = if scene.all_wide { 0 } else { self.listing };
        let lift = match &self.lift {
            Some((of, lift)) if Arc::ptr_eq(of, scene.bending) => *lift,
            _ => {
                let lift = BendingUniform::new(&scene.bending.lift());
                self.lift = Some((Arc::clone(scene.bending), lift));
                lift
            }
        };
        let output = self.target.output;
        let defaults = StarsParams::default();
        let params = scene.stars.map_or(&defaults, |field| &field.params);
        let shown: Vec<Vec<usize>> = views.iter().map(|view| disc_slots(view, scene.planets)).collect();
        let mut runs: Vec<[Vec<(usize, usize)>; 2]> = Vec::with_capacity(views.len());
        for (view, shown) in views.iter().zip(&shown) {
            let sight = sight_of(view, params, output, scene, &lift)?;
            // Discs are drawn with what all bodies of a view share.
            let disc = |body| shown.iter().any(|&disc| scene.planets[disc].body == body);
            runs.push([
                stars.map_or_else(Vec::new, |field| sight.runs(field, faintest(field, output, &sight))),
                sight.bodies(&scene.bodies[..body_count], &disc),
            ]);
        }
        let counts: Vec<[usize; 2]> =
            runs.iter().map(|both| both.each_ref().map(|runs| runs.iter().map(|run| run.1).sum())).collect();
        let bytes = views.len() * each * size_of::<SeenPoint>();
        let mut stale = self.bins.reserve(self.listing, views.len() * each);
        if self.prepared.size() < bytes as u64 {
            self.prepared = list(&self.device, "seen points", bytes);
            stale = true;
        }
        if 2 * views.len() > self.capacity {
            self.capacity = (2 * views.len()).next_power_of_two();
            self.uniforms = uniforms(&self.device, self.stride * self.capacity as u64);
            stale = true;
        }
        if stale {
            self.bind();
        }
        if body_count > 0 {
            let bodies: Vec<PointLight> = (scene.bodies.iter().take(MOST_BODIES).enumerate())
                .map(|(number, body)| PointLight {
                    number: number as f32,
                    place: body.direction.normalize_or(DVec3::Z).as_vec3().to_array(),
                    scintillation: body.scintillation as f32,
                    width: body.width_rad as f32,
                    four: body.irradiance.map(|value| value as f32),
                    ..PointLight::default()
                })
                .collect();
            write(&self.bodies, 0, bytemuck::cast_slice(&bodies));
        }
        self.discs.reserve(&self.device, shown.iter().map(Vec::len).sum());
        let mut disc_slot = 0;
        let glare = params.glare_for(output);
        let mut first = 0;
        for (index, view) in views.iter().enumerate() {
            let linear = matches!(view.projection, Projection::Matrix(_));
            let mut draw: Option<Draw> = None;
            let mut disc_draw = None;
            let view_first = first;
            for (bodies, count) in counts[index].into_iter().enumerate() {
                // A view without points has bins that say so.
                if count == 0 && (bodies == 1 || counts[index][1] > 0 || !any) {
                    continue;
                }
                let Some(mut uniform) = uniform_of(view, params, output, scene, starlight)? else { continue };
                uniform.lift = lift;
                let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
                if bodies == 1 {
                    for &disc in &shown[index] {
                        let body = scene.planets[disc].body;
                        uniform.discs[(body / 32).min(3)] |= 1 << (body % 32);
                    }
                }
                let field = stars.filter(|_| bodies == 0);
                let view_from_list = field.map_or(view_from_enu, |field| view_from_enu * field.enu_from_icrs);
                [uniform.view_from_list_x, uniform.view_from_list_y, uniform.view_from_list_z] =
                    [view_from_list.x_axis, view_from_list.y_axis, view_from_list.z_axis]
                        .map(|v| v.as_vec3().to_array());
                uniform.count = count as u32;
                uniform.all_wide = u32::from(scene.all_wide);
                uniform.first = first as u32;
                first += count;
                uniform.view_count = counts[index].iter().sum::<usize>() as u32;
                uniform.view_first = view_first as u32;
                self.bins.tell(&mut uniform, view, index);
                uniform.runs = list_runs(&runs[index][bodies]);
                if let Some(field) = field {
                    uniform.years = field.years_since_j2000 as f32;
                    uniform.beta = field.beta.as_vec3().to_array();
                    uniform.observer_au = field.observer_au.as_vec3().to_array();
                }
                let slot = 2 * index + bodies;
                write(&self.uniforms, slot as u64 * self.stride, bytemuck::bytes_of(&uniform));
                let finished = output == Output::Display;
                let physical = params.psf == PointSpread::Physical;
                let kind = Kind {
                    linear,
                    // What is behind matters where it is tone mapped with the point.
                    marching: finished && marching.get(index).copied().unwrap_or(true),
                    lights: if finished { scene.lights } else { 1 },
                    eclipsed: finished && scene.eclipsed,
                    night: finished && scene.night,
                    tonemap: scene.tonemap,
                    glare: physical && glare != Glare::None,
                    rays: physical && glare == Glare::Eye && params.ciliary_corona,
                    thesis: !physical,
                    twinkling: uniform.scintillation > 0.0,
                };
                self.make(kind);
                if bodies == 1 && !shown[index].is_empty() && self.blends {
                    let kind = Kind { glare: false, rays: false, thesis: false, twinkling: false, ..kind };
                    if !self.disc_pipelines.contains_key(&kind) {
                        let pipeline = self.disc_pipeline(kind)?;
                        self.disc_pipelines.insert(kind, pipeline);
                    }
                    let count = shown[index].len();
                    disc_draw = Some(DiscDraw { kind, points_slot: slot as u32, first: disc_slot, count });
                    for &disc in &shown[index] {
                        self.discs.write(view, &scene.planets[disc], disc_slot, write);
                        disc_slot += 1;
                    }
                }
                draw.get_or_insert(Draw { kind, points: [0; 2], bins: uniform.bins }).points[bodies] = count as u32;
            }
            self.draws.push(draw);
            self.disc_draws.push(disc_draw);
        }
        Ok(())
    }

    fn make(&mut self, kind: Kind) {
        let moving = kind.moving();
        if !self.moving.contains_key(&moving) {
            let pipeline = self.computing(0, "move_points", moving);
            self.moving.insert(moving, pipeline);
        }
        let drawing = kind.drawing();
        if self.blends && !self.drawing.contains_key(&drawing) {
            let entries = ["point_vertex", "point_fragment"];
            let pipeline = self.adding(&self.modules[1], &self.pipeline_layouts[2], entries, drawing);
            let finished = self.target.output == Output::Display;
            let behind = finished.then(|| self.computing(1, "look_behind", drawing));
            self.drawing.insert(drawing, (behind, pipeline));
        }
    }

    /// Values of the shaders' overrides; the first is the depth at infinity.
    fn overrides(&self, kind: Kind) -> [(&'static str, f64); 18] {
        let on = |yes: bool| f64::from(u8::from(yes));
        [
            ("far_depth", self.target.far_depth()),
            ("finished", on(self.target.output == Output::Display)),
            ("marching", on(kind.marching)),
            ("with_horizon", 0.0),
            ("with_aureole", 1.0),
            ("with_disc", 0.0),
            ("linear", on(kind.linear)),
            ("light_count", f64::from(kind.lights)),
            ("eclipses", on(kind.eclipsed)),
            ("night", on(kind.night)),
            ("tonemap_operator", f64::from(kind.tonemap as u32)),
            ("target_is_srgb", on(self.target.colour.is_srgb())),
            ("with_glare", on(kind.glare)),
            ("with_corona_rays", on(kind.rays)),
            ("as_thesis", on(kind.thesis)),
            ("twinkling", on(kind.twinkling)),
            self.constants[0],
            self.constants[1],
        ]
    }

    /// `part`: module and layout.
    fn computing(&self, part: usize, entry: &str, kind: Kind) -> wgpu::ComputePipeline {
        let constants = self.overrides(kind);
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&self.pipeline_layouts[part]),
            module: &self.modules[part],
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            cache: None,
        })
    }

    fn disc_pipeline(&mut self, kind: Kind) -> Result<wgpu::RenderPipeline, GpuError> {
        let shader = match &self.disc_module {
            Some(shader) => shader.clone(),
            None => self.disc_module.insert(module(&self.device, "phenomena/planets/disc.wgsl")?).clone(),
        };
        let entries = ["planet_vertex", "planet_fragment"];
        Ok(self.adding(&shader, &self.disc_pipeline_layout, entries, kind))
    }

    fn adding(
        &self,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
        entries: [&str; 2],
        kind: Kind,
    ) -> wgpu::RenderPipeline {
        pipeline_over_sky(&self.device, &self.target, module, layout, entries, &self.overrides(kind)[1..], ADDED)
    }

    /// Whether the prepared frame has any.
    pub(crate) fn any(&self) -> bool {
        self.draws.iter().any(Option::is_some)
    }

    /// Whether the pixels of a view read points.
    pub(crate) fn reads(&self, view_index: usize) -> bool {
        view_index < self.reading
    }

    /// Whether points of the frame have glare.
    pub(crate) fn glares(&self) -> bool {
        self.draws.iter().flatten().any(|draw| draw.kind.glare)
    }

    /// What they read them by.
    pub(crate) fn read_group(&self) -> &wgpu::BindGroup {
        &self.bins.read_group
    }

    /// Records what comes before [`record`](Self::record).
    pub(crate) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        self.bins.clear(encoder, self.listing);
    }

    /// Records what moves the points of all views and puts them into bins. `set_view`: binds groups 0 and 1 of a view.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        set_view: &dyn Fn(&mut wgpu::ComputePass<'_>, usize),
    ) {
        for (index, draw) in self.draws.iter().enumerate() {
            let Some(draw) = draw else { continue };
            let Some(pipeline) = self.moving.get(&draw.kind.moving()) else { continue };
            pass.set_pipeline(pipeline);
            set_view(pass, index);
            pass.set_bind_group(2, &self.groups.moving[0], &[self.offset(index, draw.any_list())]);
            for list in draw.lists() {
                pass.set_bind_group(2, &self.groups.moving[list], &[self.offset(index, list)]);
                pass.dispatch_workgroups(draw.points[list].div_ceil(64), 1, 1);
            }
            self.bins.record(pass, draw.points[0] + draw.points[1], draw.bins);
            if let Some((Some(pipeline), _)) = self.drawing.get(&draw.kind.drawing()) {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(2, &self.groups.behind, &[self.offset(index, draw.any_list())]);
                self.bins.dispatch_wide(pass, index);
            }
        }
    }

    /// Of a list's uniform.
    fn offset(&self, view_index: usize, list: usize) -> u32 {
        ((2 * view_index + list) as u64 * self.stride) as u32
    }

    /// Draws the wide points of a view, and discs of planets; groups 0 and 1 are those of its sky.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        if let Some(draw) = self.draws.get(view_index).copied().flatten()
            && let Some((_, pipeline)) = self.drawing.get(&draw.kind.drawing())
        {
            pass.set_pipeline(pipeline);
            // Both lists share what this reads.
            pass.set_bind_group(2, &self.groups.drawing, &[self.offset(view_index, draw.any_list())]);
            self.bins.draw_wide(pass, view_index);
        }
        let Some(draw) = self.disc_draws.get(view_index).copied().flatten() else { return };
        let Some(pipeline) = self.disc_pipelines.get(&draw.kind) else { return };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(2, &self.groups.drawing, &[(u64::from(draw.points_slot) * self.stride) as u32]);
        for slot in draw.first..draw.first + draw.count {
            self.discs.bind(pass, slot);
            pass.draw(0..6, 0..1);
        }
    }
}

/// What is added to a picture.
pub(crate) const ADDED: wgpu::BlendComponent = wgpu::BlendComponent {
    src_factor: wgpu::BlendFactor::One,
    dst_factor: wgpu::BlendFactor::One,
    operation: wgpu::BlendOperation::Add,
};

/// A pipeline that draws over the sky; its label is its vertices' entry point. `constants`: overrides besides the depth at infinity;
/// `blend`: with what is in the target.
pub(crate) fn pipeline_over_sky(
    device: &wgpu::Device,
    target: &Target,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    [vertex, fragment]: [&str; 2],
    constants: &[(&'static str, f64)],
    blend: wgpu::BlendComponent,
) -> wgpu::RenderPipeline {
    let far_depth = ("far_depth", target.far_depth());
    let constants: Vec<_> = std::iter::once(far_depth).chain(constants.iter().copied()).collect();
    let options = || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
    let colour = wgpu::ColorTargetState {
        format: target.colour,
        blend: Some(wgpu::BlendState { color: blend, alpha: blend }),
        write_mask: wgpu::ColorWrites::COLOR,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(vertex),
        layout: Some(layout),
        vertex: wgpu::VertexState { module, entry_point: Some(vertex), compilation_options: options(), buffers: &[] },
        primitive: Default::default(),
        depth_stencil: target.behind(),
        multisample: wgpu::MultisampleState { count: target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: options(),
            targets: &[Some(colour)],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn bind_groups(
    device: &wgpu::Device,
    layouts: &Layouts,
    uniforms: &wgpu::Buffer,
    lists: [&wgpu::Buffer; 2],
    prepared: &wgpu::Buffer,
    bins: &Bins,
) -> Groups {
    let uniform = Bound::Part(uniforms, size_of::<PointsUniform>() as u64);
    let drawing = [(0, uniform), (3, Bound::Buffer(prepared)), bins.wide()];
    let moving = |list| {
        let own = [(0, uniform), (1, Bound::Buffer(list)), (2, Bound::Buffer(prepared))];
        let bound: Vec<_> = own.into_iter().chain(bins.bound()).collect();
        bind(device, "moving points", &layouts.moving, &bound)
    };
    let behind = [(0, uniform), (2, Bound::Buffer(prepared)), bins.wide()];
    let behind = bind(device, "behind points", &layouts.behind, &behind);
    Groups { moving: lists.map(moving), behind, drawing: bind(device, "points", &layouts.drawing, &drawing) }
}

/// What a view may show of points.
fn sight_of(
    view: &View,
    params: &StarsParams,
    output: Output,
    scene: &PointsScene<'_>,
    lift: &BendingUniform,
) -> Result<Sight, GpuError> {
    let rows = f64::from(view.rows_or_fewest());
    let physical = params.psf == PointSpread::Physical;
    let pixel_rad = view.degrees_per_pixel(view.rows_or_fewest()).to_radians();
    let glare_rad = if physical && params.glare_for(output) != Glare::None { GLARE_FARTHEST_RAD } else { 0.0 };
    let spread_rad = glare_rad + SPREAD_PX * pixel_rad + 10.0 * (params.seeing_arcsec / 3600.0).to_radians();
    let lift_rad = lift.deviation.as_flattened().iter().fold(0f32, |most, &value| most.max(value.abs()));
    // A view may stand apart from the observer.
    let aside_m = view.enu_from_view.w_axis.truncate().length();
    let altitude_m = scene.altitude_m.max(0.5) + aside_m;
    let horizon_rad = himmel_air::geometry::horizon_cosine(scene.bottom_radius_m, altitude_m).asin();
    let lowest_rad = horizon_rad - aside_m / scene.bottom_radius_m;
    Sight::new(view, lowest_rad, spread_rad + f64::from(lift_rad), rows)
}

/// The magnitude of the faintest star that is drawn.
fn faintest(field: &StarField, output: Output, sight: &Sight) -> f64 {
    if field.params.psf == PointSpread::Thesis {
        return field.params.limiting_magnitude;
    }
    let lost_lx = lost_share(output) * field.darkest_sky_cd_m2 * sight.pixel_sr;
    field.params.limiting_magnitude.min(-2.5 * (lost_lx.max(1e-300) / ILLUMINANCE_OF_V_0_LX).log10())
}

/// How much brighter than the sky a star's light, spread over one pixel, must be to be drawn. Finished: a tenth of a step of 8 bits;
/// linear: ten times less. Four times less for twinkling, and the rest of what darkens.
fn lost_share(output: Output) -> f64 {
    match output {
        Output::Display => 5e-4,
        Output::Radiance => 5e-5,
    }
}

fn list_runs(runs: &[(usize, usize)]) -> [[[u32; 4]; 24]; 2] {
    let mut listed = [[[u32::MAX; 4]; 24]; 2];
    let mut start = 0;
    for (slot, &(first, count)) in runs.iter().take(CELLS).enumerate() {
        let pair = &mut listed[slot / 48][slot % 48 / 2];
        (pair[2 * (slot % 2)], pair[2 * (slot % 2) + 1]) = (start as u32, first as u32);
        start += count;
    }
    listed
}

/// What all lists of a view share; `None` for a projection that looks one way everywhere.
fn uniform_of(
    view: &View,
    params: &StarsParams,
    output: Output,
    scene: &PointsScene<'_>,
    starlight: &Starlight,
) -> Result<Option<PointsUniform>, GpuError> {
    let Some(shared) = view_of_points(view)? else { return Ok(None) };
    let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
    let mut hider = [[0f32; 4]; MOST_HIDERS];
    for (slot, disc) in hider.iter_mut().zip(scene.hiders) {
        let direction = (view_from_enu * disc.direction.normalize_or(DVec3::Z)).as_vec3();
        *slot = direction.extend(2.0 * (0.5 * disc.radius_rad).sin() as f32).to_array();
    }
    let time_s = scene.stars.map_or(0.0, |field| field.time_s);
    let phases = wave_phases(time_s, params.integration_s).map(|phase| phase as f32);
    let strength = params.scintillation_for(output)
        * scintillation_at_zenith(0.01 * params.aperture_cm, params.integration_s, scene.altitude_m);
    let refraction_rad = scene.bending.deviation(std::f64::consts::FRAC_PI_4).0;
    let [cube, square, soft, least] = glare_of(scene.stars, output);
    Ok(Some(PointsUniform {
        seeing: (params.seeing_arcsec / 3600.0).to_radians() as f32,
        scintillation: if refraction_rad > 0.0 { strength as f32 } else { 0.0 },
        glare_floor: least,
        glare_soft: soft,
        glare: [cube, square, GLARE_FARTHEST_RAD as f32],
        hider,
        phases: [[phases[0], phases[1], phases[2], phases[3]], [phases[4], phases[5], phases[6], phases[7]]],
        shift: wavelength_shift(refraction_rad, scene.bending.ratio).map(|value| value as f32),
        strength: wavelength_strength(starlight.wavelengths_nm()).map(|value| value as f32),
        thesis_lx: (ILLUMINANCE_OF_V_0_LX * 10f64.powf(-0.4 * params.thesis_magnitude)) as f32,
        ..shared
    }))
}

/// Glare of a frame's points: inverse cube, inverse square; softening, rad; exposed value at which it ends.
pub(crate) fn glare_of(stars: Option<&StarField>, output: Output) -> [f32; 4] {
    let defaults = StarsParams::default();
    let params = stars.map_or(&defaults, |field| &field.params);
    let [cube, square] = glare_coefficients(params.glare_for(output));
    [cube, square, GLARE_SOFT_RAD, GLARE_FLOOR].map(|value| value as f32)
}

/// What follows from a view alone; `None` for a projection that looks one way everywhere.
pub(crate) fn view_of_points(view: &View) -> Result<Option<PointsUniform>, GpuError> {
    let [origin, x, y] = view.rays()?;
    let linear = matches!(view.projection, Projection::Matrix(_));
    let area = origin.dot(x.cross(y)).abs();
    if linear && (area.is_nan() || area <= 1e-30) {
        return Ok(None);
    }
    let rows = f64::from(view.rows_or_fewest());
    // Pixels are square.
    let aspect = if linear { x.length() / y.length() } else { view.aspect };
    Ok(Some(PointsUniform {
        pixel: [(2.0 / (rows * aspect)) as f32, (2.0 / rows) as f32],
        area: area as f32,
        thesis_core_scale: thesis_core_scale(if linear { y.length() / rows } else { 0.5 / rows }) as f32,
        thesis_glare_px: 2.0,
        ..PointsUniform::default()
    }))
}
