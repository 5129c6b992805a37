use super::{Ephemeris, State};
use crate::body::Body;
use crate::constants::SECONDS_PER_DAY;
use crate::error::Result;
use crate::time::JulianDateTdb;
use std::sync::{Mutex, PoisonError};

/// Wraps another level and keeps two samples a body, between which it draws the cubic that has both places and both
/// velocities (Hermite). For clocks that run on and on: a game's frames, a time-lapse.
///
/// The error is f⁗ h⁴ / 384: with the default step of 900 s less than 0.1 m for the Moon and for Mercury.
pub struct Cached<E> {
    inner: E,
    step_days: f64,
    /// By body; the Moon's slot holds it from the Earth's centre.
    samples: Mutex<[Option<Samples>; Body::ALL.len()]>,
}

#[derive(Clone, Copy)]
struct Samples {
    index: f64,
    ends: [State; 2],
}

impl<E: Ephemeris> Cached<E> {
    /// Seconds between samples unless the caller chooses.
    pub const DEFAULT_STEP_S: f64 = 900.0;

    /// With samples every 15 minutes.
    pub fn new(inner: E) -> Self {
        Self { inner, step_days: Self::DEFAULT_STEP_S / SECONDS_PER_DAY, samples: Mutex::new([None; Body::ALL.len()]) }
    }

    /// With samples every so many seconds, 1..=86,400.
    pub fn with_step(inner: E, step_s: f64) -> Result<Self> {
        crate::error::in_range("cache step", "1..=86400 s", step_s, 1.0, 86_400.0, "")?;
        Ok(Self { step_days: step_s / SECONDS_PER_DAY, ..Self::new(inner) })
    }

    /// The wrapped level.
    pub fn inner(&self) -> &E {
        &self.inner
    }

    fn between(
        &self,
        body: Body,
        tdb: JulianDateTdb,
        sample: impl Fn(JulianDateTdb) -> Result<State>,
    ) -> Result<State> {
        let steps = tdb.jd() / self.step_days;
        let index = steps.floor();
        let slot = body as usize;
        let known = self.samples.lock().unwrap_or_else(PoisonError::into_inner)[slot];
        let samples = match known {
            Some(s) if s.index == index => s,
            _ => {
                let at = |i: f64| JulianDateTdb::new(i * self.step_days).and_then(&sample);
                // A clock that moves on by one step needs only one new sample.
                let first = match known {
                    Some(s) if s.index == index - 1.0 => s.ends[1],
                    _ => at(index)?,
                };
                let fresh = Samples { index, ends: [first, at(index + 1.0)?] };
                self.samples.lock().unwrap_or_else(PoisonError::into_inner)[slot] = Some(fresh);
                fresh
            }
        };
        Ok(hermite(samples.ends, steps - index, self.step_days * SECONDS_PER_DAY))
    }
}

/// The cubic with the given ends at t = 0 and 1, `h_s` seconds apart.
fn hermite([a, b]: [State; 2], t: f64, h_s: f64) -> State {
    let (t2, t3) = (t * t, t * t * t);
    // Written from the first end so that the large part of the places cancels exactly.
    let step = b.position_m - a.position_m;
    let position = a.position_m
        + step * (3.0 * t2 - 2.0 * t3)
        + a.velocity_m_s * (h_s * (t3 - 2.0 * t2 + t))
        + b.velocity_m_s * (h_s * (t3 - t2));
    let velocity = step * ((6.0 * t - 6.0 * t2) / h_s)
        + a.velocity_m_s * (3.0 * t2 - 4.0 * t + 1.0)
        + b.velocity_m_s * (3.0 * t2 - 2.0 * t);
    State { position_m: position, velocity_m_s: velocity }
}

impl<E: Ephemeris> Ephemeris for Cached<E> {
    fn name(&self) -> &'static str {
        "cached"
    }

    fn state(&self, body: Body, tdb: JulianDateTdb) -> Result<State> {
        if body == Body::Moon {
            return self.earth_and_moon(tdb).map(|(earth, moon)| earth + moon);
        }
        self.between(body, tdb, |at| self.inner.state(body, at))
    }

    fn earth_and_moon(&self, tdb: JulianDateTdb) -> Result<(State, State)> {
        let earth = self.between(Body::Earth, tdb, |at| self.inner.state(Body::Earth, at))?;
        let moon = self.between(Body::Moon, tdb, |at| self.inner.earth_and_moon(at).map(|(_, moon)| moon))?;
        Ok((earth, moon))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::Precise;

    /// Tolerance 5 m: a Julian date in f64 counts 40 µs, in which Mercury moves 2 m.
    #[test]
    fn cached_places_are_the_inner_ones() {
        let precise = Precise::embedded().unwrap();
        let cached = Cached::new(precise.clone());
        for i in 0..500 {
            let tdb = JulianDateTdb::new(2_451_545.0 + f64::from(i) * 0.003_33).unwrap();
            for body in Body::ALL {
                let (a, b) = (cached.state(body, tdb).unwrap(), precise.state(body, tdb).unwrap());
                assert!((a.position_m - b.position_m).length() < 5.0, "{body} at {}", tdb.jd());
                assert!((a.velocity_m_s - b.velocity_m_s).length() < 1e-2, "{body} at {}", tdb.jd());
            }
        }
    }
}
