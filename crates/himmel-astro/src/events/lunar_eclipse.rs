use super::search::{minimum, zero};
use crate::apparent::Observer;
use crate::body::Body;
use crate::constants::{EARTH_ECLIPSE_RADIUS_M, MOON_RADIUS_M, SUN_RADIUS_M};
use crate::ephemeris::Ephemeris;
use crate::error::Result;
use crate::physical::angle_between;
use crate::time::{DeltaTModel, Instant, JulianDateTt};

/// How much the Earth's air enlarges its shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShadowConvention {
    /// 1.01 π_m + π_s ∓ s_s   [danjon1951; espenak2009], the default of the canons.
    #[default]
    Danjon,
    /// 1.02 (0.99834 π_m + π_s ∓ s_s)   [chauvenet1891; espenak2009].
    Chauvenet,
    /// π_m + π_s ∓ s_s: the bare cone of the equatorial radius, no air.
    Geometric,
    /// 3.6676 − 397.0001 D_m/D_s and 3.6676 + 404.3354 D_m/D_s Moon radii   [mueller2012, eqs. 4.14, 4.15]: the bare cone of the
    /// Earth's mean radius, for comparison with that thesis.
    Thesis,
}

/// How deep the Moon goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum LunarEclipseKind {
    Penumbral,
    Partial,
    Total,
}

impl LunarEclipseKind {
    /// As the command line prints it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Penumbral => "penumbral",
            Self::Partial => "partial",
            Self::Total => "total",
        }
    }
}

/// A lunar eclipse; contacts are `None` where the Moon does not come that deep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LunarEclipse {
    /// Least separation of the Moon from the antisolar point.
    pub greatest: JulianDateTt,
    /// How deep.
    pub kind: LunarEclipseKind,
    /// Part of the Moon's diameter in the umbra at greatest; negative when outside.
    pub umbral_magnitude: f64,
    /// Part of the Moon's diameter in the penumbra at greatest.
    pub penumbral_magnitude: f64,
    /// First touch of the penumbra.
    pub p1: Option<JulianDateTt>,
    /// First touch of the umbra.
    pub u1: Option<JulianDateTt>,
    /// Totality begins.
    pub u2: Option<JulianDateTt>,
    /// Totality ends.
    pub u3: Option<JulianDateTt>,
    /// The umbra is left.
    pub u4: Option<JulianDateTt>,
    /// The penumbra is left.
    pub p4: Option<JulianDateTt>,
}

/// Shadow and Moon at one instant, as angles at the Earth's centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shadow {
    separation_rad: f64,
    umbra_rad: f64,
    penumbra_rad: f64,
    moon_rad: f64,
}

impl ShadowConvention {
    /// Radii of umbra and penumbra at the Moon's distance, as angles at the Earth's centre.
    ///
    /// π: horizontal parallaxes with R = 6378.1366 km; s_s: the Sun's semidiameter with 695,700 km; − umbra, + penumbra.
    pub fn radii_rad(self, moon_distance_m: f64, sun_distance_m: f64) -> (f64, f64) {
        let parallax_moon = (EARTH_ECLIPSE_RADIUS_M / moon_distance_m).min(1.0).asin();
        let parallax_sun = (EARTH_ECLIPSE_RADIUS_M / sun_distance_m).min(1.0).asin();
        let sun = (SUN_RADIUS_M / sun_distance_m).min(1.0).asin();
        if self == Self::Thesis {
            let moon = (MOON_RADIUS_M / moon_distance_m).min(1.0).asin();
            let ratio = moon_distance_m / sun_distance_m;
            return ((3.6676 - 397.0001 * ratio) * moon, (3.6676 + 404.3354 * ratio) * moon);
        }
        let radius = |sun: f64| match self {
            Self::Danjon => 1.01 * parallax_moon + parallax_sun + sun,
            Self::Chauvenet => 1.02 * (0.998_34 * parallax_moon + parallax_sun + sun),
            Self::Geometric | Self::Thesis => parallax_moon + parallax_sun + sun,
        };
        (radius(-sun), radius(sun))
    }
}

/// Apparent geocentric circumstances.
fn shadow(ephemeris: &dyn Ephemeris, jd: f64, convention: ShadowConvention) -> Result<Shadow> {
    let instant = Instant::from_tt(JulianDateTt::new(jd)?, DeltaTModel::Standard);
    let observer = Observer::geocentric(ephemeris, &instant)?;
    let moon = observer.apparent(Body::Moon)?;
    let sun = observer.apparent(Body::Sun)?;
    let (umbra_rad, penumbra_rad) = convention.radii_rad(moon.distance_m, sun.distance_m);
    Ok(Shadow {
        separation_rad: angle_between(moon.direction_gcrs, -sun.direction_gcrs),
        umbra_rad,
        penumbra_rad,
        moon_rad: (MOON_RADIUS_M / moon.distance_m).asin(),
    })
}

/// All lunar eclipses with a positive penumbral magnitude whose greatest phase lies in the span.
pub fn lunar_eclipses(
    ephemeris: &dyn Ephemeris,
    (from, to): (JulianDateTt, JulianDateTt),
    convention: ShadowConvention,
) -> Result<Vec<LunarEclipse>> {
    super::check_span(ephemeris, from, to)?;
    let mut found = Vec::new();
    for guess in mean_syzygies(from, to, 0.5) {
        // The true full moon lies within 0.6 d of the mean one; most are far from the node and cost one look.
        if shadow(ephemeris, guess, convention)?.separation_rad > MOST_AT_GUESS_RAD {
            continue;
        }
        let at = |jd: f64| shadow(ephemeris, jd, convention);
        let (coarse, least) = minimum(|x| at(x).map(|s| s.separation_rad), guess - 0.8, guess + 0.8, 1e-3)?;
        if least > 0.03 {
            continue;
        }
        let greatest = least_separation(|x| at(x).map(|s| s.separation_rad), coarse)?;
        if greatest < from.jd() || greatest > to.jd() {
            continue;
        }
        let s = at(greatest)?;
        let penumbral_magnitude = (s.penumbra_rad + s.moon_rad - s.separation_rad) / (2.0 * s.moon_rad);
        if penumbral_magnitude <= 0.0 {
            continue;
        }
        let umbral_magnitude = (s.umbra_rad + s.moon_rad - s.separation_rad) / (2.0 * s.moon_rad);
        // No contact is further than four hours from greatest.
        let contact = |depth: &dyn Fn(Shadow) -> f64, side: f64| -> Result<Option<JulianDateTt>> {
            let f = |x: f64| at(x).map(depth);
            let middle = f(greatest)?;
            if middle <= 0.0 {
                return Ok(None);
            }
            let end = greatest + side * 4.5 / 24.0;
            let jd = zero(f, greatest, middle, end, f(end)?)?;
            JulianDateTt::new(jd).map(Some)
        };
        let penumbra = |s: Shadow| s.penumbra_rad + s.moon_rad - s.separation_rad;
        let umbra = |s: Shadow| s.umbra_rad + s.moon_rad - s.separation_rad;
        let total = |s: Shadow| s.umbra_rad - s.moon_rad - s.separation_rad;
        found.push(LunarEclipse {
            greatest: JulianDateTt::new(greatest)?,
            kind: if total(s) > 0.0 {
                LunarEclipseKind::Total
            } else if umbral_magnitude > 0.0 {
                LunarEclipseKind::Partial
            } else {
                LunarEclipseKind::Penumbral
            },
            umbral_magnitude,
            penumbral_magnitude,
            p1: contact(&penumbra, -1.0)?,
            u1: contact(&umbra, -1.0)?,
            u2: contact(&total, -1.0)?,
            u3: contact(&total, 1.0)?,
            u4: contact(&umbra, 1.0)?,
            p4: contact(&penumbra, 1.0)?,
        });
    }
    Ok(found)
}

/// Separation beyond which no eclipse follows within 0.8 d of a mean syzygy: 0.7 d at 0.55°/h, and 3°.
const MOST_AT_GUESS_RAD: f64 = 0.22;

/// Julian dates (TT) of mean new moons (phase 0) or full moons (phase 0.5) that may have their true one in the span   [meeus1998, eq. 49.1].
pub(super) fn mean_syzygies(from: JulianDateTt, to: JulianDateTt, phase: f64) -> impl Iterator<Item = f64> {
    let first = ((from.jd() - 2_451_550.097_66) / 29.530_588_861 - phase).floor() as i64 - 1;
    let last = ((to.jd() - 2_451_550.097_66) / 29.530_588_861 - phase).ceil() as i64 + 1;
    (first..=last).map(move |k| {
        let k = k as f64 + phase;
        let t = k / 1236.85;
        2_451_550.097_66 + 29.530_588_861 * k + t * t * (0.000_154_37 + t * (-0.000_000_150 + t * 0.000_000_000_73))
    })
}

/// The minimum near `coarse` to a few milliseconds: the zero of the separation's derivative, by differences over ±0.01 d.
///
/// Golden section alone stops at √ε of the bracket, seconds; the difference of two places 29 min apart sees the slope itself.
pub(super) fn least_separation(mut f: impl FnMut(f64) -> Result<f64>, coarse: f64) -> Result<f64> {
    let mut x = coarse;
    for h in [0.01, 0.01, 0.002] {
        // Near a central passage the separation has a kink; its square is smooth.
        let square = |v: f64| v * v;
        let (a, b, c) = (square(f(x - h)?), square(f(x)?), square(f(x + h)?));
        let curvature = a - 2.0 * b + c;
        if curvature > 0.0 {
            x -= (0.5 * h * (c - a) / curvature).clamp(-0.1, 0.1);
        }
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Precise;

    /// NASA's canon [espenak2009], 2018-07-27: greatest 20:22:54 TD, total, umbral magnitude 1.6087, totality 103 min. Tolerances 30 s
    /// and 0.006: the canon's Moon has another radius. Contacts against DE440 are in `tests/truth.rs`.
    #[test]
    fn the_long_one_of_2018() {
        let precise = Precise::embedded().unwrap();
        let span = (JulianDateTt::new(2_458_300.5).unwrap(), JulianDateTt::new(2_458_400.5).unwrap());
        let list = lunar_eclipses(&precise, span, ShadowConvention::Danjon).unwrap();
        assert_eq!(list.len(), 1);
        let e = list[0];
        assert_eq!(e.kind, LunarEclipseKind::Total);
        assert!((e.greatest.jd() - (2_458_327.0 + (8.0 + 22.0 / 60.0 + 54.0 / 3600.0) / 24.0)).abs() * 86_400.0 < 30.0);
        assert!((e.umbral_magnitude - 1.6087).abs() < 0.006, "{}", e.umbral_magnitude);
        let totality = (e.u3.unwrap().jd() - e.u2.unwrap().jd()) * 1440.0;
        assert!((totality - 103.0).abs() < 1.0, "{totality}");
        let order = [e.p1, e.u1, e.u2, Some(e.greatest), e.u3, e.u4, e.p4].map(|t| t.unwrap().jd());
        assert!(order.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn conventions_at_the_mean_distance() {
        let moon = (MOON_RADIUS_M / 384_400e3).asin();
        let ratio = |c: ShadowConvention| c.radii_rad(384_400e3, 1.495_978_707e11).0 / moon;
        assert!((ratio(ShadowConvention::Danjon) - 2.688).abs() < 0.005);
        assert!((ratio(ShadowConvention::Geometric) - 2.650).abs() < 0.005);
        assert!((ratio(ShadowConvention::Thesis) - 2.648).abs() < 0.001);
        assert!(ratio(ShadowConvention::Chauvenet) > ratio(ShadowConvention::Danjon));
    }
}
