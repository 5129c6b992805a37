use super::search::zero;
use crate::apparent::Observer;
use crate::body::Body;
use crate::ephemeris::Ephemeris;
use crate::error::Result;
use crate::time::{DeltaTModel, Instant, JulianDateTt};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The Moon's four named phases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum MoonPhase {
    New,
    FirstQuarter,
    Full,
    LastQuarter,
}

impl MoonPhase {
    /// As the almanac prints it.
    pub fn name(self) -> &'static str {
        match self {
            Self::New => "new moon",
            Self::FirstQuarter => "first quarter",
            Self::Full => "full moon",
            Self::LastQuarter => "last quarter",
        }
    }
}

/// A phase and its instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseEvent {
    /// When.
    pub instant: Instant,
    /// Which.
    pub phase: MoonPhase,
}

/// Apparent geocentric ecliptic longitude of the Moon minus the Sun's, −π..=π.
pub(super) fn moon_minus_sun_rad(ephemeris: &dyn Ephemeris, instant: &Instant) -> Result<f64> {
    let observer = Observer::geocentric(ephemeris, instant)?;
    let ecliptic = observer.orientation.ecliptic_of_date_from_gcrs();
    let longitude = |body| -> Result<f64> {
        let v = ecliptic * observer.apparent(body)?.direction_gcrs;
        Ok(v.y.atan2(v.x))
    };
    Ok((longitude(Body::Moon)? - longitude(Body::Sun)? + PI).rem_euclid(TAU) - PI)
}

/// All new moons, quarters and full moons in a span: apparent geocentric longitudes 0°, 90°, 180°, 270° apart.
pub fn moon_phases(
    ephemeris: &dyn Ephemeris,
    (from, to): (JulianDateTt, JulianDateTt),
    model: DeltaTModel,
) -> Result<Vec<PhaseEvent>> {
    super::check_span(ephemeris, from, to)?;
    let angle = |jd: f64| moon_minus_sun_rad(ephemeris, &Instant::from_tt(JulianDateTt::new(jd)?, model));
    let quarter = |a: f64| (a.rem_euclid(TAU) / FRAC_PI_2).floor() as i64;
    // Two days move the Moon by at most 30°: never over two phases.
    let steps = ((to.jd() - from.jd()) / 2.0).ceil().max(1.0);
    let step = (to.jd() - from.jd()) / steps;
    let mut found = Vec::new();
    let (mut a, mut fa) = (from.jd(), angle(from.jd())?);
    for i in 1..=steps as u64 {
        let b = if i as f64 == steps { to.jd() } else { from.jd() + step * i as f64 };
        let fb = angle(b)?;
        if quarter(fa) != quarter(fb) {
            let target = quarter(fb) as f64 * FRAC_PI_2;
            let past = |x: f64| (x - target + PI).rem_euclid(TAU) - PI;
            let jd = zero(|x| angle(x).map(past), a, past(fa), b, past(fb))?;
            let phase = match quarter(fb) {
                0 => MoonPhase::New,
                1 => MoonPhase::FirstQuarter,
                2 => MoonPhase::Full,
                _ => MoonPhase::LastQuarter,
            };
            found.push(PhaseEvent { instant: Instant::from_tt(JulianDateTt::new(jd)?, model), phase });
        }
        (a, fa) = (b, fb);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fast;

    /// [meeus1998, examples 49.a and 49.b]: new moon 1977-02-18 3:37:42 TD, last quarter 2044-01-21 23:48:17 TD. Tolerance 20 s.
    #[test]
    fn phases_of_meeus() {
        for (jd, phase) in [(2_443_192.651_18, MoonPhase::New), (2_467_636.491_86, MoonPhase::LastQuarter)] {
            let span = (JulianDateTt::new(jd - 1.0).unwrap(), JulianDateTt::new(jd + 1.0).unwrap());
            let found = moon_phases(&Fast, span, DeltaTModel::Standard).unwrap();
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].phase, phase);
            assert!((found[0].instant.tt().jd() - jd).abs() * 86_400.0 < 20.0, "{}", found[0].instant.tt().jd());
        }
    }

    #[test]
    fn phases_follow_one_another() {
        let span = (JulianDateTt::new(2_451_545.0).unwrap(), JulianDateTt::new(2_451_545.0 + 365.25).unwrap());
        let found = moon_phases(&Fast, span, DeltaTModel::Standard).unwrap();
        assert!((48..=50).contains(&found.len()));
        for pair in found.windows(2) {
            let days = pair[1].instant.tt().jd() - pair[0].instant.tt().jd();
            assert!((6.5..8.4).contains(&days) && (pair[1].phase as i32 - pair[0].phase as i32).rem_euclid(4) == 1);
        }
    }
}
