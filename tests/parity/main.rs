//! Parity: what the GPU computes against the f64 twins, on the adapter that is printed.

mod air;
mod allocation;
mod apply_air;
mod functions;
mod host;
mod night;
mod pictures;
mod sun;
