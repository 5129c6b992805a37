//! The sky as a library: for any date and place, in physical units, drawn into *your* render pass.
//!
//! ```no_run
//! # fn host(device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder, render_pass: &mut wgpu::RenderPass<'_>) -> himmel::Result<()> {
//! use himmel::{DepthDirection, Observer, Output, Preset, Sky, Target, View};
//! use wgpu::TextureFormat::{Depth32Float, Rgba16Float};
//!
//! let target = Target { colour: Rgba16Float, depth: Some((Depth32Float, DepthDirection::Reversed)), samples: 1, output: Output::Display };
//! let mut sky = Sky::new(device, queue, &target, &Preset::named("earth")?)?;       // once
//! sky.set_observer(Observer::at("Potsdam")?).set_time("2012-09-06T18:00Z")?;
//!
//! let views = [View::looking(4.5, 0.2, 1.0, 16.0 / 9.0)];
//! sky.prepare(encoder, &views)?;          // each frame: small uploads, any number of views
//! sky.draw(render_pass, 0);               // inside your pass, behind your geometry
//! let light = sky.light()?;               // direction, colour, illuminance: for your scene
//! # Ok(()) }
//! ```
//!
//! [`SkyModel`] is the same sky without a GPU, [`ReferencePicture`] its picture by a Monte Carlo tracer. [`Scene`] is everything that decides a picture, as a file.

pub mod bench;
pub mod bench_stars;
pub mod bodies;
mod clock;
mod error;
mod light;
mod light_meter;
mod model;
mod moon;
mod names;
mod night;
mod observer;
pub mod picture;
pub mod place;
mod points;
mod rays;
mod scene;
mod sky;
pub mod spectral;
mod tables_cache;

pub use clock::{Clock, parse_time};
pub use error::{Error, Result};
pub use himmel_air::{AirParams, AirQuality, GroundParams, Preset, SunParams};
pub use himmel_core::params;
pub use himmel_gpu::{
    Adaptation, AdapterReport, AirSizes, AlbedoMap, ApplyAir, Bloom, BloomFrame, BloomPass, DepthDirection, Exposure,
    FarBody, FarLight, Glare, Gpu, GpuError, NameColour, NamesParams, Occluder, Output, OutputParams, OverlayParams,
    Pace, PassTimes, Picture, Pixels, PlanetsParams, PointSpread, Projection, RayMeter, Rebuild, ShadowMap,
    SkyRenderer, StarsParams, Still, TablesKey, TablesReadBack, Target, Tonemap, View,
};
pub use light::{AmbientLight, Light, LightSource, SunLight, limiting_magnitude};
pub use light_meter::{LightMeter, LightSolver, LightSpectrum, Measured, MeasuredLight};
pub use model::{SkyModel, SunPlace, direction_enu, visible_fraction};
pub use moon::Moon;
pub use night::NightZenith;
pub use observer::Observer;
pub use rays::{Seen, rays_on_gpu};
pub use scene::{CameraParams, ClockParams, ObserverParams, ProjectionKind, Scene};
pub use sky::Sky;
pub use spectral::ReferencePicture;
pub use tables_cache::TablesCache;

// Their types are in this API.
pub use glam;
pub use wgpu;

/// The crates that this one joins, for those who want to go deeper.
pub mod parts {
    pub use himmel_air as air;
    pub use himmel_astro as astro;
    pub use himmel_core as core;
    pub use himmel_gpu as gpu;
}
