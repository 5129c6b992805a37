//! Parity: what the GPU computes against the f64 twins, on the adapter that is printed.

mod air;
mod allocation;
mod apply_air;
mod bloom;
mod bodies;
mod day;
mod functions;
mod host;
mod moon;
mod names;
mod night;
mod pictures;
mod saved;
mod stars;
mod sun;
