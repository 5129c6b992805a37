use super::{Nutation, NutationModel, PrecessionAngles, axes_turned_x, axes_turned_y, axes_turned_z};
use crate::constants::{ARCSECOND_RAD, J2000_JD};
use crate::time::{Instant, JulianDateUt1, PolarMotion};
use glam::DMat3;
use std::f64::consts::TAU;

/// Everything about the Earth's stand that all bodies of one instant share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarthOrientation {
    /// True equator and equinox of date from GCRS axes (bias, precession, nutation).
    pub true_from_gcrs: DMat3,
    /// Earth-fixed axes from GCRS axes.
    pub ecef_from_gcrs: DMat3,
    /// Greenwich apparent sidereal time.
    pub apparent_sidereal_time_rad: f64,
    /// Greenwich mean sidereal time.
    pub mean_sidereal_time_rad: f64,
    /// Mean obliquity of date.
    pub mean_obliquity_rad: f64,
    /// Nutation of date.
    pub nutation: Nutation,
}

/// Earth rotation angle, 0..2π   [capitaine2000; iers2010, eq. 5.15].
///
/// θ = 2π (0.7790572732640 + 1.00273781191135448 d),  d: UT1 days since J2000.0
pub fn earth_rotation_angle_rad(ut1: JulianDateUt1) -> f64 {
    let d = ut1.jd() - J2000_JD;
    // Whole days turn the Earth whole times: keep them out of the product for its last digits.
    TAU * (ut1.jd().fract() + 0.779_057_273_264_0 + 0.002_737_811_911_354_48 * d).rem_euclid(1.0)
}

/// Greenwich mean sidereal time, IAU 2006, 0..2π   [capitaine2005].
pub fn mean_sidereal_time_rad(instant: &Instant) -> f64 {
    let t = instant.tt().centuries_since_j2000();
    let accumulated_precession = [0.014_506, 4_612.156_534, 1.391_581_7, -4.4e-7, -2.995_6e-5, -3.68e-8]
        .iter()
        .rev()
        .fold(0.0, |sum, c| sum * t + c);
    (earth_rotation_angle_rad(instant.ut1()) + accumulated_precession * ARCSECOND_RAD).rem_euclid(TAU)
}

impl EarthOrientation {
    /// IAU 2006 precession, IAU 2000B nutation, no polar motion.
    pub fn at(instant: &Instant) -> Self {
        Self::with(instant, NutationModel::default(), PolarMotion::default())
    }

    /// With a chosen nutation and polar motion ([`crate::time::polar_motion`]).
    pub fn with(instant: &Instant, model: NutationModel, pole: PolarMotion) -> Self {
        let angles = PrecessionAngles::at(instant.tt());
        let nutation = Nutation::at(instant.tt(), model);
        let true_from_gcrs = axes_turned_x(-(angles.obliquity_rad + nutation.obliquity_rad))
            * axes_turned_z(-(angles.psi_bar_rad + nutation.longitude_rad))
            * axes_turned_x(angles.phi_bar_rad)
            * axes_turned_z(angles.gamma_bar_rad);
        let mean_sidereal_time_rad = mean_sidereal_time_rad(instant);
        let apparent_sidereal_time_rad = (mean_sidereal_time_rad
            + nutation.longitude_rad * angles.obliquity_rad.cos()
            + complementary_terms_rad(instant))
        .rem_euclid(TAU);
        let wobble = axes_turned_x(-pole.y_rad) * axes_turned_y(-pole.x_rad);
        let ecef_from_gcrs = wobble * axes_turned_z(apparent_sidereal_time_rad) * true_from_gcrs;
        Self {
            true_from_gcrs,
            ecef_from_gcrs,
            apparent_sidereal_time_rad,
            mean_sidereal_time_rad,
            mean_obliquity_rad: angles.obliquity_rad,
            nutation,
        }
    }

    /// True obliquity of date.
    pub fn true_obliquity_rad(&self) -> f64 {
        self.mean_obliquity_rad + self.nutation.obliquity_rad
    }

    /// True ecliptic and equinox of date from GCRS axes.
    pub fn ecliptic_of_date_from_gcrs(&self) -> DMat3 {
        axes_turned_x(self.true_obliquity_rad()) * self.true_from_gcrs
    }
}

/// The largest complementary terms of the equation of the equinoxes; those left out sum to less than 0.03 mas
/// [iers2010, table 5.2e].
fn complementary_terms_rad(instant: &Instant) -> f64 {
    let t = instant.tt().centuries_since_j2000();
    let turns = |a: f64, b: f64| ((a + b * t) % 1_296_000.0) * ARCSECOND_RAD;
    let node = turns(450_160.398_036, -6_962_890.543_1);
    let f = turns(335_779.526_232, 1_739_527_262.847_8);
    let d = turns(1_072_260.703_69, 1_602_961_601.209_0);
    let mas = 2.640_96 * node.sin()
        + 0.063_52 * (2.0 * node).sin()
        + 0.011_75 * (2.0 * f - 2.0 * d + 3.0 * node).sin()
        + 0.011_21 * (2.0 * f - 2.0 * d + node).sin()
        - 0.004_55 * (2.0 * f - 2.0 * d + 2.0 * node).sin()
        + 0.002_02 * (2.0 * f + 3.0 * node).sin()
        + 0.001_98 * (2.0 * f + node).sin();
    mas * 1e-3 * ARCSECOND_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::JulianDateTt;

    fn instants() -> impl Iterator<Item = Instant> {
        (0..200).map(|i| {
            let jd = 2_415_020.5 + f64::from(i) * 275.377_77;
            let tt = JulianDateTt::new(jd).unwrap();
            let ut1 = JulianDateUt1::new(jd - f64::from(i) / 86_400.0).unwrap();
            Instant::from_tt_ut1(tt, ut1).unwrap()
        })
    }

    /// Oracle: sofars, a translation of the IAU's SOFA. Tolerance: 2 mas, the stated error of 2000B; 0.05 mas for 2000A.
    #[test]
    fn agrees_with_sofa() {
        for instant in instants() {
            let (tt, ut1) = (instant.tt().jd(), instant.ut1().jd());
            let oracle = sofars::pnp::pnm06a(tt, 0.0);
            let oracle_gast = sofars::erst::gst06a(ut1, 0.0, tt, 0.0);
            for (model, tolerance_mas) in [(NutationModel::Iau2000B, 2.0), (NutationModel::Iau2000A, 0.05)] {
                let ours = EarthOrientation::with(&instant, model, PolarMotion::default());
                for (r, oracle_row) in oracle.iter().enumerate() {
                    for (c, o) in oracle_row.iter().enumerate() {
                        let mas = (ours.true_from_gcrs.col(c)[r] - o).abs() / ARCSECOND_RAD * 1e3;
                        assert!(mas < tolerance_mas, "{model:?} at {tt}: {mas} mas");
                    }
                }
                let gast = (ours.apparent_sidereal_time_rad - oracle_gast).abs() / ARCSECOND_RAD * 1e3;
                assert!(gast < tolerance_mas + 1.0, "{model:?} at {tt}: sidereal time {gast} mas");
            }
        }
    }

    /// Oracle: SOFA's whole way to the Earth-fixed frame with a pole 0.3″ off. Tolerance 3 mas: 2000B, its s′ (0.05 mas) left out.
    #[test]
    fn polar_motion_agrees_with_sofa() {
        let pole = PolarMotion { x_rad: 0.2 * ARCSECOND_RAD, y_rad: 0.35 * ARCSECOND_RAD };
        for instant in instants() {
            let ours = EarthOrientation::with(&instant, NutationModel::Iau2000A, pole).ecef_from_gcrs;
            let oracle = sofars::pnp::c2t06a(instant.tt().jd(), 0.0, instant.ut1().jd(), 0.0, pole.x_rad, pole.y_rad);
            for (r, row) in oracle.iter().enumerate() {
                for (c, o) in row.iter().enumerate() {
                    assert!((ours.col(c)[r] - o).abs() / ARCSECOND_RAD < 3e-3, "{}", instant.tt().jd());
                }
            }
        }
    }

    #[test]
    fn rotations_stay_rotations() {
        for instant in instants() {
            let o = EarthOrientation::at(&instant);
            for m in [o.true_from_gcrs, o.ecef_from_gcrs, o.ecliptic_of_date_from_gcrs()] {
                assert!((m * m.transpose() - DMat3::IDENTITY).to_cols_array().iter().all(|e| e.abs() < 1e-14));
                assert!((m.determinant() - 1.0).abs() < 1e-14);
            }
        }
    }
}
