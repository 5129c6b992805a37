use crate::body::Body;
use crate::ephemeris::Ephemeris;
use crate::error::Result;
use crate::events::{Crossing, CrossingKind, Horizon, PhaseEvent, crossings, moon_phases, transits};
use crate::place::Place;
use crate::time::{DeltaTModel, Instant};

/// A named moment of a day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlmanacEvent {
    /// The name in the command line's JSON: `sunrise`, `civil_dawn`, `moonset` ….
    pub name: &'static str,
    /// When it happens first in the span; `None` where it does not.
    pub instant: Option<Instant>,
}

/// What a body does in the span.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyDay {
    /// It crosses the horizon.
    Crosses,
    /// It stays above.
    AlwaysUp,
    /// It stays below.
    AlwaysDown,
}

impl BodyDay {
    fn of(crossings: &[Crossing], up: bool) -> Self {
        match (crossings.is_empty(), up) {
            (false, _) => Self::Crosses,
            (true, true) => Self::AlwaysUp,
            (true, false) => Self::AlwaysDown,
        }
    }

    /// For the Sun: `rises or sets`, `polar day`, `polar night`.
    pub fn sun_words(self) -> &'static str {
        match self {
            Self::Crosses => "rises or sets",
            Self::AlwaysUp => "polar day",
            Self::AlwaysDown => "polar night",
        }
    }

    /// For a twilight's limit: `begins or ends`, `lasts all day` (the Sun stays above it: no night of that kind), `never reached`.
    pub fn twilight_words(self) -> &'static str {
        match self {
            Self::Crosses => "begins or ends",
            Self::AlwaysUp => "lasts all day",
            Self::AlwaysDown => "never reached",
        }
    }

    /// For the Moon: `rises or sets`, `always up`, `always down`.
    pub fn moon_words(self) -> &'static str {
        match self {
            Self::Crosses => "rises or sets",
            Self::AlwaysUp => "always up",
            Self::AlwaysDown => "always down",
        }
    }
}

/// A day of Sun and Moon at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Almanac {
    /// In the order of the command line: the Sun's, the twilights', the Moon's moments.
    pub events: Vec<AlmanacEvent>,
    /// What the Sun does.
    pub sun: BodyDay,
    /// What the Moon does.
    pub moon: BodyDay,
    /// Darkest kind of night reached: whether the Sun stays above −6°, −12°, −18° all the time (`white nights`).
    pub twilights: [BodyDay; 3],
    /// The Moon's phases in the span.
    pub phases: Vec<PhaseEvent>,
}

/// The almanac of a span, usually a civil day: definitions of [`Horizon`], first occurrences.
pub fn almanac(
    ephemeris: &dyn Ephemeris,
    place: &Place,
    (from, to): (Instant, Instant),
    model: DeltaTModel,
) -> Result<Almanac> {
    let span = (from.tt(), to.tt());
    let mut events = Vec::new();
    let mut look = |body, horizon, rise: &'static str, set: &'static str| -> Result<BodyDay> {
        let (found, up) = crossings(ephemeris, body, horizon, place, span, model)?;
        for (name, kind) in [(rise, CrossingKind::Rise), (set, CrossingKind::Set)] {
            let first = found.iter().find(|c| c.kind == kind).map(|c| c.instant);
            events.push(AlmanacEvent { name, instant: first });
        }
        Ok(BodyDay::of(&found, up))
    };
    let sun = look(Body::Sun, Horizon::SunConvention, "sunrise", "sunset")?;
    let twilights = [
        look(Body::Sun, Horizon::CivilTwilight, "civil_dawn", "civil_dusk")?,
        look(Body::Sun, Horizon::NauticalTwilight, "nautical_dawn", "nautical_dusk")?,
        look(Body::Sun, Horizon::AstronomicalTwilight, "astronomical_dawn", "astronomical_dusk")?,
    ];
    let moon = look(Body::Moon, Horizon::UpperLimb, "moonrise", "moonset")?;
    for (body, name) in [(Body::Sun, "solar_noon"), (Body::Moon, "moon_transit")] {
        let upper = transits(ephemeris, body, place, span, model)?.into_iter().find(|t| t.upper);
        events.push(AlmanacEvent { name, instant: upper.map(|t| t.instant) });
    }
    let phases = moon_phases(ephemeris, span, model)?;
    Ok(Almanac { events, sun, moon, twilights, phases })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fast;

    #[test]
    fn an_ordinary_and_a_polar_day() {
        let day = |text: &str| {
            let from = Instant::parse(text).unwrap();
            (from, from.plus_seconds(86_400.0).unwrap())
        };
        let potsdam = Place::from_degrees(52.4, 13.06, 35.0).unwrap();
        let a = almanac(&Fast, &potsdam, day("2012-09-06T00:00Z"), DeltaTModel::Standard).unwrap();
        assert_eq!(a.sun, BodyDay::Crosses);
        let at = |name| a.events.iter().find(|e| e.name == name).unwrap().instant.unwrap().tt();
        assert!(at("astronomical_dawn") < at("nautical_dawn") && at("civil_dawn") < at("sunrise"));
        assert!(at("sunrise") < at("solar_noon") && at("solar_noon") < at("sunset") && at("sunset") < at("civil_dusk"));
        let svalbard = Place::from_degrees(78.2, 15.6, 0.0).unwrap();
        let a = almanac(&Fast, &svalbard, day("2021-12-21T00:00Z"), DeltaTModel::Standard).unwrap();
        assert_eq!((a.sun, a.sun.sun_words()), (BodyDay::AlwaysDown, "polar night"));
        assert!(a.events[0].instant.is_none());
    }
}
