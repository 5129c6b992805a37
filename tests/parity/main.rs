//! Parity: what the GPU computes against the f64 twins, on the adapter that is printed.

mod allocation;
mod functions;
mod host;
mod pictures;
mod sun;
