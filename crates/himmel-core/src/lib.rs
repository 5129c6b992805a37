//! Shared f64 mathematics of Himmel. No GPU, no I/O.
