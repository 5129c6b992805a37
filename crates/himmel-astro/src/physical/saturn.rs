use super::appearance::{angle_between, position_angle_rad};
use crate::apparent::{Apparent, Observer};
use crate::body::Body;
use crate::error::Result;
use crate::time::JulianDateTdb;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Radii of the rings' edges in m, inside out: C inner, B inner, B outer, A inner, A outer   [nssdc2016].
pub const SATURN_RING_EDGES_M: [f64; 5] = [74_658e3, 92_000e3, 117_580e3, 122_170e3, 136_775e3];

/// North pole of Mars, Jupiter, Saturn and Uranus along ICRS axes   [archinal2018, table 1; Mars and Jupiter without their short waves,
/// 0.2°]; `None` for bodies whose pole nothing here needs.
pub fn pole_icrs(body: Body, tdb: JulianDateTdb) -> Option<DVec3> {
    let t = tdb.centuries_since_j2000();
    let (ra_deg, dec_deg) = match body {
        Body::Mars => (317.269 - 0.1093 * t, 54.433 - 0.0588 * t),
        Body::Jupiter => (268.057 - 0.006 * t, 64.497 + 0.002 * t),
        Body::Saturn => (40.589 - 0.036 * t, 83.537 - 0.004 * t),
        Body::Uranus => (257.311, -15.175),
        _ => return None,
    };
    let (sin_ra, cos_ra) = ra_deg.to_radians().sin_cos();
    let (sin_dec, cos_dec) = dec_deg.to_radians().sin_cos();
    Some(DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec))
}

/// How Saturn's rings lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingAspect {
    /// Latitude of the observer above the ring plane, north positive: B of the almanacs.
    pub tilt_rad: f64,
    /// Latitude of the Sun above the ring plane: B′.
    pub sun_tilt_rad: f64,
    /// Position angle of the rings' northern minor axis, from celestial north through east, −π..=π: P.
    pub position_angle_rad: f64,
}

impl Observer<'_> {
    /// Tilt and position angle of Saturn's rings; `seen` is Saturn's place.
    pub fn saturn_rings(&self, seen: &Apparent) -> Result<RingAspect> {
        let vector = seen.vector_m;
        let from_sun = self.state.position_m + vector - self.sun.position_m;
        let pole = pole_icrs(Body::Saturn, self.instant.tdb()).unwrap_or(DVec3::Z);
        let turn = self.orientation.true_from_gcrs;
        let angle = position_angle_rad(turn * seen.direction_gcrs, turn * pole);
        Ok(RingAspect {
            tilt_rad: FRAC_PI_2 - angle_between(pole, -vector),
            sun_tilt_rad: FRAC_PI_2 - angle_between(pole, -from_sun),
            position_angle_rad: (angle + PI).rem_euclid(TAU) - PI,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fast, Instant, Place};

    /// [meeus1998, example 45.a]: 1992-12-16 0h TD: B = 16.442°, B′ = 14.679°, P = 6.741°. Tolerance 0.05°: another pole.
    #[test]
    fn rings_of_meeus() {
        let tt = crate::time::JulianDateTt::new(2_448_972.5).unwrap();
        let instant = Instant::from_tt(tt, crate::time::DeltaTModel::Standard);
        let observer = Observer::new(&Fast, &instant, &Place::from_degrees(0.0, 0.0, 0.0).unwrap()).unwrap();
        let saturn = observer.apparent(Body::Saturn).unwrap();
        let rings = observer.saturn_rings(&saturn).unwrap();
        assert!((rings.tilt_rad.to_degrees() - 16.442).abs() < 0.05, "{}", rings.tilt_rad.to_degrees());
        assert!((rings.sun_tilt_rad.to_degrees() - 14.679).abs() < 0.05);
        assert!((rings.position_angle_rad.to_degrees() - 6.741).abs() < 0.05);
    }
}
