//! Where the bodies are, in m and m/s along GCRS axes: one trait, several levels.

mod cached;
mod fast;
mod pack;
mod precise;

pub use cached::Cached;
pub use fast::Fast;
pub use precise::Precise;

use crate::body::Body;
use crate::error::Result;
use crate::time::JulianDateTdb;
use glam::DVec3;

/// Where a body is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Along GCRS axes.
    pub position_m: DVec3,
    /// Its rate of change per TDB second.
    pub velocity_m_s: DVec3,
}

impl std::ops::Add for State {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { position_m: self.position_m + other.position_m, velocity_m_s: self.velocity_m_s + other.velocity_m_s }
    }
}

impl std::ops::Sub for State {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { position_m: self.position_m - other.position_m, velocity_m_s: self.velocity_m_s - other.velocity_m_s }
    }
}

/// A source of geometric places (no light time, no aberration).
pub trait Ephemeris: Send + Sync {
    /// The level's name for messages.
    fn name(&self) -> &'static str;

    /// A body from the level's origin: the barycentre of the solar system (precise) or the Sun (fast; the Sun's own
    /// 13 m/s then miss from aberration, 0.01″). Mars to Pluto are the barycentres of their systems.
    fn state(&self, body: Body, tdb: JulianDateTdb) -> Result<State>;

    /// The Earth from the origin, and the Moon from the Earth.
    fn earth_and_moon(&self, tdb: JulianDateTdb) -> Result<(State, State)>;
}
