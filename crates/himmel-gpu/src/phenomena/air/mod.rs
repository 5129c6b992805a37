//! The air: sunlight scattered on its way to you, and the extinction of everything behind it.
//!
//! - **What it is**: a march along each pixel's ray over the lit part of the air, with the optical depth to the Sun from
//!   a table. The model, and the twin of every function in `air.wgsl`, is [`himmel_air`].
//! - **What it costs**: 32 samples a pixel, each two reads of the medium, four of scattering, four of optical depth and
//!   two exponentials. Tables: 1.13 MiB. No table depends on the Sun, so time costs nothing.
//! - **What it leaves out**: light that is scattered more than once. Skies are therefore too dark, most so at the
//!   horizon, in twilight and in haze; by how much is measured once the reference tracer exists. The moment table of the issue
//!   "The air on the GPU" adds it at the line marked "Orders ≥ 2".
//! - **Known to look wrong**: haze (`earth-haze`, `titan-reference`) is far too dark and too contrasty for the same
//!   reason; the Sun is a point for shadows, so the edge of the Earth's shadow is sharper than in nature; refraction
//!   moves the Sun's disc but does not flatten it.

mod tables;

pub(crate) use tables::Tables;
