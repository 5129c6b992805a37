//! Parity: what the GPU computes against the f64 twins, on the adapter that is printed.

mod air;
mod apply_air;
mod allocation;
mod functions;
mod host;
mod pictures;
