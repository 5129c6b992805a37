//! Comets and asteroids from their elements: the two-body problem round the Sun, for any eccentricity.

use crate::apparent::{Apparent, Observer};
use crate::constants::{AU_M, LIGHT_SPEED_M_S, SECONDS_PER_DAY};
use crate::earth::ecliptic_j2000_from_gcrs;
use crate::ephemeris::State;
use crate::error::{AstroError, Result, in_range, shown};
use crate::physical::angle_between;
use crate::time::JulianDateTdb;
use glam::DVec3;

/// GM of the Sun in au³/d²: the square of Gauss' constant   [meeus1998, ch. 33].
const SUN_GM_AU3_D2: f64 = 0.017_202_098_95 * 0.017_202_098_95;

/// How bright a small body is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SmallBodyBrightness {
    /// Asteroids: absolute magnitude H and slope G   [bowell1989].
    Asteroid {
        /// Magnitude at 1 au from Sun and observer at full phase.
        h: f64,
        /// Slope, 0.15 where unknown.
        g: f64,
    },
    /// Comets: m = M₁ + 5 log Δ + K₁ log r.
    Comet {
        /// Magnitude at 1 au from Sun and observer.
        m1: f64,
        /// Slope, about 10.
        k1: f64,
    },
}

/// Elements of an orbit round the Sun, ecliptic and equinox J2000.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitalElements {
    /// Name or designation.
    pub name: String,
    /// Perihelion distance.
    pub perihelion_au: f64,
    /// Eccentricity: 0 circle, below 1 ellipse, 1 parabola, above hyperbola.
    pub eccentricity: f64,
    /// Inclination.
    pub inclination_rad: f64,
    /// Longitude of the ascending node.
    pub node_rad: f64,
    /// Argument of perihelion.
    pub argument_of_perihelion_rad: f64,
    /// Time of perihelion.
    pub perihelion_time: JulianDateTdb,
    /// Brightness where known.
    pub brightness: Option<SmallBodyBrightness>,
}

impl OrbitalElements {
    /// Reads `key=value` pairs separated by commas or blanks: `q` (au), `e`, `i`, `node`, `peri` (degrees), `tp` (Julian date TDB); instead
    /// of `q` and `tp` also `a` (au), `m` (degrees) and `epoch` (Julian date TDB) for ellipses; brightness as `h` and `g`, or `m1` and `k1`. What
    /// stands before the first pair is the name:
    ///
    /// `Halley q=0.5748 e=0.9679 i=162.19 node=59.07 peri=112.24 tp=2446469.97 m1=5.5 k1=8`
    pub fn parse(text: &str) -> Result<Self> {
        let malformed = |reason: String| AstroError::Malformed { what: "orbital elements", text: shown(text), reason };
        let mut name = Vec::new();
        let mut values: Vec<(&str, f64)> = Vec::new();
        for word in text.split([',', ' ', '\t', '\n', '\r']).filter(|w| !w.is_empty()) {
            match word.split_once('=') {
                Some((key, value)) => {
                    let number = value
                        .parse::<f64>()
                        .ok()
                        .filter(|v| v.is_finite())
                        .ok_or_else(|| malformed(format!("`{}` must be a number", shown(key))))?;
                    values.push((key, number));
                }
                None if values.is_empty() => name.push(word),
                None => return Err(malformed(format!("expected key=value, found `{}`", shown(word)))),
            }
        }
        const KEYS: [&str; 13] = ["q", "e", "i", "node", "peri", "tp", "a", "m", "epoch", "h", "g", "m1", "k1"];
        if let Some((key, _)) = values.iter().find(|(k, _)| !KEYS.contains(k)) {
            return Err(malformed(format!("unknown key `{}`; known are {}", shown(key), KEYS.join(", "))));
        }
        let find = |key: &str| values.iter().find(|(k, _)| *k == key).map(|(_, v)| *v);
        let need = |key: &str| find(key).ok_or_else(|| malformed(format!("`{key}` is missing")));
        let eccentricity = in_range("eccentricity e", "0..=20", need("e")?, 0.0, 20.0, "")?;
        let (perihelion_au, perihelion_jd) = match (find("q"), find("a")) {
            (Some(q), _) => (q, need("tp")?),
            (None, Some(a)) if eccentricity < 1.0 => {
                let motion_rad_d = (SUN_GM_AU3_D2 / a.abs().powi(3)).sqrt();
                let anomaly = need("m")?.rem_euclid(360.0);
                let anomaly = if anomaly > 180.0 { anomaly - 360.0 } else { anomaly };
                (a * (1.0 - eccentricity), need("epoch")? - anomaly.to_radians() / motion_rad_d)
            }
            _ => return Err(malformed("`q` and `tp` are missing (or `a`, `m`, `epoch` of an ellipse)".into())),
        };
        let brightness = match (find("h"), find("m1")) {
            (Some(h), _) => Some(SmallBodyBrightness::Asteroid { h, g: find("g").unwrap_or(0.15) }),
            (None, Some(m1)) => Some(SmallBodyBrightness::Comet { m1, k1: find("k1").unwrap_or(10.0) }),
            (None, None) => None,
        };
        Ok(Self {
            name: name.join(" "),
            perihelion_au: in_range("perihelion distance q", "0.001..=1000 au", perihelion_au, 1e-3, 1e3, "")?,
            eccentricity,
            inclination_rad: in_range("inclination i", "0..=180 degrees", need("i")?, 0.0, 180.0, "")?.to_radians(),
            node_rad: in_range("node", "-360..=360 degrees", need("node")?, -360.0, 360.0, "")?.to_radians(),
            argument_of_perihelion_rad: in_range("peri", "-360..=360 degrees", need("peri")?, -360.0, 360.0, "")?
                .to_radians(),
            perihelion_time: JulianDateTdb::new(perihelion_jd)?,
            brightness,
        })
    }

    /// From the Sun, along GCRS axes, by universal variables   [danby1988].
    ///
    /// √μ Δt = q χ + e χ³ S(αχ²),  α = (1 − e)/q,  r = q + e χ² C(αχ²);  in the orbit's plane x = q − χ² C, y = √(q(1 + e)) χ (1 − αχ² S)
    ///
    /// The planets' pull is left out: within weeks of the elements' epoch a few seconds of arc, within years minutes.
    /// Laws tested: energy and angular momentum stay; half a period after perihelion an ellipse is at aphelion.
    pub fn heliocentric(&self, tdb: JulianDateTdb) -> Result<State> {
        let (q, e) = (self.perihelion_au, self.eccentricity);
        let alpha = (1.0 - e) / q;
        let mut days = tdb.jd() - self.perihelion_time.jd();
        if alpha > 1e-6 {
            let period = std::f64::consts::TAU / (SUN_GM_AU3_D2 * alpha.powi(3)).sqrt();
            days -= (days / period).round() * period;
        }
        let target = SUN_GM_AU3_D2.sqrt() * days;
        let time = |x: f64| {
            let (c, s) = stumpff(alpha * x * x);
            (q * x + e * x.powi(3) * s, q + e * x * x * c)
        };
        // Kepler's equation rises steadily: bracket its root, then Newton's step where it stays inside.
        let sign = if target < 0.0 { -1.0 } else { 1.0 };
        let (mut low, mut high) = (0.0, 0.01);
        for _ in 0..200 {
            if time(high).0 >= target.abs() {
                break;
            }
            (low, high) = (high, high * 1.5);
        }
        let mut x = 0.5 * (low + high);
        for _ in 0..200 {
            let (t, r) = time(x);
            if t > target.abs() {
                high = x;
            } else {
                low = x;
            }
            let newton = x - (t - target.abs()) / r;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let settled = (next - x).abs() <= 1e-15 * (1.0 + x.abs());
            x = next;
            if settled {
                break;
            }
        }
        let chi = x * sign;
        let z = alpha * chi * chi;
        let (c, s) = stumpff(z);
        let r = q + e * chi * chi * c;
        if !(r.is_finite() && r > 0.0) {
            return Err(AstroError::NoSolution {
                what: "the orbit",
                reason: format!("no place at Julian date {}; are the elements right?", tdb.jd()),
            });
        }
        let p_root = (q * (1.0 + e)).sqrt();
        let place = DVec3::new(q - chi * chi * c, p_root * chi * (1.0 - z * s), 0.0);
        let rate = SUN_GM_AU3_D2.sqrt() / r;
        let velocity = DVec3::new(-chi * (1.0 - z * s), p_root * (1.0 - z * c), 0.0) * rate;
        let turn = ecliptic_j2000_from_gcrs().transpose()
            * glam::DMat3::from_rotation_z(self.node_rad)
            * glam::DMat3::from_rotation_x(self.inclination_rad)
            * glam::DMat3::from_rotation_z(self.argument_of_perihelion_rad);
        Ok(State { position_m: turn * place * AU_M, velocity_m_s: turn * velocity * (AU_M / SECONDS_PER_DAY) })
    }

    /// Visual magnitude at distances in au and a phase angle, where the brightness is known.
    pub fn magnitude(&self, sun_distance_au: f64, distance_au: f64, phase_angle_rad: f64) -> Option<f64> {
        self.brightness.map(|b| match b {
            SmallBodyBrightness::Comet { m1, k1 } => m1 + 5.0 * distance_au.log10() + k1 * sun_distance_au.log10(),
            SmallBodyBrightness::Asteroid { h, g } => {
                let tan_half = (phase_angle_rad / 2.0).tan();
                let phi1 = (-3.33 * tan_half.powf(0.63)).exp();
                let phi2 = (-1.87 * tan_half.powf(1.22)).exp();
                h + 5.0 * (sun_distance_au * distance_au).log10()
                    - 2.5 * ((1.0 - g) * phi1 + g * phi2).max(1e-30).log10()
            }
        })
    }
}

/// C(z) = (1 − cos √z)/z and S(z) = (√z − sin √z)/√z³, through zero to negative z.
fn stumpff(z: f64) -> (f64, f64) {
    if z.abs() < 1e-2 {
        let c = 0.5 - z / 24.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0 * (1.0 - z / 90.0)));
        let s = 1.0 / 6.0 - z / 120.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0)));
        (c, s)
    } else if z > 0.0 {
        let r = z.sqrt();
        ((1.0 - r.cos()) / z, (r - r.sin()) / (z * r))
    } else {
        let r = (-z).sqrt();
        ((1.0 - r.cosh()) / z, (r.sinh() - r) / (-z * r))
    }
}

impl Observer<'_> {
    /// Where a comet or asteroid is seen, and its magnitude where known.
    pub fn apparent_orbit(&self, elements: &OrbitalElements) -> Result<(Apparent, Option<f64>)> {
        let tdb = self.instant.tdb();
        let mut vector = DVec3::ZERO;
        let mut heliocentric = DVec3::ZERO;
        let mut tau_s = 0.0;
        for _ in 0..3 {
            let then = JulianDateTdb::new(tdb.jd() - tau_s / SECONDS_PER_DAY)?;
            heliocentric = elements.heliocentric(then)?.position_m;
            vector = self.sun.position_m + heliocentric - self.state.position_m;
            tau_s = vector.length() / LIGHT_SPEED_M_S;
        }
        let distance_m = vector.length().max(1.0);
        let mut seen = self.seen(self.aberrated(self.deflected(vector / distance_m, Some(vector))));
        seen.distance_m = distance_m;
        seen.vector_m = vector;
        let phase = angle_between(heliocentric, vector);
        let magnitude = elements.magnitude(heliocentric.length() / AU_M, distance_m / AU_M, phase);
        Ok((seen, magnitude))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [meeus1998, example 33.a]: comet Encke, perihelion 1990-10-28.54502 TD; on 1990-10-06.0 x = +0.250 8066, y = +0.484 9175, z = +0.357 3373
    /// (equator and equinox 2000; i, ω, Ω for 2000).
    #[test]
    fn encke_of_meeus() {
        let e = OrbitalElements::parse(
            "2P/Encke a=2.2091404 e=0.8502196 i=11.94524 node=334.75006 peri=186.23352 m=0 epoch=2448193.04502",
        )
        .unwrap();
        let p = e.heliocentric(JulianDateTdb::new(2_448_170.5).unwrap()).unwrap().position_m / AU_M;
        let expected = DVec3::new(0.250_806_6, 0.484_917_5, 0.357_337_3);
        assert!((p - expected).length() < 3e-6, "{p}");
        assert_eq!(e.name, "2P/Encke");
    }

    #[test]
    fn energy_and_momentum_stay_for_every_kind_of_orbit() {
        for e in [0.0, 0.3, 0.97, 0.999_999, 1.0, 1.000_001, 1.5, 3.3] {
            let orbit = OrbitalElements::parse(&format!("x q=0.7 e={e} i=40 node=10 peri=20 tp=2451545")).unwrap();
            for day in [-4000.0, -300.0, -1.0, 0.0, 0.5, 50.0, 9000.0] {
                let s = orbit.heliocentric(JulianDateTdb::new(2_451_545.0 + day).unwrap()).unwrap();
                let (r, v) = (s.position_m / AU_M, s.velocity_m_s * SECONDS_PER_DAY / AU_M);
                let energy = 0.5 * v.length_squared() - SUN_GM_AU3_D2 / r.length();
                let expected = -SUN_GM_AU3_D2 * (1.0 - e) / (2.0 * 0.7);
                assert!((energy - expected).abs() < 1e-12, "e {e} day {day}: {energy} {expected}");
                let momentum = r.cross(v).length();
                assert!((momentum / (SUN_GM_AU3_D2 * 0.7 * (1.0 + e)).sqrt() - 1.0).abs() < 1e-8, "e {e} day {day}");
            }
        }
    }

    #[test]
    fn bad_elements_are_refused_with_a_reason() {
        for (text, word) in [
            ("", "missing"),
            ("x q=1 e=0.5", "missing"),
            ("x q=1 e=nan i=1 node=1 peri=1 tp=2451545", "number"),
            ("x q=-1 e=0.5 i=1 node=1 peri=1 tp=2451545", "perihelion distance"),
            ("x a=1 e=1.5 i=1 node=1 peri=1 m=0 epoch=2451545", "ellipse"),
            ("x q=1 e=0.5 i=1 node=1 peri=1 tp=1e300", "13,000 BC"),
            ("x q=1 e=0.5 i=1 nod=1 peri=1 tp=2451545", "unknown key"),
        ] {
            let e = OrbitalElements::parse(text).unwrap_err().to_string();
            assert!(e.contains(word), "{text}: {e}");
        }
    }
}
