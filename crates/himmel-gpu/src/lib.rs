//! The sky on the GPU: draws into *your* render pass, behind *your* geometry.
//!
//! [`SkyRenderer`] is made once for a [`Target`]; each frame [`SkyRenderer::prepare`] uploads one small uniform for the
//! frame and one for each [`View`], and [`SkyRenderer::draw`] draws a view at infinite depth. [`Gpu`] finds an adapter
//! where the host brings none, and [`Still`] renders pictures of any size in tiles. Most users want the crate `himmel`,
//! which joins this with place and time.

pub mod comparison;
mod error;
pub mod frame;
mod gpu;
pub mod layout;
pub mod output;
mod pass;
pub mod phenomena;
mod renderer;
pub mod shader;
mod sky_pipelines;
mod still;
mod target;
mod tiles;
mod timing;
mod view;

pub use error::GpuError;
pub use frame::MOST_LIGHTS;
pub use gpu::{AdapterReport, Gpu};
pub use output::bloom::{BloomFrame, BloomPass};
pub use output::params::{Adaptation, Bloom, Exposure, OutputParams, Tonemap};
pub use phenomena::air::build::{Pace, Rebuild};
pub use phenomena::air::{AirSizes, ApplyAir, RayAnswer, RayMeter, ShadowMap, TablesKey, TablesReadBack};
pub use phenomena::bodies::{AlbedoMap, AlbedoMapError, FarBody, FarLight, MOST_FAR_BODIES};
pub use phenomena::night_glow::NightGlow;
pub use phenomena::overlay::{
    Anchor, Label, LabelKind, LabelList, LineKind, LineList, LinePiece, MOST_NAMED_BODIES, NameColour, NamedBody,
    Names, NamesParams, Overlay, OverlayParams, Typeface,
};
pub use phenomena::planets::{PlanetDisc, PlanetsParams};
pub use phenomena::stars::{
    Glare, Hider, MOST_BODIES, PointBody, PointSpread, StarField, StarList, StarPoint, StarsParams,
};
pub use phenomena::sun::Occluder;
pub use renderer::{FrameState, SkyRenderer, SunState};
pub use still::{MAX_PIXELS, MAX_SIDE, Picture, Pixels, Still};
pub use target::{DepthDirection, Output, Target};
pub use timing::PassTimes;
pub use view::{Projection, View};
