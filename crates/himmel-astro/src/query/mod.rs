//! Questions and answers in the formats of the command line, so that it only has to read and write.

mod almanac;
mod ephemeris;
mod target;

pub use almanac::{Almanac, AlmanacEvent, BodyDay, almanac};
pub use ephemeris::{Answer, Conditions, EphemerisTable};
pub use target::Target;
