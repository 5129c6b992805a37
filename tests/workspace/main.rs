//! Laws of the workspace itself: which crate may know which, that every shader is valid, that layouts agree, that every
//! source is named.

mod arrows;
mod references;
mod shaders;
