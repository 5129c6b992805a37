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
    eclipse: wgpu::Texture,
    /// Radius of the occluder that the eclipse table holds; 0: none.
    eclipse_b: f64,
    frame_buffer: wgpu::Buffer,
    exposure: wgpu::TextureView,
    /// Finished tables of airs that were in hand before.
    kept: Kept,
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
        let textures = [&tables.density, &tables.depth, &tables.moments, &tables.peaks].map(layers);
        let ground = tables.ground.create_view(&Default::default());
        let eclipse = tables::eclipse_texture(device);
        let group = bind(
            device,
            "air",
            &layout,
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
        );
        let mut builder = Builder::new(device, queue, &sizes, &tables)?;
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
            self.kept.keep(device, queue, self.key(device)?, self.tables.computed());
        }
        let renewed = self.take(device, queue, sizes, atmosphere)?;
        if self.kept.capacity() > 0 && self.kept.restore(device, queue, &self.key(device)?, self.tables.computed()) {
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
        let new = Self::with_prepared(device, queue, sizes, atmosphere, &prepared, &frame_buffer, &exposure)?;
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

    /// What the tables are made of.
    pub(crate) fn key(&self, device: &wgpu::Device) -> Result<TablesKey, GpuError> {
        TablesKey::new(&self.sizes, &self.tables, &device.adapter_info())
    }

    /// Starts to read the finished tables back.
    pub(crate) fn save(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<TablesReadBack, GpuError> {
        if !self.builder.is_complete() {
            return Err(GpuError::Tables("they are not finished: wait until nothing is rebuilding".into()));
        }
        Ok(TablesReadBack::new(device, queue, self.key(device)?, self.tables.computed()))
    }

    /// Fills the tables from what was saved.
    pub(crate) fn load(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> Result<(), GpuError> {
        saved::load(queue, &self.key(device)?, self.tables.computed(), bytes)?;
        self.builder.finish();
        Ok(())
    }

    /// Values of the shaders' overrides for the air in hand.
    pub(crate) fn constants(&self) -> [(&'static str, f64); 2] {
        self.tables.constants()
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
        self.builder.record(device, encoder, pace, write);
    }

    pub(crate) fn rebuilding(&self) -> Option<Rebuild> {
        self.builder.state()
    }

    pub(crate) fn cancel(&mut self) {
        self.builder.cancel();
    }

    /// Memory in bytes: tables, those that are kept, and what building them needs.
    pub(crate) fn bytes(&self) -> u64 {
        self.tables.bytes() + self.stations.bytes() + self.builder.bytes() + self.kept.bytes()
    }

    /// The quality's sizes with a number of cells chosen by hand.
    pub(crate) fn sizes_of(quality: AirQuality, steps: Option<u32>) -> AirSizes {
        let sizes = AirSizes::of(quality);
        AirSizes { steps: steps.unwrap_or(sizes.steps).clamp(4, 4096), ..sizes }
    }
}
