use super::lunar_eclipse::{least_separation, mean_syzygies};
use super::search::{minimum, zero};
use crate::apparent::{Apparent, Observer};
use crate::body::Body;
use crate::ephemeris::Ephemeris;
use crate::error::Result;
use crate::physical::angle_between;
use crate::place::Place;
use crate::time::{DeltaTModel, Instant, JulianDateTt};
use std::f64::consts::PI;

/// What a solar eclipse is at the place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum SolarEclipseKind {
    Partial,
    Annular,
    Total,
}

impl SolarEclipseKind {
    /// As the command line prints it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Partial => "partial",
            Self::Annular => "annular",
            Self::Total => "total",
        }
    }
}

/// A contact or the greatest phase of a solar eclipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolarMoment {
    /// When.
    pub instant: Instant,
    /// Airless altitude of the Sun's centre.
    pub sun_altitude_rad: f64,
    /// Its azimuth, from north through east.
    pub sun_azimuth_rad: f64,
}

/// A solar eclipse at a place; mean limb, Moon 1737.4 km (k = 0.2724).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolarEclipse {
    /// Least separation of the centres.
    pub greatest: SolarMoment,
    /// What it is here.
    pub kind: SolarEclipseKind,
    /// Covered part of the Sun's diameter along the line of centres, (s_s + s_m − d) / 2 s_s; above 1 when total.
    pub magnitude: f64,
    /// Covered part of the Sun's area.
    pub obscuration: f64,
    /// First touch.
    pub c1: SolarMoment,
    /// Totality or the ring begins.
    pub c2: Option<SolarMoment>,
    /// Totality or the ring ends.
    pub c3: Option<SolarMoment>,
    /// Last touch.
    pub c4: SolarMoment,
}

/// Part of a disc of radius `a` that one of radius `b` covers, the centres `d` apart: the lens of two circles   [meeus1998, ch. 54].
///
/// Laws tested: 0 at touch from outside, 1 when swallowed, (b/a)² for a ring, continuous between.
pub(crate) fn covered_part(a: f64, b: f64, d: f64) -> f64 {
    if d >= a + b {
        return 0.0;
    }
    if d <= (a - b).abs() {
        return (b / a).min(1.0).powi(2);
    }
    let cos_a = ((d * d + a * a - b * b) / (2.0 * d * a)).clamp(-1.0, 1.0);
    let cos_b = ((d * d + b * b - a * a) / (2.0 * d * b)).clamp(-1.0, 1.0);
    let (half_a, half_b) = (cos_a.acos(), cos_b.acos());
    let lens = a * a * (half_a - half_a.sin() * cos_a) + b * b * (half_b - half_b.sin() * cos_b);
    lens / (PI * a * a)
}

/// Sun and Moon at one instant from the place.
struct Pair {
    sun: Apparent,
    separation: f64,
    sun_radius: f64,
    moon_radius: f64,
}

/// The Sun's centre at −50′ still shows its upper limb.
const LOWEST_VISIBLE_RAD: f64 = -50.0 / 60.0 * PI / 180.0;

/// All solar eclipses of which the place sees some part, greatest phase within the span.
pub fn solar_eclipses(
    ephemeris: &dyn Ephemeris,
    place: &Place,
    (from, to): (JulianDateTt, JulianDateTt),
    model: DeltaTModel,
) -> Result<Vec<SolarEclipse>> {
    super::check_span(ephemeris, from, to)?;
    let instant_at = |jd: f64| JulianDateTt::new(jd).map(|tt| Instant::from_tt(tt, model));
    let pair = |jd: f64| -> Result<Pair> {
        let observer = Observer::new(ephemeris, &instant_at(jd)?, place)?;
        let (sun, moon) = (observer.apparent(Body::Sun)?, observer.apparent(Body::Moon)?);
        Ok(Pair {
            separation: angle_between(sun.direction_gcrs, moon.direction_gcrs),
            sun_radius: sun.semidiameter_rad(),
            moon_radius: moon.semidiameter_rad(),
            sun,
        })
    };
    let moment = |jd: f64| -> Result<SolarMoment> {
        let sun = pair(jd)?.sun;
        Ok(SolarMoment {
            instant: instant_at(jd)?,
            sun_altitude_rad: sun.altitude_rad,
            sun_azimuth_rad: sun.azimuth_rad,
        })
    };
    let mut found = Vec::new();
    for guess in mean_syzygies(from, to, 0.0) {
        if pair(guess)?.separation > 0.25 {
            continue;
        }
        let distance = |x: f64| pair(x).map(|p| p.separation);
        // Parallax can make several minima in a day: look every two hours, then at the least one.
        let mut best = (f64::INFINITY, guess);
        for i in -12..=12 {
            let x = guess + f64::from(i) / 12.0;
            let d = distance(x)?;
            if d < best.0 {
                best = (d, x);
            }
        }
        if best.0 > 0.05 {
            continue;
        }
        let (coarse, least) = minimum(distance, best.1 - 1.0 / 12.0, best.1 + 1.0 / 12.0, 1e-3)?;
        if least > 0.012 {
            continue;
        }
        let greatest = least_separation(distance, coarse)?;
        let p = pair(greatest)?;
        if greatest < from.jd() || greatest > to.jd() || p.separation >= p.sun_radius + p.moon_radius {
            continue;
        }
        let contact = |depth: &dyn Fn(&Pair) -> f64, side: f64| -> Result<Option<SolarMoment>> {
            let f = |x: f64| pair(x).map(|p| depth(&p));
            let middle = f(greatest)?;
            if middle <= 0.0 {
                return Ok(None);
            }
            // Step out until the discs are apart, so that a second approach of the same day cannot be mistaken for it.
            let (mut a, mut fa) = (greatest, middle);
            for _ in 0..24 {
                let b = a + side * 0.25 / 24.0;
                let fb = f(b)?;
                if fb <= 0.0 {
                    return moment(zero(f, a, fa, b, fb)?).map(Some);
                }
                (a, fa) = (b, fb);
            }
            Ok(None)
        };
        let outer = |p: &Pair| p.sun_radius + p.moon_radius - p.separation;
        let inner = |p: &Pair| (p.moon_radius - p.sun_radius).abs() - p.separation;
        let (Some(c1), Some(c4)) = (contact(&outer, -1.0)?, contact(&outer, 1.0)?) else {
            continue;
        };
        let (c2, c3) = (contact(&inner, -1.0)?, contact(&inner, 1.0)?);
        let mut visible = false;
        for i in 0..=12 {
            let (a, b) = (c1.instant.tt().jd(), c4.instant.tt().jd());
            visible |= pair(a + (b - a) * f64::from(i) / 12.0)?.sun.altitude_rad > LOWEST_VISIBLE_RAD;
        }
        if !visible {
            continue;
        }
        found.push(SolarEclipse {
            greatest: moment(greatest)?,
            kind: match (c2, p.moon_radius >= p.sun_radius) {
                (None, _) => SolarEclipseKind::Partial,
                (Some(_), true) => SolarEclipseKind::Total,
                (Some(_), false) => SolarEclipseKind::Annular,
            },
            magnitude: (p.sun_radius + p.moon_radius - p.separation) / (2.0 * p.sun_radius),
            obscuration: covered_part(p.sun_radius, p.moon_radius, p.separation),
            c1,
            c2,
            c3,
            c4,
        });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Precise;

    #[test]
    fn covered_part_obeys_its_laws() {
        assert_eq!(covered_part(1.0, 0.9, 1.9), 0.0);
        assert_eq!(covered_part(1.0, 1.1, 0.05), 1.0);
        assert!((covered_part(1.0, 0.9, 0.05) - 0.81).abs() < 1e-12);
        assert!((covered_part(1.0, 0.9, 0.1 + 1e-9) - 0.81).abs() < 1e-4);
        assert!(covered_part(1.0, 0.9, 1.9 - 1e-9) < 1e-9);
        // Two equal discs, one radius apart: 2/3 − √3/(2π).
        assert!((covered_part(1.0, 1.0, 1.0) - (2.0 / 3.0 - 3f64.sqrt() / (2.0 * PI))).abs() < 1e-14);
    }

    /// Issue 3: Stuttgart, 1999-08-11: totality 10:32:53.7 to 10:35:14.8 UTC within 2 s.
    #[test]
    fn stuttgart_1999() {
        let precise = Precise::embedded().unwrap();
        let place = Place::from_degrees(48.7758, 9.1829, 245.0).unwrap();
        let span = (JulianDateTt::new(2_451_179.5).unwrap(), JulianDateTt::new(2_451_544.5).unwrap());
        let list = solar_eclipses(&precise, &place, span, DeltaTModel::Standard).unwrap();
        assert_eq!(list.len(), 1);
        let e = list[0];
        assert_eq!(e.kind, SolarEclipseKind::Total);
        let seconds = |m: SolarMoment| ((m.instant.utc().jd() + 0.5).fract() * 86_400.0) - 10.0 * 3600.0;
        let (c2, c3) = (seconds(e.c2.unwrap()), seconds(e.c3.unwrap()));
        println!("Stuttgart 1999: c2 {c2:.2} s, c3 {c3:.2} s after 10:00 UTC");
        assert!((c2 - (32.0 * 60.0 + 53.7)).abs() < 2.0, "{c2}");
        assert!((c3 - (35.0 * 60.0 + 14.8)).abs() < 2.0, "{c3}");
        assert!(e.magnitude > 1.0 && e.obscuration == 1.0);
    }

    /// Mazatlán 2024-04-08 is total; Albuquerque 2023-10-14 annular.
    #[test]
    fn ring_and_total() {
        let precise = Precise::embedded().unwrap();
        let span = (JulianDateTt::new(2_460_200.5).unwrap(), JulianDateTt::new(2_460_500.5).unwrap());
        for (lat, lon, kind, jd) in [
            (23.2494, -106.4111, SolarEclipseKind::Total, 2_460_409.26),
            (35.08, -106.65, SolarEclipseKind::Annular, 2_460_232.19),
        ] {
            let place = Place::from_degrees(lat, lon, 0.0).unwrap();
            let list = solar_eclipses(&precise, &place, span, DeltaTModel::Standard).unwrap();
            let e = list.iter().find(|e| (e.greatest.instant.tt().jd() - jd).abs() < 0.05).unwrap();
            assert_eq!(e.kind, kind);
            let order = [e.c1, e.c2.unwrap(), e.greatest, e.c3.unwrap(), e.c4].map(|m| m.instant.tt().jd());
            assert!(order.windows(2).all(|w| w[0] < w[1]));
        }
    }
}
