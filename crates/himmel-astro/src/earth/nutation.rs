use crate::time::JulianDateTt;

/// Which theory of nutation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NutationModel {
    /// IAU 2000B, 77 terms, within 1 mas of 2000A between 1995 and 2050 (within 2 mas over 1900–2100).
    #[default]
    Iau2000B,
    /// IAU 2000A, 1365 terms, for reference: about thirty times slower.
    Iau2000A,
}

/// Nutation in longitude and obliquity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nutation {
    /// Δψ
    pub longitude_rad: f64,
    /// Δε
    pub obliquity_rad: f64,
}

impl Nutation {
    /// Nutation at a date with the small corrections that fit IAU 2006 precession   [wallace2006, eq. 5].
    pub fn at(tt: JulianDateTt, model: NutationModel) -> Self {
        let (dpsi, deps) = match model {
            NutationModel::Iau2000B => sofars::pnp::nut00b(tt.jd(), 0.0),
            NutationModel::Iau2000A => sofars::pnp::nut00a(tt.jd(), 0.0),
        };
        // The Earth's dynamical flattening changes with time.
        let flattening = -2.7774e-6 * tt.centuries_since_j2000();
        Self { longitude_rad: dpsi + dpsi * (0.4697e-6 + flattening), obliquity_rad: deps + deps * flattening }
    }
}
