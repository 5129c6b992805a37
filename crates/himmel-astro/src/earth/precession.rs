use super::axes_turned_x;
use crate::constants::ARCSECOND_RAD;
use crate::time::JulianDateTt;
use glam::DMat3;

/// The Fukushima–Williams angles of IAU 2006 precession with the frame bias in them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrecessionAngles {
    /// γ̄
    pub gamma_bar_rad: f64,
    /// φ̄
    pub phi_bar_rad: f64,
    /// ψ̄
    pub psi_bar_rad: f64,
    /// Mean obliquity of date ε_A.
    pub obliquity_rad: f64,
}

fn polynomial_arcseconds(t: f64, c: [f64; 6]) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * t + c) * ARCSECOND_RAD
}

/// Mean obliquity of the ecliptic, IAU 2006   [hilton2006]; `t`: Julian centuries TT since J2000.0.
fn obliquity_rad(t: f64) -> f64 {
    polynomial_arcseconds(t, [84_381.406, -46.836_769, -0.000_183_1, 0.002_003_40, -5.76e-7, -4.34e-8])
}

/// Mean obliquity of the ecliptic of date, IAU 2006.
pub fn mean_obliquity_rad(tt: JulianDateTt) -> f64 {
    obliquity_rad(tt.centuries_since_j2000())
}

impl PrecessionAngles {
    /// The angles at a date   [hilton2006; wallace2006].
    pub fn at(tt: JulianDateTt) -> Self {
        let t = tt.centuries_since_j2000();
        Self {
            gamma_bar_rad: polynomial_arcseconds(
                t,
                [-0.052_928, 10.556_378, 0.493_204_4, -0.000_312_38, -2.788e-6, 2.60e-8],
            ),
            phi_bar_rad: polynomial_arcseconds(
                t,
                [84_381.412_819, -46.811_016, 0.051_126_8, 0.000_532_89, -4.40e-7, -1.76e-8],
            ),
            psi_bar_rad: polynomial_arcseconds(
                t,
                [-0.041_775, 5_038.481_484, 1.558_417_5, -0.000_185_22, -2.645_2e-5, -1.48e-8],
            ),
            obliquity_rad: obliquity_rad(t),
        }
    }
}

/// The ecliptic and equinox of J2000.0 from GCRS axes (obliquity 84,381.406″, bias of 0.02″ left out).
pub fn ecliptic_j2000_from_gcrs() -> DMat3 {
    axes_turned_x(obliquity_rad(0.0))
}
