//! The sky as a library. This is the facade; for now it knows places by name.
pub mod place;
