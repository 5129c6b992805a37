//! The air: sunlight scattered any number of times on its way to you, and the extinction of everything behind it.
//!
//! - **What it is**: a table of six moments of the scattered light over altitude and Sun, filled order by order when the
//!   medium changes ([`build`]); from it a march along each ray, into a sky-view table that pixels look up ([`AirQuality`]
//!   low to high) or for every pixel (film, from above the air, in eclipses). The model, and the twin of every function
//!   in the shaders, is [`himmel_air::moments`].
//! - **What it costs**: `docs/air-on-the-gpu.md` has the tables of time, memory and error. The Sun's motion rebuilds
//!   nothing but the sky view.
//! - **What it leaves out**: polarisation, terrain in the multiple scattering.
//! - **Known to look wrong**: see [`himmel_air::moments`]: the zenith of Mars with the Sun at the horizon, thick haze near
//!   a low Sun, beneath the clouds of Venus.

mod apply;
pub mod build;
mod query;
mod saved;
mod sizes;
mod stations;
mod tables;
pub mod uniform;

use std::sync::Arc;

use himmel_air::eclipse::EclipseTable;
use himmel_air::moments::Prepared;
use himmel_air::{AirQuality, Atmosphere};

use crate::error::GpuError;
use crate::frame::FrameUniform;
use crate::pass::{Bound, Slot, bind, layers, layout};
pub(crate) use apply::Apply;
pub use apply::{ApplyAir, ApplyUniform, ShadowMap};
use build::{Builder, Pace, Rebuild, Upload};
pub use query::{Query, RayAnswer, RayMeter};
pub(crate) use saved::Kept;
pub use saved::{TablesKey, TablesReadBack};
pub use sizes::AirSizes;
pub(crate) use stations::{Stations, view_slot};
use tables::Tables;
use uniform::{AirUniform, MOST_BODIES};

/// All of the air: tables, the passes that fill them, the group that shaders read them by.
pub(crate) struct Air {
    pub sizes: AirSizes,
    tables: Tables,
    builder: Builder,
    pub stations: Stations,
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    peak_layers: usize,
    /// The airs of other bodies.
    far: Vec<FarAir>,
    eclipse: wgpu::Texture,
    /// Radius of the occluder that the eclipse table holds; 0: none.
    eclipse_b: f64,
    frame_buffer: wgpu::Buffer,
    exposure: wgpu::TextureView,
    /// Finished tables of airs that were in hand before.
    kept: Kept,
}

/// The air of another body.
struct FarAir {
    atmosphere: Arc<Atmosphere>,
    peak_layers: usize,
    first_layer: usize,
    /// While its tables are not full.
    builder: Option<Builder>,
    cancelled: bool,
}

impl Air {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        sizes: AirSizes,
        atmosphere: &Atmosphere,
        frame_buffer: &wgpu::Buffer,
        exposure: &wgpu::TextureView,
    ) -> Result<Self, GpuError> {
        let prepared = Prepared::new(&atmosphere.sampled(), &sizes.moments);
        Self::with_prepared(device, queue, sizes, atmosphere, &prepared, frame_buffer, exposure)
    }

    fn with_prepared(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        sizes: AirSizes,
        atmosphere: &Atmosphere,
        prepared: &Prepared,
        frame_buffer: &wgpu::Buffer,
        exposure: &wgpu::TextureView,
    ) -> Result<Self, GpuError> {
        let peak_layers = prepared.aerosols.len().max(1);
        let mut tables = Tables::new(device, &sizes, 1, peak_layers as u32);
        tables.upload(queue, 0, atmosphere, prepared, 0)?;
        let uniform = |size: usize| Slot::Uniform(size as u64, false);
        let slots = [
            (0, uniform(size_of::<FrameUniform>())),
            (1, uniform(MOST_BODIES * size_of::<AirUniform>())),
            (2, Slot::Layers),
            (3, Slot::Layers),
            (4, Slot::Layers),
            (5, Slot::Layers),
            (6, Slot::Table),
            (7, Slot::Table),
            (8, Slot::Table),
        ];
        let layout = layout(device, "air", wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE, &slots);
        let eclipse = tables::eclipse_texture(device);
        let group = air_group(device, &layout, &tables, frame_buffer, exposure, &eclipse);
        let mut builder = Builder::new(device, queue, &sizes, &tables, 0)?;
        builder.begin(0, true);
        let stations = Stations::new(device, &sizes, &tables, &layout)?;
        Ok(Self {
            sizes,
            tables,
            builder,
            stations,
            layout,
            group,
            peak_layers,
            far: Vec::new(),
            eclipse,
            eclipse_b: 0.0,
            frame_buffer: frame_buffer.clone(),
            exposure: exposure.clone(),
            kept: Kept::default(),
        })
    }

    /// Takes another medium; true if the tables, and with them every bind group, are new. Tables that were kept need no
    /// rebuild.
    pub(crate) fn set(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        sizes: AirSizes,
        atmosphere: &Atmosphere,
    ) -> Result<bool, GpuError> {
        if self.builder.is_complete() && self.kept.capacity() > 0 {
            self.kept.keep(device, queue, self.key(device, 0)?, self.tables.computed(0));
        }
        let renewed = self.take(device, queue, sizes, atmosphere)?;
        if self.kept.capacity() > 0 && self.kept.restore(device, queue, &self.key(device, 0)?, self.tables.computed(0))
        {
            self.builder.finish();
        }
        Ok(renewed)
    }

    fn take(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        sizes: AirSizes,
        atmosphere: &Atmosphere,
    ) -> Result<bool, GpuError> {
        let prepared = Prepared::new(&atmosphere.sampled(), &sizes.moments);
        if sizes == self.sizes && prepared.aerosols.len().max(1) == self.peak_layers {
            let before = self.constants();
            self.tables.upload(queue, 0, atmosphere, &prepared, 0)?;
            if before == self.constants() {
                self.builder.begin(0, true);
                return Ok(false);
            }
        }
        let (frame_buffer, exposure) = (self.frame_buffer.clone(), self.exposure.clone());
        let mut new = Self::with_prepared(device, queue, sizes, atmosphere, &prepared, &frame_buffer, &exposure)?;
        let far: Vec<_> = self.far.iter().map(|far| Arc::clone(&far.atmosphere)).collect();
        new.set_far(device, queue, &far)?;
        let kept = std::mem::take(&mut self.kept);
        *self = Self { kept, ..new };
        Ok(true)
    }

    /// The tables of so many airs stay on the GPU when others take their place.
    pub(crate) fn set_kept(&mut self, count: usize) {
        self.kept.set_capacity(count);
    }

    /// Their memory in bytes.
    pub(crate) fn kept_bytes(&self) -> u64 {
        self.kept.bytes()
    }

    /// Takes the airs of other bodies; true if the bind group of the tables is new. Those that stay where they were are not
    /// rebuilt.
    pub(crate) fn set_far(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        airs: &[Arc<Atmosphere>],
    ) -> Result<bool, GpuError> {
        let stays = |index: usize| {
            let (old, new) = (self.far.get(index), airs.get(index));
            old.zip(new).is_some_and(|(old, new)| Arc::ptr_eq(&old.atmosphere, new))
        };
        if airs.len() == self.far.len() && (0..airs.len()).all(stays) {
            return Ok(false);
        }
        if airs.len() >= MOST_BODIES {
            let most = MOST_BODIES - 1;
            return Err(GpuError::Air(format!("of {} other bodies; the renderer takes at most {most}", airs.len())));
        }
        let prepared: Vec<_> = airs.iter().map(|air| Prepared::new(&air.sampled(), &self.sizes.moments)).collect();
        // Everything that can fail comes before anything that changes.
        for (air, prepared) in airs.iter().zip(&prepared) {
            AirUniform::new(air, prepared, 0)?;
        }
        let kept: Vec<bool> = (0..airs.len()).map(stays).collect();
        let layers = |prepared: &Prepared| prepared.aerosols.len().max(1);
        let room = (airs.len() as u32 + 1, (self.peak_layers + prepared.iter().map(layers).sum::<usize>()) as u32);
        let renewed = room != self.tables.room();
        if renewed {
            let mut tables = Tables::new(device, &self.sizes, room.0, room.1);
            tables.take(device, queue, &self.tables, 1 + airs.len().min(self.far.len()));
            self.tables = tables;
            self.builder.rebind(device, &self.tables);
            for builder in self.far.iter_mut().filter_map(|far| far.builder.as_mut()) {
                builder.rebind(device, &self.tables);
            }
            self.group =
                air_group(device, &self.layout, &self.tables, &self.frame_buffer, &self.exposure, &self.eclipse);
        }
        let mut old: Vec<_> = std::mem::take(&mut self.far).into_iter().map(Some).collect();
        let mut first_layer = self.peak_layers;
        for (index, (air, prepared)) in airs.iter().zip(&prepared).enumerate() {
            let body = index + 1;
            let known = old.get_mut(index).and_then(Option::take).filter(|_| kept[index]);
            if known.as_ref().is_none_or(|far| far.first_layer != first_layer) {
                self.tables.upload(queue, body, air, prepared, first_layer)?;
            }
            let far = match known {
                Some(far) => FarAir { first_layer, ..far },
                None => {
                    let mut builder = Builder::new(device, queue, &self.sizes, &self.tables, body)?;
                    builder.begin(body as u32, true);
                    let (atmosphere, peak_layers) = (Arc::clone(air), layers(prepared));
                    FarAir { atmosphere, peak_layers, first_layer, builder: Some(builder), cancelled: false }
                }
            };
            first_layer += far.peak_layers;
            self.far.push(far);
        }
        if !airs.is_empty() {
            self.stations.with_far(device, &self.layout, self.all_constants())?;
        }
        Ok(renewed)
    }

    /// The airs of other bodies.
    pub(crate) fn far(&self) -> impl Iterator<Item = &Atmosphere> {
        self.far.iter().map(|far| far.atmosphere.as_ref())
    }

    /// What the tables of a body are made of.
    pub(crate) fn key(&self, device: &wgpu::Device, body: usize) -> Result<TablesKey, GpuError> {
        if body > self.far.len() {
            return Err(GpuError::Tables(format!("there are {} airs of other bodies, not {body}", self.far.len())));
        }
        TablesKey::new(&self.sizes, &self.tables, body, &device.adapter_info())
    }

    fn is_complete(&self, body: usize) -> bool {
        match body.checked_sub(1) {
            None => self.builder.is_complete(),
            Some(index) => self.far.get(index).is_some_and(|far| far.builder.is_none() && !far.cancelled),
        }
    }

    /// Starts to read the finished tables back.
    pub(crate) fn save(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        body: usize,
    ) -> Result<TablesReadBack, GpuError> {
        let key = self.key(device, body)?;
        if !self.is_complete(body) {
            return Err(GpuError::Tables("they are not finished: wait until nothing is rebuilding".into()));
        }
        Ok(TablesReadBack::new(device, queue, key, self.tables.computed(body)))
    }

    /// Fills the tables from what was saved.
    pub(crate) fn load(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        body: usize,
        bytes: &[u8],
    ) -> Result<(), GpuError> {
        saved::load(queue, &self.key(device, body)?, self.tables.computed(body), bytes)?;
        match body.checked_sub(1).and_then(|index| self.far.get_mut(index)) {
            None => self.builder.finish(),
            Some(far) => (far.builder, far.cancelled) = (None, false),
        }
        Ok(())
    }

    /// Values of the shaders' overrides for the air in hand.
    pub(crate) fn constants(&self) -> [(&'static str, f64); 2] {
        self.tables.constants(0..1)
    }

    /// The same for shaders that go from body to body.
    pub(crate) fn all_constants(&self) -> [(&'static str, f64); 2] {
        self.tables.constants(0..self.far.len() + 1)
    }

    /// Makes the eclipse table fit an occluder of so many radii of the Sun; returns the radius that it holds for.
    pub(crate) fn eclipse(&mut self, queue: &wgpu::Queue, b: f64, limb: &[[f64; 6]; 4]) -> f64 {
        // A tenth of a per cent: the table is good to 1e-3 half a per cent away.
        if (b / self.eclipse_b.max(1e-12) - 1.0).abs() > 1e-3 {
            let table = EclipseTable::new(b, limb);
            let texels: Vec<[f32; 4]> = table.texels.iter().map(|texel| texel.map(|value| value as f32)).collect();
            tables::write(queue, &self.eclipse, 0, &texels);
            self.eclipse_b = b;
        }
        self.eclipse_b
    }

    /// Makes room for stations and lights; true if bind groups with the stations' tables are stale.
    pub(crate) fn reserve(&mut self, device: &wgpu::Device, stations: u32, lights: u32) -> bool {
        self.stations.reserve(device, &self.sizes, stations, lights)
    }

    /// Records what is left to build.
    pub(crate) fn build(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pace: Pace,
        write: &mut Upload<'_>,
    ) {
        let busy = self.builder.state().is_some();
        self.builder.record(device, encoder, pace, write);
        if busy && pace != Pace::AtOnce {
            return;
        }
        for far in &mut self.far {
            let Some(builder) = &mut far.builder else { continue };
            builder.record(device, encoder, pace, write);
            if builder.state().is_none() {
                far.builder = None;
            }
            if pace != Pace::AtOnce {
                return;
            }
        }
    }

    pub(crate) fn rebuilding(&self) -> Option<Rebuild> {
        self.builder.state().or_else(|| self.far.iter().find_map(|far| far.builder.as_ref()?.state()))
    }

    pub(crate) fn cancel(&mut self) {
        self.builder.cancel();
        for far in &mut self.far {
            far.cancelled |= far.builder.take().is_some();
        }
    }

    /// Memory in bytes: tables, those that are kept, and what building them needs.
    pub(crate) fn bytes(&self) -> u64 {
        let far: u64 = self.far.iter().filter_map(|far| far.builder.as_ref()).map(Builder::bytes).sum();
        self.tables.bytes() + self.stations.bytes() + self.builder.bytes() + far + self.kept.bytes()
    }

    /// The quality's sizes with a number of cells chosen by hand.
    pub(crate) fn sizes_of(quality: AirQuality, steps: Option<u32>) -> AirSizes {
        let sizes = AirSizes::of(quality);
        AirSizes { steps: steps.unwrap_or(sizes.steps).clamp(4, 4096), ..sizes }
    }
}

/// The group that shaders read the air by.
fn air_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    tables: &Tables,
    frame_buffer: &wgpu::Buffer,
    exposure: &wgpu::TextureView,
    eclipse: &wgpu::Texture,
) -> wgpu::BindGroup {
    let textures = [&tables.density, &tables.depth, &tables.moments, &tables.peaks].map(layers);
    let ground = tables.ground.create_view(&Default::default());
    bind(
        device,
        "air",
        layout,
        &[
            (0, Bound::Buffer(frame_buffer)),
            (1, Bound::Buffer(&tables.uniforms)),
            (2, Bound::View(&textures[0])),
            (3, Bound::View(&textures[1])),
            (4, Bound::View(&textures[2])),
            (5, Bound::View(&textures[3])),
            (6, Bound::View(exposure)),
            (7, Bound::View(&ground)),
            (8, Bound::View(&eclipse.create_view(&Default::default()))),
        ],
    )
}
