//! Shared f64 mathematics of Himmel: physical constants, spectra, colour, interpolation, and the
//! parameters that describe themselves. No GPU, no I/O.
//!
//! ```
//! use himmel_core::spectrum::Spectrum;
//! // Rayleigh scattering falls with the fourth power of the wavelength.
//! let rayleigh = Spectrum::PowerLaw { reference_nm: 1000.0, value: 1.24062e-6, exponent: -4.0 };
//! assert!((rayleigh.at(550.0) - 1.3558e-5).abs() < 1e-9);
//! ```

pub mod colour;
pub mod constants;
pub mod interpolate;
pub mod params;
pub mod quadrature;
pub mod spectrum;
pub mod vision;
