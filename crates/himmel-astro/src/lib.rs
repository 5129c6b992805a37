//! Where everything in the sky is, and how bright. f64, no GPU, no I/O.
