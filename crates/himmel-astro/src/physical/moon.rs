use super::appearance::position_angle_rad;
use super::libration_table;
use crate::apparent::{Apparent, Observer};
use crate::constants::J2000_JD;
use crate::earth::{axes_turned_x, axes_turned_y, axes_turned_z};
use crate::time::JulianDateTdb;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How the Moon's globe is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoonOrientation {
    /// The Moon's mean-Earth, polar-axis frame from ICRS axes: x to the mean sub-Earth point, z to the north pole.
    pub body_from_icrs: DMat3,
}

impl MoonOrientation {
    /// By the series of the IAU's working group   [archinal2018, table 2], which leaves 0.0018° rms and 0.0046° largest of JPL's
    /// mean-Earth frame, and 42 waves fitted to what it leaves over 1900–2050 (`xtask/astro/make_libration.py`), with which the rest is
    /// 0.0002° rms and 0.0009° largest. Outside those years the waves go on; they never sum to more than 0.01°.
    ///
    /// Optical and physical libration are both in it: it says where the globe's own axes point.
    pub fn at(tdb: JulianDateTdb) -> Self {
        let d = tdb.jd() - J2000_JD;
        let t = tdb.centuries_since_j2000();
        let e = |constant: f64, rate: f64| ((constant + rate * d) % 360.0).to_radians().sin_cos();
        let (s1, c1) = e(125.045, -0.052_992_1);
        let (s2, c2) = e(250.089, -0.105_984_2);
        let (s3, c3) = e(260.008, 13.012_000_9);
        let (s4, c4) = e(176.625, 13.340_715_4);
        let (s5, _) = e(357.529, 0.985_600_3);
        let (s6, c6) = e(311.589, 26.405_708_4);
        let (s7, c7) = e(134.963, 13.064_993_0);
        let (s8, _) = e(276.617, 0.328_714_6);
        let (s9, _) = e(34.226, 1.748_487_7);
        let (s10, c10) = e(15.134, -0.158_976_3);
        let (s11, _) = e(119.743, 0.003_609_6);
        let (s12, _) = e(239.961, 0.164_357_3);
        let (s13, c13) = e(25.053, 12.959_008_8);
        let pole_ra = 269.9949 + 0.0031 * t - 3.8787 * s1 - 0.1204 * s2 + 0.0700 * s3 - 0.0172 * s4 + 0.0072 * s6
            - 0.0052 * s10
            + 0.0043 * s13;
        let pole_dec = 66.5392 + 0.0130 * t + 1.5419 * c1 + 0.0239 * c2 - 0.0278 * c3 + 0.0068 * c4 - 0.0029 * c6
            + 0.0009 * c7
            + 0.0008 * c10
            - 0.0009 * c13;
        let meridian = 38.3213 + 13.176_358_15 * d - 1.4e-12 * d * d + 3.5610 * s1 + 0.1208 * s2 - 0.0642 * s3
            + 0.0158 * s4
            + 0.0252 * s5
            - 0.0066 * s6
            - 0.0047 * s7
            - 0.0046 * s8
            + 0.0028 * s9
            + 0.0052 * s10
            + 0.0040 * s11
            + 0.0019 * s12
            - 0.0044 * s13;
        let body_from_icrs = axes_turned_z((meridian % 360.0).to_radians())
            * axes_turned_x(FRAC_PI_2 - pole_dec.to_radians())
            * axes_turned_z(FRAC_PI_2 + pole_ra.to_radians());
        Self { body_from_icrs: correction(t) * body_from_icrs }
    }

    /// Selenographic longitude (east, −π..=π) and latitude of a direction from the Moon's centre along ICRS axes.
    pub fn longitude_latitude_rad(&self, direction_icrs: DVec3) -> (f64, f64) {
        let v = self.body_from_icrs * direction_icrs;
        (v.y.atan2(v.x), v.z.atan2(v.x.hypot(v.y)))
    }

    /// The north pole along ICRS axes.
    pub fn north_pole_icrs(&self) -> DVec3 {
        self.body_from_icrs.row(2)
    }
}

/// The small turn that the 13-term series lacks; `t`: centuries TDB since J2000.0.
fn correction(t: f64) -> DMat3 {
    let angle = |axis: usize| {
        let waves = libration_table::WAVES[axis].iter().map(|[cos_deg, sin_deg, rate]| {
            let (sin, cos) = (rate * t).sin_cos();
            cos_deg * cos + sin_deg * sin
        });
        (libration_table::CONSTANT_DEG[axis] + waves.sum::<f64>()).to_radians()
    };
    axes_turned_x(angle(0)) * axes_turned_y(angle(1)) * axes_turned_z(angle(2))
}

/// The Moon's face as it is turned to the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Libration {
    /// Selenographic longitude of the point that is nearest the observer, east positive.
    pub longitude_rad: f64,
    /// Its latitude.
    pub latitude_rad: f64,
    /// Position angle of the north pole, from celestial north through east, −π..=π.
    pub axis_position_angle_rad: f64,
    /// Selenographic longitude of the point under the Sun; the colongitude is 90° minus this.
    pub sun_longitude_rad: f64,
    /// Its latitude.
    pub sun_latitude_rad: f64,
}

impl Observer<'_> {
    /// The Moon's libration (optical and physical, topocentric) and axis; `seen` is the Moon's place.
    ///
    /// The point is the foot of the line from observer to Moon at the same instant: both share the Earth's motion, so light time
    /// and aberration cancel to 0.7″.
    pub fn libration(&self, seen: &Apparent) -> Libration {
        let orientation = MoonOrientation::at(self.instant.tdb());
        let moon = (self.earth + self.moon_from_earth).position_m;
        let (longitude_rad, latitude_rad) = orientation.longitude_latitude_rad(self.state.position_m - moon);
        let (sun_longitude_rad, sun_latitude_rad) = orientation.longitude_latitude_rad(self.sun.position_m - moon);
        let turn = self.orientation.true_from_gcrs;
        let angle = position_angle_rad(turn * seen.direction_gcrs, turn * orientation.north_pole_icrs());
        let axis_position_angle_rad = (angle + PI).rem_euclid(TAU) - PI;
        Libration { longitude_rad, latitude_rad, axis_position_angle_rad, sun_longitude_rad, sun_latitude_rad }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Instant, Place, Precise};

    /// [meeus1998, example 53.a]: 1992-04-12 0h TD, geocentric: l = −1.23°, b = +4.20°, P = 15.08°. Meeus' own series is off by
    /// 0.02°; the place lies under the Moon, where the topocentric libration is the geocentric one: 0.1° together.
    #[test]
    fn libration_of_meeus() {
        let tt = crate::time::JulianDateTt::new(2_448_724.5).unwrap();
        let instant = Instant::from_tt(tt, crate::time::DeltaTModel::Standard);
        let precise = Precise::embedded().unwrap();
        let mut longitude_deg = 0.0;
        for _ in 0..8 {
            let place = Place::from_degrees(13.85, longitude_deg, 0.0).unwrap();
            let observer = Observer::new(&precise, &instant, &place).unwrap();
            let moon = observer.apparent(Body::Moon).unwrap();
            let hour_angle_deg = observer.hour_angle_rad(&moon).to_degrees();
            if hour_angle_deg.abs() < 0.1 {
                let l = observer.libration(&moon);
                assert!((l.longitude_rad.to_degrees() + 1.23).abs() < 0.1, "{}", l.longitude_rad.to_degrees());
                assert!((l.latitude_rad.to_degrees() - 4.20).abs() < 0.1, "{}", l.latitude_rad.to_degrees());
                assert!((l.axis_position_angle_rad.to_degrees() - 15.08).abs() < 0.1);
                return;
            }
            longitude_deg -= hour_angle_deg;
        }
        panic!("the Moon was not brought to the meridian");
    }
}
