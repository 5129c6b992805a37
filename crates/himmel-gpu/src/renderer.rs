//! The renderer: made once for a target, prepared each frame, drawn for each view.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use himmel_air::eclipse::Shadow;
use himmel_air::refraction::Bending;
use himmel_air::{AirQuality, Atmosphere, Starlight, sun};
use wgpu::util::StagingBelt;

use crate::error::GpuError;
use crate::frame::{FrameUniform, LightUniform, MOST_LIGHTS, ViewUniform};
use crate::output::meter::{self, Meter, MeterUniform};
use crate::output::params::{OutputParams, Tonemap};
use crate::pass::{Bound, Slot, bind, layout, module};
use crate::phenomena::air::build::{Pace, Rebuild};
use crate::phenomena::air::{Air, Apply, ApplyAir, TablesKey, TablesReadBack, view_slot};
use crate::phenomena::bodies::{self, Bodies, BodiesUniform, FarBody, MOST_FAR_BODIES};
use crate::phenomena::cleared;
use crate::phenomena::moon::{GroundForm, MoonState, MoonTextures, MoonUniform};
use crate::phenomena::night_glow::grid::{self, NightGrid};
use crate::phenomena::night_glow::{NightGlow, NightTextures, NightUniform};
use crate::phenomena::overlay::{Lines, Overlay};
use crate::phenomena::planets::{MOST_DISCS, PlanetDisc};
use crate::phenomena::stars::{
    Hider, MOST_BODIES, MOST_HIDERS, PointBody, Points, PointsScene, StarField, bins_of_view, bins_texel, glare_of,
    read_layout,
};
use crate::phenomena::sun::{BendingUniform, DiscUniform, Occluder, ShadowUniform};
use crate::sky_pipelines::{Kind, MoonKind, Pipelines, Variant};
use crate::target::Target;
use crate::tiles::{TileLight, Tiles};
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
    /// Irradiance above the air at the four wavelengths, relative to the preset's star at 1 au.
    pub irradiance: [f64; 4],
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
    /// Other suns that light the same air; at most [`MOST_LIGHTS`] with the first.
    pub other_suns: Vec<SunState>,
    /// What stands before the Sun, for its disc.
    pub occluder: Option<Occluder>,
    /// Its shadow in the air, where it reaches what one sees.
    pub shadow: Option<Shadow>,
    /// How the air bends what is seen.
    pub bending: Arc<Bending>,
    /// The Moon's disc; as a light it is one of the other suns.
    pub moon: Option<MoonState>,
    /// The stars; `None`: there are none.
    pub stars: Option<StarField>,
    /// Points of light besides stars; at most 128.
    pub bodies: Vec<PointBody>,
    /// Planets among them whose discs may be seen; at most 8.
    pub planets: Vec<PlanetDisc>,
    /// Discs that hide points; at most 4.
    pub hiders: Vec<Hider>,
    /// Other planets and moons with surface and air; at most 3.
    pub far_bodies: Vec<FarBody>,
    /// The night's own glow; none by day, when nobody sees it.
    pub night: Option<NightGlow>,
    /// Lines over the sky.
    pub overlay: Option<Overlay>,
    /// Altitude of the observer above the ground sphere, m.
    pub altitude_m: f64,
    /// Exposure and tone mapping.
    pub output: OutputParams,
    /// Real seconds since the last frame, for [`Adaptation`](crate::Adaptation); `None`: adapted at once.
    pub seconds: Option<f64>,
}

impl FrameState {
    /// One sun, nothing before it, nothing bent.
    pub fn new(sun: SunState, altitude_m: f64, output: OutputParams) -> Self {
        let bending = Arc::new(Bending::none());
        Self {
            sun,
            other_suns: Vec::new(),
            occluder: None,
            shadow: None,
            bending,
            stars: None,
            bodies: Vec::new(),
            planets: Vec::new(),
            hiders: Vec::new(),
            far_bodies: Vec::new(),
            moon: None,
            night: None,
            overlay: None,
            altitude_m,
            output,
            seconds: None,
        }
    }

    /// All suns, the first one first.
    pub fn suns(&self) -> impl Iterator<Item = &SunState> {
        std::iter::once(&self.sun).chain(&self.other_suns)
    }

    fn check(&self) -> Result<(), GpuError> {
        let count = self.suns().count();
        if count > MOST_LIGHTS {
            return Err(GpuError::View(format!("a frame has at most {MOST_LIGHTS} suns, got {count}")));
        }
        if self.planets.len() > MOST_DISCS || self.planets.iter().any(|planet| planet.body >= self.bodies.len()) {
            return Err(GpuError::View(format!(
                "a frame has at most {MOST_DISCS} planets, each of them among its points"
            )));
        }
        if self.bodies.len() > MOST_BODIES || self.hiders.len() > MOST_HIDERS {
            return Err(GpuError::View(format!(
                "a frame has at most {MOST_BODIES} points besides stars and {MOST_HIDERS} discs before them, got {} and {}",
                self.bodies.len(),
                self.hiders.len()
            )));
        }
        if self.far_bodies.len() > MOST_FAR_BODIES {
            return Err(GpuError::View(format!(
                "a frame has at most {MOST_FAR_BODIES} other bodies in the sky, got {}",
                self.far_bodies.len()
            )));
        }
        self.far_bodies.iter().try_for_each(FarBody::check)?;
        let finite = |sun: &SunState| {
            sun.direction.is_finite()
                && sun.disc_direction.is_finite()
                && sun.radius_rad.is_finite()
                && sun.irradiance.iter().all(|value| value.is_finite())
        };
        let moon = self.moon.as_ref().is_none_or(MoonState::is_finite);
        if !(self.suns().all(finite) && moon && self.altitude_m.is_finite()) {
            return Err(GpuError::View("the suns, the Moon and the observer's altitude must be finite".into()));
        }
        Ok(())
    }
}

/// Coefficients of a disc that is equally bright everywhere.
const EVEN_DISC: [[f32; 4]; 6] = [[1.0; 4], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]];

/// A view's uniform, and where it stands.
struct Standing {
    uniform: ViewUniform,
    /// The zenith, east-north-up.
    up: DVec3,
    altitude_m: f64,
    /// Its tiles by what they need.
    tiles: [Range<u32>; 7],
    /// Whether the night's glow may come from a grid.
    grid: bool,
}

/// Staging buffers that frames use in turn: three frames may be recorded before the first is submitted.
const BELTS: usize = 4;

/// Views that buffers hold at first; more make them grow once.
const FIRST_CAPACITY: usize = 8;
/// Most views of a frame: keeps the buffer below WebGPU's guaranteed 64 KiB of dynamic offsets many times over.
const MOST_VIEWS: usize = 4096;

/// Draws the sky into render passes of one kind.
pub struct SkyRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    target: Target,
    pipelines: Pipelines,
    meter: Meter,
    air: Air,
    moon: MoonTextures,
    night: NightTextures,
    /// Made when a night is first drawn in tiles.
    night_grid: Option<NightGrid>,
    with_grid: bool,
    /// What pixels read a grid by, and what is bound where there is none.
    grid_layout: wgpu::BindGroupLayout,
    no_grid: wgpu::BindGroup,
    default_quality: AirQuality,
    pace: Pace,
    frame_buffer: wgpu::Buffer,
    /// Of a view: what the air alone needs (more would be too many textures for `apply_air`), and all.
    air_view_layout: wgpu::BindGroupLayout,
    view_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    air_view_group: wgpu::BindGroup,
    view_group: wgpu::BindGroup,
    view_buffer: wgpu::Buffer,
    view_stride: u64,
    capacity: usize,
    prepared: usize,
    points: Points,
    lines: Lines,
    /// Made when a frame has other bodies.
    bodies: Option<Bodies>,
    /// Radius and top of each of their airs, m.
    far_airs: Vec<(f64, f64)>,
    wavelengths_nm: [f64; 4],
    starlight: Starlight,
    /// Made when air is first applied to a host's picture.
    apply: Option<Apply>,
    /// The prepared views, the number of lights, the tone mapper.
    views: Vec<View>,
    lights: u32,
    tonemap: Tonemap,
    eclipsed: bool,
    by_night: bool,
    occluded: bool,
    with_moon: Option<Moon>,
    /// Of each prepared view: whether its pixels march their own rays.
    marching: Vec<bool>,
    /// Of the metering view and each prepared one: its tiles by what they need.
    tiles: Vec<[Range<u32>; 7]>,
    /// Of each prepared view: whether the night's glow comes from its grid.
    gridded: Vec<bool>,
    uploads: Uploads,
    /// The part of the frame's uniform that follows from the medium.
    colours: FrameUniform,
    bottom_radius_m: f64,
    top_altitude_m: f64,
}

/// Staging buffers that frames use in turn.
struct Uploads {
    belts: [StagingBelt; BELTS],
    turn: usize,
}

impl Uploads {
    fn write(&mut self, encoder: &mut wgpu::CommandEncoder, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        if let Some(size) = wgpu::BufferSize::new(bytes.len() as u64) {
            self.belts[self.turn].write_buffer(encoder, buffer, offset, size).copy_from_slice(bytes);
        }
    }

    /// Takes the next belt.
    fn begin(&mut self) {
        self.turn = (self.turn + 1) % BELTS;
    }

    fn finish(&mut self) {
        self.belts[self.turn].finish();
        // The one that the next frame will write to: its last use was three frames ago. Asked for now, it is mapped by
        // then.
        self.belts[(self.turn + 1) % BELTS].recall();
    }
}

/// The prepared frame's Moon.
#[derive(Clone, Copy, Debug)]
struct Moon {
    radius_rad: f64,
    /// What its ground has, if that is to be seen.
    form: GroundForm,
    eclipsed: bool,
}

impl Moon {
    /// For pixels of a size.
    fn kind(&self, pixel_rad: f64) -> MoonKind {
        let radius_px = self.radius_rad / pixel_rad;
        // Small discs need more points for their terminator.
        let side = match radius_px {
            ..3.0 => 8,
            ..8.0 => 4,
            _ => 1,
        };
        let relief = match self.form {
            GroundForm::Heights if radius_px >= RELIEF_FROM_PX => 2,
            GroundForm::Normals => 1,
            _ => 0,
        };
        MoonKind { side, relief, eclipsed: self.eclipsed }
    }
}

/// A Moon of a smaller radius shows no heights: its pixels are wider than all but its widest craters.
const RELIEF_FROM_PX: f64 = 16.0;

/// Rows of a picture, for the level of the star map, where the view does not say.
const PICTURE_ROWS: u32 = 1080;

/// Altitude above which every pixel marches its own ray, m; where the air ends lower, this share of its top.
const MARCH_ABOVE_M: f64 = 60_000.0;
const MARCH_ABOVE_SHARE: f64 = 0.6;

impl SkyRenderer {
    /// Compiles pipelines for a target and uploads the air's medium; its tables are filled by the first frames.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target: &Target,
        atmosphere: &Atmosphere,
    ) -> Result<Self, GpuError> {
        Self::with_quality(device, queue, target, atmosphere, AirQuality::High)
    }

    /// The same with a quality for atmospheres that ask for none.
    pub fn with_quality(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target: &Target,
        atmosphere: &Atmosphere,
        default_quality: AirQuality,
    ) -> Result<Self, GpuError> {
        target.check(device)?;
        let module = module(device, "sky.wgsl")?;
        let meter = Meter::new(device)?;
        let frame_buffer = uniform_buffer(device, "sky frame", size_of::<FrameUniform>() as u64);
        let sizes = Air::sizes_of(atmosphere.quality().unwrap_or(default_quality), atmosphere.steps());
        let air = Air::new(device, queue, sizes, atmosphere, &frame_buffer, meter.exposure_view())?;
        let air_slots = [(0, view_slot()), (1, Slot::Layers), (2, Slot::Filtered), (3, Slot::Sampler)];
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let air_view_layout = layout(device, "air view", stages, &air_slots);
        let view_slots: Vec<_> = air_slots.into_iter().chain(NightTextures::SLOTS).chain(MoonTextures::SLOTS).collect();
        let view_layout = layout(device, "sky view", stages, &view_slots);
        let night = NightTextures::new(device);
        let moon = MoonTextures::new(device, queue);
        let grid_layout = grid::read_layout(device);
        let no_grid = grid::no_grid(device, &grid_layout);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sky"),
            bind_group_layouts: &[
                Some(&air.layout),
                Some(&view_layout),
                Some(&grid_layout),
                Some(&read_layout(device)),
            ],
            immediate_size: 0,
        });
        let points = Points::new(device, target, [&air.layout, &view_layout], air.constants())?;
        let lines = Lines::new(device, target, [&air.layout, &view_layout]);
        let pipelines = Pipelines::new(device, target, pipeline_layout, module, air.constants());
        pipelines.make(air.sizes.sky_view.is_none());
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let view_stride = (size_of::<ViewUniform>() as u64).next_multiple_of(alignment);
        let view_buffer = uniform_buffer(device, "sky views", view_stride * FIRST_CAPACITY as u64);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("linear"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let [air_view_group, view_group] =
            view_groups(device, [&air_view_layout, &view_layout], &view_buffer, &air, &sampler, &night, &moon);
        let software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let mut renderer = Self {
            device: device.clone(),
            queue: queue.clone(),
            target: *target,
            pipelines,
            meter,
            air,
            moon,
            night,
            night_grid: None,
            with_grid: true,
            grid_layout,
            no_grid,
            default_quality,
            // A GPU does an order of the default table in less than a frame; a rasteriser on the CPU a tenth of one.
            pace: Pace::Samples(if software { 5e5 } else { 1e7 }),
            frame_buffer,
            air_view_layout,
            view_layout,
            sampler,
            air_view_group,
            view_group,
            view_buffer,
            view_stride,
            capacity: FIRST_CAPACITY,
            prepared: 0,
            points,
            lines,
            bodies: None,
            far_airs: Vec::new(),
            wavelengths_nm: atmosphere.wavelengths_nm(),
            starlight: atmosphere.starlight(),
            apply: None,
            views: Vec::new(),
            lights: 1,
            tonemap: OutputParams::default().tonemap,
            eclipsed: false,
            by_night: false,
            occluded: false,
            with_moon: None,
            marching: Vec::new(),
            tiles: Vec::new(),
            gridded: Vec::new(),
            uploads: Uploads {
                // Room for a frame's uniforms with a few views, so that one chunk serves a frame.
                belts: std::array::from_fn(|_| StagingBelt::new(device.clone(), 16 * 1024)),
                turn: 0,
            },
            colours: FrameUniform::default(),
            bottom_radius_m: 0.0,
            top_altitude_m: 0.0,
        };
        renderer.air.stations.bind_views(device, &renderer.view_buffer);
        renderer.take_colours(atmosphere);
        Ok(renderer)
    }

    /// Takes another atmosphere (or the same one after an edit). Its tables are rebuilt by the next frames, see
    /// [`rebuilding`](Self::rebuilding); the first already shows light that was scattered twice.
    pub fn set_atmosphere(&mut self, atmosphere: &Atmosphere) -> Result<(), GpuError> {
        let sizes = Air::sizes_of(atmosphere.quality().unwrap_or(self.default_quality), atmosphere.steps());
        same_wavelengths(self.air.far(), atmosphere.wavelengths_nm())?;
        if self.air.set(&self.device, &self.queue, sizes, atmosphere)? {
            self.bind_views();
            if self.pipelines.set_constants(self.air.constants()) {
                self.night_grid = None;
            }
            self.pipelines.make(self.air.sizes.sky_view.is_none());
            self.apply = None;
        }
        self.pipelines.far_constants(self.air.all_constants());
        self.take_colours(atmosphere);
        Ok(())
    }

    /// Takes the airs of other bodies in the sky, at most 3, which [`FarBody::air`] counts; each in the wavelengths of the sky's own.
    /// Their tables are filled by the next frames, after the sky's own ([`rebuilding`](Self::rebuilding),
    /// [`cancel_rebuild`](Self::cancel_rebuild)). An air that stays where it is in the list (the same `Arc`) keeps its tables.
    /// Call when the frames before are submitted. On an error nothing has changed.
    pub fn set_far_airs(&mut self, airs: &[Arc<Atmosphere>]) -> Result<(), GpuError> {
        same_wavelengths(airs.iter().map(Arc::as_ref), self.wavelengths_nm)?;
        self.air.set_far(&self.device, &self.queue, airs)?;
        self.far_airs = (airs.iter().map(|air| air.medium()))
            .map(|medium| (medium.bottom_radius_m, medium.top_altitude_m))
            .collect();
        self.pipelines.far_constants(self.air.all_constants());
        Ok(())
    }

    fn take_colours(&mut self, atmosphere: &Atmosphere) {
        let [r, g, b] = atmosphere.rec709_from_four().map(|row| row.as_vec4().to_array());
        let coefficients = atmosphere.wavelengths_nm().map(sun::limb_darkening);
        let limb_darkening = std::array::from_fn(|k| coefficients.map(|c| c[k] as f32));
        self.colours = FrameUniform {
            rec709_from_four_r: r,
            rec709_from_four_g: g,
            rec709_from_four_b: b,
            limb_darkening,
            ..FrameUniform::default()
        };
        self.wavelengths_nm = atmosphere.wavelengths_nm();
        self.starlight = atmosphere.starlight();
        self.points.set_air(self.air.constants());
        self.bottom_radius_m = atmosphere.medium().bottom_radius_m;
        self.top_altitude_m = atmosphere.medium().top_altitude_m;
    }

    fn bind_views(&mut self) {
        self.air.stations.bind_views(&self.device, &self.view_buffer);
        [self.air_view_group, self.view_group] = view_groups(
            &self.device,
            [&self.air_view_layout, &self.view_layout],
            &self.view_buffer,
            &self.air,
            &self.sampler,
            &self.night,
            &self.moon,
        );
    }

    /// The target it draws to.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// Memory of its tables in bytes, with the buffers that fill them.
    pub fn table_bytes(&self) -> u64 {
        let own = self.air.bytes() + self.moon.bytes() + self.night.bytes() + self.points.bytes();
        let own = own + self.night_grid.as_ref().map_or(0, NightGrid::bytes);
        let own = own + self.bodies.as_ref().map_or(0, Bodies::bytes);
        own + self.apply.as_ref().map_or(0, Apply::bytes)
    }

    /// How far the rebuilding of the air's tables is; `None` once all orders of scattering are there.
    pub fn rebuilding(&self) -> Option<Rebuild> {
        self.air.rebuilding()
    }

    /// Ends a rebuild where it is: the sky keeps the orders of scattering that it shows.
    pub fn cancel_rebuild(&mut self) {
        self.air.cancel();
    }

    /// What the air's tables are made of: two of one key are the same to the last bit.
    pub fn tables_key(&self) -> Result<TablesKey, GpuError> {
        self.air.key(&self.device, 0)
    }

    /// Reads the air's finished tables back, to be saved and given to [`load_tables`](Self::load_tables) another time. An
    /// error while they are rebuilt, or after a rebuild that was cancelled. Call when the frames that filled them are
    /// submitted.
    pub fn save_tables(&self) -> Result<TablesReadBack, GpuError> {
        self.air.save(&self.device, &self.queue, 0)
    }

    /// Takes tables that were saved instead of rebuilding them. They must be whole and of the same
    /// [`key`](Self::tables_key); on an error nothing has changed and the rebuild goes on.
    pub fn load_tables(&mut self, bytes: &[u8]) -> Result<(), GpuError> {
        self.air.load(&self.device, &self.queue, 0, bytes)
    }

    /// [`tables_key`](Self::tables_key) of another body's air.
    pub fn far_tables_key(&self, air: usize) -> Result<TablesKey, GpuError> {
        self.air.key(&self.device, air.saturating_add(1))
    }

    /// [`save_tables`](Self::save_tables) of another body's air.
    pub fn save_far_tables(&self, air: usize) -> Result<TablesReadBack, GpuError> {
        self.air.save(&self.device, &self.queue, air.saturating_add(1))
    }

    /// [`load_tables`](Self::load_tables) for another body's air.
    pub fn load_far_tables(&mut self, air: usize, bytes: &[u8]) -> Result<(), GpuError> {
        self.air.load(&self.device, &self.queue, air.saturating_add(1), bytes)
    }

    /// How many airs of other bodies there are.
    pub fn far_air_count(&self) -> usize {
        self.far_airs.len()
    }

    /// How many airs keep their finished tables on the GPU when [`set_atmosphere`](Self::set_atmosphere) takes another: to
    /// switch between prepared ones without a rebuild. None at first; the one least recently left goes first.
    pub fn set_kept(&mut self, count: usize) {
        self.air.set_kept(count);
    }

    /// Memory of the tables that are kept, in bytes; [`table_bytes`](Self::table_bytes) has it too.
    pub fn kept_bytes(&self) -> u64 {
        self.air.kept_bytes()
    }

    /// How much of a rebuild each frame does.
    pub fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
    }

    /// Whether the glow between the stars comes from a grid of 384 × 216 points that pixels interpolate (the default), or is evaluated
    /// in each pixel: four times as dear on a rasteriser, and the Milky Way as sharp as its map, 0.09°. Perspective views in the air
    /// have a grid, up to eight a frame. [`Still`](crate::Still) has none.
    pub fn set_night_grid(&mut self, on: bool) {
        self.with_grid = on;
    }

    /// Records the rebuilding of the air's tables without drawing, as much as the pace allows.
    pub fn build(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.uploads.begin();
        self.record_build(encoder);
        self.uploads.finish();
    }

    fn record_build(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let Self { device, air, pace, uploads, .. } = self;
        air.build(device, encoder, *pace, &mut |encoder, buffer, offset, bytes| {
            uploads.write(encoder, buffer, offset, bytes);
        });
    }

    /// Records this frame's uploads, what is left to build, the tables of where the views stand, and the metering where
    /// exposure is automatic (by the first view). Call once a frame before [`draw`](Self::draw), with the encoder that
    /// is submitted before or with the pass that draws.
    ///
    /// At most three frames may be recorded before the first of them is submitted.
    /// Allocates nothing on the GPU once running, unless there are more views than ever before.
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
        mut stamps: Option<&mut Stamps>,
    ) -> Result<(), GpuError> {
        self.prepared = 0;
        if views.is_empty() || views.len() > MOST_VIEWS {
            return Err(GpuError::View(format!("a frame has 1 to {MOST_VIEWS} views, got {}", views.len())));
        }
        frame.check()?;
        let new_moon = frame.moon.as_ref().is_some_and(|moon| {
            let rows = |view: &View| if view.rows_px == 0 { PICTURE_ROWS } else { view.rows_px };
            let pixel_rad = |view: &View| view.degrees_per_pixel(rows(view)).to_radians();
            let near = views.iter().any(|view| moon.radius_rad > RELIEF_FROM_PX * pixel_rad(view));
            self.moon.hold(&self.device, &self.queue, moon, near)
        });
        if new_moon {
            self.bind_views();
        }
        // The first slot is the metering view: the first view's whole picture.
        let whole = View { part: [0.0, 0.0, 1.0, 1.0], first_pixel: [0, 0], ..views[0] };
        let mut uniforms = Vec::with_capacity(views.len() + 1);
        let mut ranges = Vec::with_capacity(views.len() + 1);
        let mut gridded = vec![false];
        let mut grids = 0;
        let mut stations: Vec<(f64, DVec3, usize)> = Vec::new();
        for view in std::iter::once(&whole).chain(views) {
            view.check()?;
            let Standing { mut uniform, up, altitude_m, tiles, grid } =
                self.view_uniform(frame, view, !uniforms.is_empty())?;
            // Views that stand as good as in the same place (the faces of a cube, two eyes) share their tables.
            let near = |&(other_m, other_up, _): &(f64, DVec3, usize)| {
                (altitude_m - other_m).abs() < 1e-4 * (altitude_m + 10.0) && (up - other_up).length() < 1e-6
            };
            gridded.extend((!uniforms.is_empty()).then_some(grid && grids < grid::MOST_VIEWS));
            if gridded.last() == Some(&true) {
                uniform.night_layer = grids;
                grids += 1;
            }
            if let Some(index) = uniforms.len().checked_sub(1) {
                uniform.point_bins = bins_of_view(view);
                uniform.point_bins_first = bins_texel(index);
                uniform.glare = glare_of(frame.stars.as_ref(), self.target.output);
            }
            let known = stations.iter().position(near);
            uniform.station = known.unwrap_or(stations.len()) as u32;
            if known.is_none() {
                stations.push((altitude_m, up, uniforms.len()));
            }
            uniforms.push(uniform);
            ranges.push(tiles);
        }
        if let Some(shadow) = &frame.shadow {
            let limb = self.limb_darkening(frame);
            let b = self.air.eclipse(&self.queue, shadow.discs(DVec3::ZERO).1, &limb);
            uniforms.iter_mut().for_each(|uniform| uniform.table_b = b as f32);
        }
        let stands = |station: &(f64, DVec3, usize)| (station.2, false);
        let mut cells: Vec<(usize, bool)> = stations.iter().map(stands).collect();
        let bodies = self.bodies_of(frame, &whole, views, &mut uniforms, &mut cells)?;
        let mut stale = false;
        if uniforms.len() > self.capacity {
            self.capacity = uniforms.len().next_power_of_two();
            self.view_buffer = uniform_buffer(&self.device, "sky views", self.view_stride * self.capacity as u64);
            stale = true;
        }
        let lights = frame.suns().count() as u32;
        // Room for the Moon as a light is there before it rises.
        let room = lights.max(1 + u32::from(frame.moon.is_some()));
        stale |= self.air.reserve(&self.device, cells.len() as u32, room);
        stale |= frame.night.as_ref().is_some_and(|night| self.night.hold(&self.device, &self.queue, night));
        if grids > 0 {
            let grid = match self.night_grid.take() {
                Some(grid) => grid,
                None => NightGrid::new(&self.device, [&self.air.layout, &self.view_layout], &self.air.constants())?,
            };
            self.night_grid.insert(grid).reserve(&self.device, &self.grid_layout, grids);
        }
        if stale {
            self.bind_views();
        }
        self.uploads.begin();
        let exposure = frame.output.exposure_for(self.target.output).factor();
        let uniform = self.frame_uniform(frame, exposure);
        self.uploads.write(encoder, &self.frame_buffer, 0, bytemuck::bytes_of(&uniform));
        let metering = MeterUniform::new(&frame.output, frame.seconds);
        self.uploads.write(encoder, &self.meter.uniform, 0, bytemuck::bytes_of(&metering));
        for (slot, uniform) in uniforms.iter().enumerate() {
            let offset = slot as u64 * self.view_stride;
            self.uploads.write(encoder, &self.view_buffer, offset, bytemuck::bytes_of(uniform));
        }
        let marching: Vec<bool> =
            uniforms.iter().skip(1).take(views.len()).map(|uniform| uniform.sky_view == 0).collect();
        self.prepare_points(encoder, frame, views, &marching, lights)?;
        if let Some(night) = &frame.night {
            let uniform = NightUniform::new(night);
            self.uploads.write(encoder, &self.night.buffer, 0, bytemuck::bytes_of(&uniform));
        }
        self.prepare_bodies(encoder, frame, &bodies)?;
        self.record_build(encoder);
        self.uploads.finish();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("cells"),
            timestamp_writes: stamps.as_deref_mut().and_then(|stamps| stamps.next_compute("cells")),
        });
        for &(slot, far) in &cells {
            self.air.stations.record_cells(&mut pass, &self.air.group, (slot as u64 * self.view_stride) as u32, far);
        }
        drop(pass);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("sky view"),
            timestamp_writes: stamps.as_deref_mut().and_then(|stamps| stamps.next_compute("sky view")),
        });
        for &(_, _, slot) in stations.iter().filter(|&&(_, _, slot)| uniforms[slot].sky_view == 1) {
            let offset = (slot as u64 * self.view_stride) as u32;
            self.air.stations.record_sky_view(&mut pass, &self.air.group, offset, lights);
        }
        drop(pass);
        if let Some(grid) = self.night_grid.as_ref().filter(|_| grids > 0) {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("night glow"),
                timestamp_writes: stamps.as_deref_mut().and_then(|stamps| stamps.next_compute("night glow")),
            });
            for slot in (0..gridded.len()).filter(|&slot| gridded[slot]) {
                let offset = (slot as u64 * self.view_stride) as u32;
                grid.record(&mut pass, &self.air.group, &self.view_group, offset);
            }
        }
        self.lights = lights;
        self.tonemap = frame.output.tonemap;
        self.eclipsed = frame.shadow.is_some();
        self.by_night = frame.night.is_some();
        self.occluded = frame.occluder.is_some();
        self.with_moon = frame.moon.as_ref().map(|moon| Moon {
            radius_rad: moon.radius_rad,
            form: if moon.relief > 0.0 { self.moon.form() } else { GroundForm::Albedo },
            eclipsed: moon.eclipse.is_some(),
        });
        self.views.clear();
        self.views.extend_from_slice(views);
        self.tiles = ranges;
        self.gridded = gridded;
        self.marching = marching;
        match exposure {
            None => self.record_metering(encoder, stamps.as_deref_mut()),
            Some(factor) => self.meter.set(encoder, factor),
        }
        self.points.clear(encoder);
        if self.points.any() {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("points"),
                timestamp_writes: stamps.and_then(|stamps| stamps.next_compute("points")),
            });
            self.points.record(&mut pass, &|pass, view_index| {
                pass.set_bind_group(0, &self.air.group, &[]);
                pass.set_bind_group(1, &self.view_group, &[((view_index as u64 + 1) * self.view_stride) as u32]);
            });
        }
        self.prepared = views.len();
        Ok(())
    }

    /// The other bodies of the metering view and of each view, and what says where the cells in their airs lie: uniforms of
    /// stations that are added to those of the views.
    fn bodies_of(
        &self,
        frame: &FrameState,
        whole: &View,
        views: &[View],
        uniforms: &mut Vec<ViewUniform>,
        cells: &mut Vec<(usize, bool)>,
    ) -> Result<Vec<BodiesUniform>, GpuError> {
        let mut all = Vec::new();
        if frame.far_bodies.is_empty() {
            return Ok(all);
        }
        for body in &frame.far_bodies {
            let Some(air) = body.air else { continue };
            let Some(&(radius_m, _)) = self.far_airs.get(air) else {
                let count = self.far_airs.len();
                return Err(GpuError::View(format!("a body in the sky has air {air}, but {count} airs are set")));
            };
            if (body.radius_m / radius_m - 1.0).abs() > 1e-6 {
                return Err(GpuError::View(format!(
                    "a body in the sky has a radius of {} m, and air made for {radius_m} m",
                    body.radius_m
                )));
            }
        }
        let tops_m: Vec<f64> = self.far_airs.iter().map(|&(_, top_m)| top_m).collect();
        // Of each air and altitude in it.
        let mut known: Vec<(u32, f64, u32)> = Vec::new();
        for (slot, view) in std::iter::once(whole).chain(views).enumerate() {
            let shift_m = view.enu_from_view.w_axis.truncate();
            let altitude_m = f64::from(uniforms[slot].altitude_m);
            let above = altitude_m > self.top_altitude_m;
            let seen = bodies::apparent(&frame.far_bodies, shift_m, self.bottom_radius_m + altitude_m, above, &tops_m)?;
            let mut stations = Vec::with_capacity(seen.len());
            for body in &seen {
                let air = body.air();
                // From space all rays enter at the top.
                let altitude_m = if body.within() { body.altitude_m.max(0.5) } else { 1e15 };
                let near = |&(other, other_m, _): &(u32, f64, u32)| other == air && other_m == altitude_m;
                let station = match known.iter().find(|known| air == 0 || near(known)) {
                    Some(&(_, _, station)) => station,
                    None if air == 0 => 0,
                    None => {
                        let station = cells.len() as u32;
                        cells.push((uniforms.len(), true));
                        uniforms.push(ViewUniform {
                            altitude_m: altitude_m as f32,
                            station,
                            body: air,
                            sky_view: 0,
                            ..uniforms[slot]
                        });
                        known.push((air, altitude_m, station));
                        station
                    }
                };
                stations.push(station);
            }
            all.push(BodiesUniform::new(view, &seen, &stations, self.wavelengths_nm));
        }
        Ok(all)
    }

    fn prepare_bodies(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameState,
        uniforms: &[BodiesUniform],
    ) -> Result<(), GpuError> {
        if uniforms.is_empty() {
            if let Some(bodies) = &mut self.bodies {
                bodies.clear();
            }
            return Ok(());
        }
        let Self { device, queue, pipelines, bodies, uploads, air, view_layout, .. } = self;
        let bodies = bodies.get_or_insert_with(|| Bodies::new(device, queue));
        if !pipelines.has_far() {
            pipelines.make_far([&air.layout, view_layout, &bodies.layout], air.all_constants())?;
        }
        bodies.prepare(device, queue, &frame.far_bodies, uniforms, &mut |buffer, offset, bytes| {
            uploads.write(encoder, buffer, offset, bytes);
        });
        Ok(())
    }

    fn prepare_points(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameState,
        views: &[View],
        marching: &[bool],
        lights: u32,
    ) -> Result<(), GpuError> {
        // The widest of all discs, where there are too many.
        let mut hiders = frame.hiders.clone();
        hiders.extend(frame.far_bodies.iter().map(|body| Hider {
            direction: body.centre_m.normalize_or(DVec3::Z),
            radius_rad: (body.radius_m / body.centre_m.length()).clamp(0.0, 1.0).asin(),
        }));
        hiders.sort_by(|a, b| b.radius_rad.total_cmp(&a.radius_rad));
        hiders.truncate(MOST_HIDERS);
        let scene = PointsScene {
            stars: frame.stars.as_ref(),
            bodies: &frame.bodies,
            planets: &frame.planets,
            hiders: &hiders,
            // They are drawn over the sky, with points over them.
            all_wide: !frame.far_bodies.is_empty(),
            bending: &frame.bending,
            altitude_m: frame.altitude_m,
            bottom_radius_m: self.bottom_radius_m,
            lights,
            eclipsed: frame.shadow.is_some(),
            night: frame.night.is_some(),
            tonemap: frame.output.tonemap,
        };
        let Self { points, lines, queue, starlight, uploads, .. } = self;
        let mut write =
            |buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]| uploads.write(encoder, buffer, offset, bytes);
        points.prepare(queue, &scene, starlight, views, marching, &mut write)?;
        lines.prepare(queue, frame.overlay.as_ref(), points.lift(), views, &mut write)
    }

    /// Limb darkening of the Sun at the four wavelengths.
    fn limb_darkening(&self, frame: &FrameState) -> [[f64; 6]; 4] {
        let coefficients = if frame.sun.limb_darkening { self.colours.limb_darkening } else { EVEN_DISC };
        std::array::from_fn(|k| coefficients.map(|c| f64::from(c[k])))
    }

    fn frame_uniform(&self, frame: &FrameState, exposure: Option<f64>) -> FrameUniform {
        let compensation = frame.output.compensation_ev.exp2();
        let limb_darkening = frame.sun.limb_darkening;
        FrameUniform {
            exposure: exposure.map_or(0.0, |factor| (factor * compensation) as f32),
            steps: self.air.sizes.steps,
            tonemap: frame.output.tonemap as u32,
            encoding: if self.target.colour.is_srgb() { 2 } else { 1 },
            dither_levels: if frame.output.dither { self.target.levels() } else { 0.0 },
            largest: self.target.largest().unwrap_or(1.0),
            compensation: compensation as f32,
            limb_darkening: if limb_darkening { self.colours.limb_darkening } else { EVEN_DISC },
            light_count: frame.suns().count() as u32,
            bending: BendingUniform::new(&frame.bending),
            ..self.colours
        }
    }

    /// Draws a view of the prepared frame into the host's pass, at infinite depth. Sets its own pipeline and bind
    /// groups 0 to 2; touches nothing else. A view that was not prepared is left out with a warning.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        if view_index >= self.prepared {
            tracing::warn!(view_index, prepared = self.prepared, "the sky was not prepared for this view");
            return;
        }
        let slot = view_index + 1;
        let kind = self.kind(view_index, self.views.get(view_index).map_or(0, |view| view.rows_px));
        let marching = self.marching.get(view_index).copied().unwrap_or(true);
        if marching {
            self.set_slot(pass, Variant::Marching, kind, slot);
            pass.draw(0..3, 0..1);
        } else {
            for (variant, range) in Variant::TILED.into_iter().zip(&self.tiles[slot]) {
                if !range.is_empty() {
                    self.set_slot(pass, variant, kind, slot);
                    pass.draw(0..6, range.clone());
                }
            }
        }
        let variant = if marching { Variant::Bodies } else { Variant::BodiesTable };
        self.draw_bodies(pass, variant, kind, slot);
        self.points.draw(pass, view_index);
        self.lines.draw(pass, view_index);
    }

    /// Puts the air before a picture that the host has drawn from a prepared view: attenuates its colours (linear
    /// Rec. 709) wavelength by wavelength, and adds the light that is scattered into the lines of sight up to its depth.
    /// Where the depth is that of nothing the colour stays: the sky is drawn there by [`draw`](Self::draw).
    ///
    /// `colour_in`, `depth` and `colour_out` have the same size and one sample a pixel; perspective and orthographic
    /// projections of any kind. Call after [`prepare`](Self::prepare), once for each view of a frame.
    pub fn apply_air(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        colour_in: &wgpu::TextureView,
        depth: &wgpu::TextureView,
        colour_out: &wgpu::TextureView,
        view_index: usize,
        air: &ApplyAir<'_>,
    ) -> Result<(), GpuError> {
        let Some(view) = self.views.get(view_index).copied() else {
            return Err(GpuError::View(format!(
                "view {view_index} was not prepared: the frame has {} views",
                self.views.len()
            )));
        };
        if self.apply.is_none() {
            self.apply = Some(Apply::new(&self.device, &self.air, &self.air_view_layout)?);
        }
        let Some(apply) = &mut self.apply else { return Err(GpuError::Device("no passes".into())) };
        let way = |altitude_m: f64| (altitude_m * (2.0 * self.bottom_radius_m + altitude_m)).max(0.0).sqrt();
        let longest_m = 2.0 * way(self.top_altitude_m);
        let (buffer, offset, uniform) = apply.uniform(&view, view_index, air, longest_m)?;
        self.uploads.write(encoder, &buffer, offset, bytemuck::bytes_of(&uniform));
        self.uploads.belts[self.uploads.turn].finish();
        let view_offset = ((view_index as u64 + 1) * self.view_stride) as u32;
        let marching = self.marching.get(view_index).copied().unwrap_or(true);
        let pictures = [colour_in, depth, colour_out];
        let (group, views) = (&self.air.group, &self.air_view_group);
        apply.record(
            &self.device,
            encoder,
            group,
            views,
            view_offset,
            view_index,
            pictures,
            air,
            marching,
            self.eclipsed,
        )
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

    /// What pipelines of a view differ in; `rows`: of its whole picture, 0: not known.
    fn kind(&self, view_index: usize, rows: u32) -> Kind {
        let view = self.views.get(view_index);
        let projection = view.map(|view| view.projection);
        let pixel_rad = view.map_or(1e-3, |view| match rows {
            // A guess on the safe side.
            0 => 3.0 * view.degrees_per_pixel(PICTURE_ROWS).to_radians(),
            rows => view.degrees_per_pixel(rows).to_radians(),
        });
        Kind {
            linear: matches!(projection, Some(Projection::Matrix(_))),
            lights: self.lights,
            tonemap: self.tonemap,
            eclipsed: self.eclipsed,
            night: self.by_night,
            grid: self.gridded.get(view_index + 1).copied().unwrap_or(false),
            points: self.points.reads(view_index),
            glare: self.points.reads(view_index) && self.points.glares(),
            occluded: self.occluded,
            moon: self.with_moon.map(|moon| moon.kind(pixel_rad)),
        }
    }

    fn set_slot(&self, pass: &mut wgpu::RenderPass<'_>, variant: Variant, kind: Kind, slot: usize) {
        pass.set_pipeline(&self.pipelines.get(variant, kind));
        pass.set_bind_group(0, &self.air.group, &[]);
        pass.set_bind_group(1, &self.view_group, &[(slot as u64 * self.view_stride) as u32]);
        if !variant.bodies() {
            pass.set_bind_group(3, self.points.read_group(), &[]);
            let grid = self.night_grid.as_ref().and_then(NightGrid::group).unwrap_or(&self.no_grid);
            pass.set_bind_group(2, grid, &[]);
        }
    }

    fn draw_bodies(&self, pass: &mut wgpu::RenderPass<'_>, variant: Variant, kind: Kind, slot: usize) {
        if let Some(bodies) = self.bodies.as_ref().filter(|bodies| bodies.count(slot) > 0) {
            self.set_slot(pass, variant, kind, slot);
            bodies.draw(pass, slot);
        }
    }

    fn record_metering(&self, encoder: &mut wgpu::CommandEncoder, mut stamps: Option<&mut Stamps>) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("metering picture"),
            color_attachments: &[Some(cleared(&self.meter.picture))],
            timestamp_writes: stamps.as_mut().and_then(|stamps| stamps.next("metering picture")),
            ..Default::default()
        });
        let marching = self.marching.first().copied().unwrap_or(true);
        let variant = if marching { Variant::MeteringMarch } else { Variant::MeteringTable };
        let kind = self.kind(0, meter::SIZE.1);
        self.set_slot(&mut pass, variant, kind, 0);
        pass.draw(0..3, 0..1);
        let variant = if marching { Variant::MeteringBodies } else { Variant::MeteringBodiesTable };
        self.draw_bodies(&mut pass, variant, kind, 0);
        drop(pass);
        self.meter.reduce(encoder, stamps.and_then(|stamps| stamps.next("meter")));
    }

    /// The uniform of a view, and where it stands. `tiled`: whether it is drawn in tiles where it does not march.
    fn view_uniform(&self, frame: &FrameState, view: &View, tiled: bool) -> Result<Standing, GpuError> {
        let radius_m = self.bottom_radius_m;
        let r = radius_m + frame.altitude_m;
        // Where the camera is from the planet's centre; altitude as (r² − R²) / (r + R), which cancels nothing.
        let shift = view.enu_from_view.w_axis.truncate();
        let centre = shift + DVec3::new(0.0, 0.0, r);
        let excess =
            frame.altitude_m * (2.0 * radius_m + frame.altitude_m) + 2.0 * r * shift.z + shift.length_squared();
        // Half a metre: f32 cannot hold less above a planet, and eyes are higher. A camera inside the planet stands on it.
        let altitude_m = (excess / (radius_m + (radius_m * radius_m + excess).max(0.0).sqrt())).clamp(0.5, 1e15);
        let view_from_enu = glam::DMat3::from_mat4(view.enu_from_view).transpose();
        let up = centre.normalize_or(DVec3::Z);
        let [ray_origin, ray_x, ray_y] = view.rays()?.map(|ray| ray.as_vec3().to_array());
        // The camera's heading on the horizon, for equirectangular pictures.
        let forward = view.enu_from_view.transform_vector3(-DVec3::Z);
        let level = (forward - up * forward.dot(up)).normalize_or(DVec3::Y);
        let into_view = |direction: DVec3| (view_from_enu * direction).normalize_or(DVec3::Z).as_vec3().to_array();
        let light = |sun: &SunState| {
            let direction = sun.direction.normalize_or(DVec3::Z);
            let heading = direction - up * direction.dot(up);
            LightUniform {
                direction: into_view(direction),
                radius: sun.radius_rad as f32,
                disc_direction: into_view(sun.disc_direction),
                disc_visible: u32::from(sun.disc),
                irradiance: sun.irradiance.map(|value| value as f32),
                heading: into_view(heading.normalize_or(up.any_orthonormal_vector())),
                mu_s: direction.dot(up).clamp(-1.0, 1.0) as f32,
            }
        };
        let mut lights = [LightUniform::default(); MOST_LIGHTS];
        for (slot, sun) in lights.iter_mut().zip(frame.suns()) {
            *slot = light(sun);
        }
        let horizon_mu = himmel_air::geometry::horizon_cosine(radius_m, altitude_m);
        let horizon = horizon_mu.asin();
        // The corona reaches 40 radii.
        let reaches = std::iter::once(if frame.occluder.is_some() { 40.0 } else { 1.1 }).chain(std::iter::repeat(1.1));
        let tile_lights: Vec<TileLight> = (frame.suns().zip(reaches))
            .map(|(sun, reach)| TileLight {
                direction: Some(sun.direction.normalize_or(DVec3::Z)),
                moon: false,
                disc_direction: sun.disc_direction.normalize_or(DVec3::Z),
                reach_rad: reach * sun.radius_rad,
            })
            .chain(frame.moon.iter().map(|moon| TileLight {
                direction: None,
                moon: true,
                disc_direction: moon.disc_direction.normalize_or(DVec3::Z),
                reach_rad: 1.1 * moon.radius_rad,
            }))
            .collect();
        let within = altitude_m < MARCH_ABOVE_M.min(MARCH_ABOVE_SHARE * self.top_altitude_m);
        // An eclipse is not the same on both sides of the Sun.
        let sky_view = within && self.air.sizes.sky_view.is_some() && frame.shadow.is_none();
        let linear = matches!(view.projection, Projection::Matrix(_));
        let grid = self.with_grid && sky_view && tiled && linear && frame.night.is_some();
        let clear = if grid { grid::SPACING_OF_TILE } else { 0.0 };
        let tiles =
            if sky_view && tiled { Tiles::new(view, up, horizon, &tile_lights, clear)? } else { Tiles::default() };
        let rows = if view.rows_px > 0 { view.rows_px } else { PICTURE_ROWS };
        let mut sample_rad = view.degrees_per_pixel(rows).to_radians();
        if grid {
            sample_rad = sample_rad.max(grid::spacing_rad(view));
        }
        let [icrs_from_view, ecliptic_from_view] =
            frame.night.as_ref().map_or_else(Default::default, |night| night.axes(view_from_enu, sample_rad));
        let night_unit = frame.night.as_ref().map_or(1.0, |night| self.night_unit(night));
        let (projection, half_angle) = match view.projection {
            Projection::Matrix(_) => (0, 0.0),
            Projection::Fisheye(span) => (1, 0.5 * span as f32),
            Projection::Equirectangular => (2, 0.0),
        };
        let [left, bottom, width, height] = view.part.map(|value| value as f32);
        let uniform = ViewUniform {
            ray_origin,
            projection,
            ray_x,
            half_angle,
            ray_y,
            aspect: view.aspect as f32,
            up: into_view(up),
            altitude_m: altitude_m as f32,
            east: into_view(level.cross(up)),
            station: 0,
            north: into_view(level),
            sky_view: u32::from(sky_view),
            tile: [2.0 * left + width - 1.0, 2.0 * bottom + height - 1.0, width, height],
            pixel: view.first_pixel.map(|pixel| pixel as f32),
            horizon: horizon as f32,
            horizon_mu: horizon_mu as f32,
            rectangles: tiles.rectangles,
            night_unit,
            icrs_from_view,
            ecliptic_from_view,
            lights,
            disc: DiscUniform::new(
                frame.sun.direction.normalize_or(DVec3::Z),
                frame.sun.radius_rad,
                frame.occluder.as_ref(),
                view_from_enu,
            ),
            shadow: frame
                .shadow
                .as_ref()
                .map_or_else(ShadowUniform::default, |shadow| ShadowUniform::new(shadow, view_from_enu)),
            moon: frame.moon.as_ref().map_or_else(MoonUniform::default, |moon| {
                MoonUniform::new(moon, &frame.bending, view_from_enu, self.moon.span_km())
            }),
            ..ViewUniform::default()
        };
        Ok(Standing { uniform, up, altitude_m, tiles: tiles.ranges, grid })
    }

    /// Luminance of about the glow of a night, cd/m²: half floats hold a grid in units of it.
    fn night_unit(&self, night: &NightGlow) -> f32 {
        let [r, g, b] =
            [&self.colours.rec709_from_four_r, &self.colours.rec709_from_four_g, &self.colours.rec709_from_four_b].map(
                |row| {
                    row.iter()
                        .zip(night.diffuse)
                        .zip(night.pollution)
                        .map(|((c, d), p)| c * (d + p) as f32)
                        .sum::<f32>()
                },
            );
        (0.2126 * r + 0.7152 * g + 0.0722 * b).max(1e-8)
    }
}

/// Light of all airs of a frame is at the same wavelengths.
fn same_wavelengths<'a>(airs: impl Iterator<Item = &'a Atmosphere>, nm: [f64; 4]) -> Result<(), GpuError> {
    for air in airs {
        if air.wavelengths_nm() != nm {
            let theirs = air.wavelengths_nm();
            return Err(GpuError::Air(format!("of another body is at {theirs:?} nm, that of the sky at {nm:?} nm")));
        }
    }
    Ok(())
}

fn uniform_buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// With what the air needs of a view, and with all.
fn view_groups(
    device: &wgpu::Device,
    [air_layout, layout]: [&wgpu::BindGroupLayout; 2],
    buffer: &wgpu::Buffer,
    air: &Air,
    sampler: &wgpu::Sampler,
    night: &NightTextures,
    moon: &MoonTextures,
) -> [wgpu::BindGroup; 2] {
    let [cells, sky_view] = air.stations.views();
    let view = Bound::Part(buffer, size_of::<ViewUniform>() as u64);
    let bound = [(0, view), (1, Bound::View(&cells)), (2, Bound::View(&sky_view)), (3, Bound::Sampler(sampler))];
    let air_group = bind(device, "air view", air_layout, &bound);
    let bound: Vec<_> = bound.into_iter().chain(night.bound()).chain(moon.bound()).collect();
    [air_group, bind(device, "sky view", layout, &bound)]
}
