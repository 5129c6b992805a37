use super::search::{minimum, zero};
use crate::apparent::Observer;
use crate::body::Body;
use crate::ephemeris::Ephemeris;
use crate::error::{Result, in_range};
use crate::place::Place;
use crate::time::{DeltaTModel, Instant, JulianDateTt};
use std::f64::consts::PI;

/// What counts as risen, by airless topocentric altitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Horizon {
    /// Centre at −50′: the Sun by convention (34′ refraction, 16′ radius).
    SunConvention,
    /// Upper limb, with the body's true radius, at −34′: the Moon.
    UpperLimb,
    /// Centre at −34′: stars and planets.
    Centre,
    /// Sun's centre at −6°.
    CivilTwilight,
    /// Sun's centre at −12°.
    NauticalTwilight,
    /// Sun's centre at −18°.
    AstronomicalTwilight,
    /// The caller's own: altitude of the visible horizon (mountains; negative from a tower), refraction there, and whether the
    /// upper limb counts.
    Custom {
        /// Altitude of the horizon.
        horizon_rad: f64,
        /// Refraction at the horizon.
        refraction_rad: f64,
        /// Upper limb instead of centre.
        upper_limb: bool,
    },
}

const REFRACTION_AT_HORIZON_RAD: f64 = 34.0 / 60.0 * PI / 180.0;

impl Horizon {
    /// The caller's own horizon, −10..=80°, and refraction, 0..=2°.
    pub fn custom(horizon_deg: f64, refraction_deg: f64, upper_limb: bool) -> Result<Self> {
        in_range("altitude of the horizon", "-10..=80 degrees", horizon_deg, -10.0, 80.0, "")?;
        in_range("refraction at the horizon", "0..=2 degrees", refraction_deg, 0.0, 2.0, "")?;
        Ok(Self::Custom {
            horizon_rad: horizon_deg.to_radians(),
            refraction_rad: refraction_deg.to_radians(),
            upper_limb,
        })
    }

    /// Airless altitude of the centre at the crossing, for a body of this semidiameter.
    fn altitude_rad(self, semidiameter_rad: f64) -> f64 {
        match self {
            Self::SunConvention => (-50.0 / 60.0_f64).to_radians(),
            Self::UpperLimb => -REFRACTION_AT_HORIZON_RAD - semidiameter_rad,
            Self::Centre => -REFRACTION_AT_HORIZON_RAD,
            Self::CivilTwilight => (-6.0_f64).to_radians(),
            Self::NauticalTwilight => (-12.0_f64).to_radians(),
            Self::AstronomicalTwilight => (-18.0_f64).to_radians(),
            Self::Custom { horizon_rad, refraction_rad, upper_limb } => {
                horizon_rad - refraction_rad - if upper_limb { semidiameter_rad } else { 0.0 }
            }
        }
    }
}

/// Which way a body crosses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrossingKind {
    /// Upwards: rise, dawn.
    Rise,
    /// Downwards: set, dusk.
    Set,
}

/// A body on a horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// When.
    pub instant: Instant,
    /// Up or down.
    pub kind: CrossingKind,
    /// Where, from north through east.
    pub azimuth_rad: f64,
}

/// A body on the meridian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transit {
    /// When.
    pub instant: Instant,
    /// Above the pole (culmination) or below it.
    pub upper: bool,
    /// Airless altitude.
    pub altitude_rad: f64,
}

/// Samples of the altitude are this far apart; a body that rises and sets again between two of them is caught by its maximum.
const STEP_DAYS: f64 = 1.0 / 48.0;

/// All crossings of a horizon in a span, and whether the body was up at its beginning.
///
/// A body that only grazes the horizon for less than half an hour is found too. Empty means: always up or always down, as the flag says.
pub fn crossings(
    ephemeris: &dyn Ephemeris,
    body: Body,
    horizon: Horizon,
    place: &Place,
    (from, to): (JulianDateTt, JulianDateTt),
    model: DeltaTModel,
) -> Result<(Vec<Crossing>, bool)> {
    super::check_span(ephemeris, from, to)?;
    let height = |jd: f64| -> Result<f64> {
        let instant = Instant::from_tt(JulianDateTt::new(jd)?, model);
        let seen = Observer::new(ephemeris, &instant, place)?.apparent(body)?;
        Ok(seen.altitude_rad - horizon.altitude_rad(seen.semidiameter_rad()))
    };
    let mut found = Vec::new();
    let steps = ((to.jd() - from.jd()) / STEP_DAYS).ceil().max(1.0);
    let step = (to.jd() - from.jd()) / steps;
    // One sample more on either side, where the ephemeris reaches: a graze at the very edge shows only in three.
    let lead = from.jd() - step;
    let mut before: Option<(f64, f64)> = height(lead).ok().map(|f| (lead, f));
    let (mut a, mut fa) = (from.jd(), height(from.jd())?);
    let up_at_start = fa > 0.0;
    for i in 1..=steps as u64 + 1 {
        let b = if i as f64 == steps { to.jd() } else { from.jd() + step * i as f64 };
        let fb = match height(b) {
            Err(_) if b > to.jd() => break,
            other => other?,
        };
        if (fa > 0.0) != (fb > 0.0) {
            found.push((zero(height, a, fa, b, fb)?, fb > 0.0));
        } else if let Some((z, fz)) = before {
            // a lies nearest to the horizon of three on one side: the peak between z and b may cross it.
            let same_side = (fz > 0.0) == (fa > 0.0);
            if same_side && fa.abs() < fz.abs() && fa.abs() <= fb.abs() && fa.abs() < 0.05 {
                let sign = if fa > 0.0 { 1.0 } else { -1.0 };
                let (m, fm) = minimum(|x| height(x).map(|v| v * sign), z, b, 1e-5)?;
                if fm < 0.0 {
                    found.push((zero(height, z, fz, m, fm * sign)?, sign < 0.0));
                    found.push((zero(height, m, fm * sign, b, fb)?, sign > 0.0));
                }
            }
        }
        before = Some((a, fa));
        (a, fa) = (b, fb);
    }
    found.retain(|(jd, _)| (from.jd()..=to.jd()).contains(jd));
    let mut crossings = Vec::with_capacity(found.len());
    for (jd, upwards) in found {
        let instant = Instant::from_tt(JulianDateTt::new(jd)?, model);
        let azimuth_rad = Observer::new(ephemeris, &instant, place)?.apparent(body)?.azimuth_rad;
        let kind = if upwards { CrossingKind::Rise } else { CrossingKind::Set };
        crossings.push(Crossing { instant, kind, azimuth_rad });
    }
    Ok((crossings, up_at_start))
}

/// All passages of the meridian in a span.
pub fn transits(
    ephemeris: &dyn Ephemeris,
    body: Body,
    place: &Place,
    (from, to): (JulianDateTt, JulianDateTt),
    model: DeltaTModel,
) -> Result<Vec<Transit>> {
    super::check_span(ephemeris, from, to)?;
    let at = |jd: f64| -> Result<(f64, f64)> {
        let instant = Instant::from_tt(JulianDateTt::new(jd)?, model);
        let observer = Observer::new(ephemeris, &instant, place)?;
        let seen = observer.apparent(body)?;
        Ok((observer.hour_angle_rad(&seen), seen.altitude_rad))
    };
    let mut found = Vec::new();
    let steps = ((to.jd() - from.jd()) / 0.125).ceil().max(1.0);
    let step = (to.jd() - from.jd()) / steps;
    let (mut a, mut ha) = (from.jd(), at(from.jd())?.0);
    for i in 1..=steps as u64 {
        let b = if i as f64 == steps { to.jd() } else { from.jd() + step * i as f64 };
        let hb = at(b)?.0;
        // sin H crosses zero upwards on the meridian's upper half, downwards on the lower.
        if (ha.sin() > 0.0) != (hb.sin() > 0.0) {
            let jd = zero(|x| at(x).map(|(h, _)| h.sin()), a, ha.sin(), b, hb.sin())?;
            let instant = Instant::from_tt(JulianDateTt::new(jd)?, model);
            found.push(Transit { instant, upper: hb.sin() > 0.0, altitude_rad: at(jd)?.1 });
        }
        (a, ha) = (b, hb);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fast, Precise};

    fn day(jd: f64) -> (JulianDateTt, JulianDateTt) {
        (JulianDateTt::new(jd).unwrap(), JulianDateTt::new(jd + 1.0).unwrap())
    }

    /// Places against DE440 are in `tests/truth.rs`; here the order of a day.
    #[test]
    fn a_day_in_potsdam() {
        let place = Place::from_degrees(52.4, 13.06, 35.0).unwrap();
        let precise = Precise::embedded().unwrap();
        let times = |horizon| {
            let (events, up) =
                crossings(&precise, Body::Sun, horizon, &place, day(2_456_176.5), DeltaTModel::Standard).unwrap();
            assert!(!up && events.len() == 2);
            assert_eq!((events[0].kind, events[1].kind), (CrossingKind::Rise, CrossingKind::Set));
            events.iter().map(|e| e.instant.tt().jd()).collect::<Vec<_>>()
        };
        let (sun, civil) = (times(Horizon::SunConvention), times(Horizon::CivilTwilight));
        let nautical = times(Horizon::NauticalTwilight);
        let noon = transits(&precise, Body::Sun, &place, day(2_456_176.5), DeltaTModel::Standard).unwrap();
        assert_eq!(noon.iter().filter(|t| t.upper).count(), 1);
        assert!(noon.iter().all(|t| t.upper == (t.altitude_rad > 0.0)));
        let upper = noon.iter().find(|t| t.upper).unwrap().instant.tt().jd();
        let order = [nautical[0], civil[0], sun[0], upper, sun[1], civil[1], nautical[1]];
        assert!(order.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn polar_day_and_night_have_no_crossings() {
        let place = Place::from_degrees(78.2, 15.6, 0.0).unwrap();
        for (jd, up) in [(2_459_386.5, true), (2_459_569.5, false)] {
            let (events, was_up) =
                crossings(&Fast, Body::Sun, Horizon::SunConvention, &place, day(jd), DeltaTModel::Standard).unwrap();
            assert!(events.is_empty());
            assert_eq!(was_up, up);
        }
    }

    /// Near the beginning of polar day the Sun sets for minutes only; each set must have its rise.
    #[test]
    fn short_grazes_are_found() {
        let place = Place::from_degrees(70.0, 20.0, 0.0).unwrap();
        let from = JulianDateTt::new(2_459_345.5).unwrap();
        let to = JulianDateTt::new(2_459_360.5).unwrap();
        let (events, _) =
            crossings(&Fast, Body::Sun, Horizon::SunConvention, &place, (from, to), DeltaTModel::Standard).unwrap();
        for pair in events.windows(2) {
            assert!(pair[0].kind != pair[1].kind && pair[0].instant.tt() < pair[1].instant.tt());
        }
        let shortest = events
            .windows(2)
            .filter(|p| p[0].kind == CrossingKind::Set)
            .map(|p| p[1].instant.tt().jd() - p[0].instant.tt().jd())
            .fold(1.0, f64::min);
        assert!(shortest < 0.05, "{shortest}");
    }

    #[test]
    fn backward_and_endless_spans_are_refused() {
        let jd = |v| JulianDateTt::new(v).unwrap();
        let place = Place::GREENWICH_EQUATOR;
        let try_span =
            |a, b| crossings(&Fast, Body::Sun, Horizon::Centre, &place, (jd(a), jd(b)), DeltaTModel::Standard);
        assert!(try_span(2_451_545.0, 2_451_544.0).is_err());
        assert!(try_span(-1_000_000.0, 5_000_000.0).is_err());
    }
}
