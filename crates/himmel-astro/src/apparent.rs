//! From where a body is to where it is seen: light time, deflection, aberration, the turning Earth.

use crate::body::Body;
use crate::constants::{LIGHT_SPEED_M_S, SUN_SCHWARZSCHILD_RADIUS_M};
use crate::earth::EarthOrientation;
use crate::ephemeris::{Ephemeris, State};
use crate::error::{AstroError, Result};
use crate::place::Place;
use crate::refraction::AirAtObserver;
use crate::time::Instant;
use glam::DVec3;
use std::f64::consts::TAU;

/// Where and how large a body is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apparent {
    /// From north through east, 0..2π.
    pub azimuth_rad: f64,
    /// Above the geometric horizon, without air.
    pub altitude_rad: f64,
    /// Unit vector to the body along local east, north, up, without air.
    pub direction_enu: DVec3,
    /// Apparent right ascension, true equator and equinox of date, as seen from the place, 0..2π.
    pub right_ascension_rad: f64,
    /// Apparent declination, likewise.
    pub declination_rad: f64,
    /// Unit vector to the body along GCRS axes, aberration included.
    pub direction_gcrs: DVec3,
    /// From the observer. For the Moon at the same instant; for others along the light's way.
    pub distance_m: f64,
    /// Of the equatorial diameter; 0 for stars.
    pub angular_diameter_rad: f64,
    /// From the observer to where the light left, along GCRS axes: geometry for phases. Zero for stars.
    pub vector_m: DVec3,
}

impl Apparent {
    /// The altitude at which the air shows it.
    pub fn refracted_altitude_rad(&self, air: &AirAtObserver) -> f64 {
        air.refracted_altitude_rad(self.altitude_rad)
    }

    /// Half the angular diameter.
    pub fn semidiameter_rad(&self) -> f64 {
        self.angular_diameter_rad / 2.0
    }
}

/// Everything that the bodies of one instant and place share, computed once.
pub struct Observer<'a> {
    ephemeris: &'a dyn Ephemeris,
    /// The instant.
    pub instant: Instant,
    /// The place.
    pub place: Place,
    /// How the Earth stands.
    pub orientation: EarthOrientation,
    /// The Earth's centre from the ephemeris' origin.
    pub earth: State,
    /// The Moon from the Earth's centre.
    pub moon_from_earth: State,
    /// The Sun from the ephemeris' origin.
    pub sun: State,
    /// The observer from the ephemeris' origin.
    pub state: State,
}

impl<'a> Observer<'a> {
    /// With IAU 2006/2000B and no polar motion.
    pub fn new(ephemeris: &'a dyn Ephemeris, instant: &Instant, place: &Place) -> Result<Self> {
        Self::with_orientation(ephemeris, instant, place, EarthOrientation::at(instant))
    }

    /// At the Earth's centre, where almanacs stand: right ascension, declination and distances are geocentric, azimuth and
    /// altitude mean nothing.
    pub fn geocentric(ephemeris: &'a dyn Ephemeris, instant: &Instant) -> Result<Self> {
        let mut observer = Self::new(ephemeris, instant, &Place::GREENWICH_EQUATOR)?;
        observer.state = observer.earth;
        Ok(observer)
    }

    /// With an orientation of the caller's choice (polar motion, IAU 2000A, or shared by several places).
    pub fn with_orientation(
        ephemeris: &'a dyn Ephemeris,
        instant: &Instant,
        place: &Place,
        orientation: EarthOrientation,
    ) -> Result<Self> {
        let tdb = instant.tdb();
        let (earth, moon_from_earth) = ephemeris.earth_and_moon(tdb)?;
        let sun = ephemeris.state(Body::Sun, tdb)?;
        let gcrs_from_ecef = orientation.ecef_from_gcrs.transpose();
        let site = State {
            position_m: gcrs_from_ecef * place.ecef_m(),
            velocity_m_s: gcrs_from_ecef * place.ecef_velocity_m_s(),
        };
        Ok(Self {
            ephemeris,
            instant: *instant,
            place: *place,
            orientation,
            earth,
            moon_from_earth,
            sun,
            state: earth + site,
        })
    }

    /// The body from the observer as its light now arriving left it, and the distance of the light's way (m).
    ///
    /// Position at t − τ by the state at t: p − v τ + ½ a τ², a the Sun's pull. What is left out is below 0.001″.
    pub fn light_time_vector(&self, body: Body) -> Result<(DVec3, f64)> {
        let (target, pull) = match body {
            Body::Earth => {
                return Err(AstroError::Unsupported {
                    ephemeris: self.ephemeris.name(),
                    body: "earth as seen from the Earth".into(),
                    hint: "ask for another body",
                });
            }
            Body::Sun => (self.sun, DVec3::ZERO),
            Body::Moon => {
                let r = self.moon_from_earth.position_m;
                (self.earth + self.moon_from_earth, self.sun_pull(self.earth) - r * (EARTH_GM / r.length().powi(3)))
            }
            _ => {
                let state = self.ephemeris.state(body, self.instant.tdb())?;
                (state, self.sun_pull(state))
            }
        };
        let now = target.position_m - self.state.position_m;
        let mut tau = now.length() / LIGHT_SPEED_M_S;
        let mut vector = now;
        for _ in 0..3 {
            vector = now - target.velocity_m_s * tau + pull * (0.5 * tau * tau);
            tau = vector.length() / LIGHT_SPEED_M_S;
        }
        Ok((vector, tau * LIGHT_SPEED_M_S))
    }

    pub(crate) fn fixed_phase_angle_rad(&self, body: Body) -> Option<f64> {
        self.ephemeris.fixed_phase_angle_rad(body)
    }

    fn sun_pull(&self, state: State) -> DVec3 {
        let r = state.position_m - self.sun.position_m;
        r * (-SUN_GM / r.length().powi(3).max(1.0))
    }

    /// Where a body is seen.
    pub fn apparent(&self, body: Body) -> Result<Apparent> {
        let (vector, distance_m) = self.light_time_vector(body)?;
        let mut direction = vector / distance_m;
        // The Moon is nearer than anything the Sun could bend noticeably; the Sun does not bend its own light.
        if !matches!(body, Body::Sun | Body::Moon) {
            direction = self.deflected(direction, Some(vector));
        }
        let mut seen = self.seen(self.aberrated(direction));
        seen.vector_m = vector;
        seen.distance_m = match body {
            Body::Moon => (self.earth + self.moon_from_earth - self.state).position_m.length(),
            _ => distance_m,
        };
        seen.angular_diameter_rad = 2.0 * (body.radius_m() / seen.distance_m).min(1.0).asin();
        Ok(seen)
    }

    /// Bends a direction round the Sun   [sofa2021, `iauLd`].
    ///
    /// p′ = p + (r_s / d) · p × (e × q) / max(1 + q·e, 1e-9),  e: Sun → observer, q: Sun → source, d: Sun's distance, r_s = 2GM/c².
    ///
    /// `vector_m`: observer → source; `None` for stars, which are infinitely far. The floor on 1 + q·e stands for sources behind the disc.
    pub fn deflected(&self, direction: DVec3, vector_m: Option<DVec3>) -> DVec3 {
        let from_sun = self.state.position_m - self.sun.position_m;
        let distance_m = from_sun.length();
        let e = from_sun / distance_m;
        let q = vector_m.map_or(direction, |v| (from_sun + v).normalize());
        let bend = SUN_SCHWARZSCHILD_RADIUS_M / distance_m / (1.0 + q.dot(e)).max(DEFLECTION_FLOOR);
        (direction + direction.cross(e.cross(q)) * bend).normalize()
    }

    /// Aberration by the observer's whole velocity   [sofa2021, `iauAb`, without the potential's 0.4 µas].
    ///
    /// p′ ∝ p/γ + (1 + p·β/(1 + 1/γ)) β
    pub fn aberrated(&self, direction: DVec3) -> DVec3 {
        let beta = self.state.velocity_m_s / LIGHT_SPEED_M_S;
        let inverse_gamma = (1.0 - beta.length_squared()).sqrt();
        let along = direction.dot(beta);
        (direction * inverse_gamma + beta * (1.0 + along / (1.0 + inverse_gamma))).normalize()
    }

    /// The angles of a proper (aberrated) direction; distance and diameter are left for the caller.
    pub fn seen(&self, direction_gcrs: DVec3) -> Apparent {
        let equatorial = self.orientation.true_from_gcrs * direction_gcrs;
        let enu = self.place.enu_from_ecef() * (self.orientation.ecef_from_gcrs * direction_gcrs);
        Apparent {
            azimuth_rad: enu.x.atan2(enu.y).rem_euclid(TAU),
            altitude_rad: enu.z.atan2(enu.x.hypot(enu.y)),
            direction_enu: enu,
            right_ascension_rad: equatorial.y.atan2(equatorial.x).rem_euclid(TAU),
            declination_rad: equatorial.z.atan2(equatorial.x.hypot(equatorial.y)),
            direction_gcrs,
            distance_m: f64::INFINITY,
            angular_diameter_rad: 0.0,
            vector_m: DVec3::ZERO,
        }
    }
}

/// GM of the Sun and the Earth in m³/s²   [park2021].
const SUN_GM: f64 = 1.327_124_400_412_794_2e20;
const EARTH_GM: f64 = 3.986_004_355_070_226e14;
/// SOFA's limit for the Sun: deflection is full down to 9.3′ from its centre.
const DEFLECTION_FLOOR: f64 = 1e-6;

/// Where a body is seen from a place; for several bodies at once make one [`Observer`].
pub fn observe(ephemeris: &dyn Ephemeris, body: Body, instant: &Instant, place: &Place) -> Result<Apparent> {
    Observer::new(ephemeris, instant, place)?.apparent(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::Fast;

    /// [meeus1998, example 25.b]: 1992-10-13 0h TD, apparent α 13h13m30.749s, δ −7°47′01.74″ (geocentric).
    /// Tolerance 0.2″ besides parallax, which a place at the sub-solar longitude keeps out of right ascension.
    #[test]
    fn sun_of_meeus() {
        let tt = crate::time::JulianDateTt::new(2_448_908.5).unwrap();
        let instant = Instant::from_tt(tt, crate::time::DeltaTModel::Standard);
        let place = Place::from_degrees(-7.783_817, -183.18, 0.0).unwrap();
        let sun = observe(&Fast, Body::Sun, &instant, &place).unwrap();
        let ra_deg = (13.0 + 13.0 / 60.0 + 30.749 / 3600.0) * 15.0;
        let dec_deg = -(7.0 + 47.0 / 60.0 + 1.74 / 3600.0);
        assert!(
            (sun.declination_rad.to_degrees() - dec_deg).abs() * 3600.0 < 0.5,
            "{}",
            sun.declination_rad.to_degrees()
        );
        assert!((sun.right_ascension_rad.to_degrees() - ra_deg).abs() * 3600.0 < 0.5);
        assert!((sun.semidiameter_rad().to_degrees() * 60.0 - 16.04).abs() < 0.05);
    }

    #[test]
    fn the_earth_cannot_be_seen_from_itself() {
        let instant = Instant::from_unix_seconds(1e9).unwrap();
        let place = Place::from_degrees(0.0, 0.0, 0.0).unwrap();
        assert!(observe(&Fast, Body::Earth, &instant, &place).is_err());
    }
}
