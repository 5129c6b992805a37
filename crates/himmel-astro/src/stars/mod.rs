//! Stars: a catalogue of the naked-eye sky, names, and where a star is seen.

mod catalogue;
pub mod constellations;
mod gpu_frame;
mod user;

pub use catalogue::{Catalogue, StarName};
pub use gpu_frame::{GpuStar, StarFrame};

use crate::apparent::{Apparent, Observer};
use crate::constants::{ARCSECOND_RAD, AU_M, DAYS_PER_YEAR};
use crate::time::JulianDateTdb;
use glam::DVec3;

/// A star as a catalogue has it: ICRS at an epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct Star {
    /// Hipparcos number, 0: none.
    pub hip: u32,
    /// Henry Draper number, 0: none.
    pub hd: u32,
    /// Right ascension at the epoch, ICRS.
    pub right_ascension_rad: f64,
    /// Declination at the epoch, ICRS.
    pub declination_rad: f64,
    /// Proper motion in right ascension times cos δ, rad per Julian year.
    pub motion_ra_rad_per_year: f64,
    /// Proper motion in declination, rad per Julian year.
    pub motion_dec_rad_per_year: f64,
    /// Annual parallax, at least 0.
    pub parallax_rad: f64,
    /// Julian year of the place: 1991.25 for Hipparcos.
    pub epoch_year: f64,
    /// Johnson V.
    pub v_magnitude: f64,
    /// B − V where known.
    pub b_minus_v: Option<f64>,
    /// Spectral type, empty where unknown.
    pub spectral_type: String,
}

impl Star {
    /// Unit vector at the epoch and its change per Julian year, along ICRS axes; the star moves on a straight line.
    pub fn place_and_velocity(&self) -> (DVec3, DVec3) {
        let (sin_ra, cos_ra) = self.right_ascension_rad.sin_cos();
        let (sin_dec, cos_dec) = self.declination_rad.sin_cos();
        let place = DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec);
        let east = DVec3::new(-sin_ra, cos_ra, 0.0);
        let north = DVec3::new(-sin_dec * cos_ra, -sin_dec * sin_ra, cos_dec);
        (place, east * self.motion_ra_rad_per_year + north * self.motion_dec_rad_per_year)
    }

    /// Natural direction from an observer: motion since the epoch and parallax.
    ///
    /// p ∝ p₀ + v Δt − π r/au   [sofa2021, `iauPmpx`, without radial velocity and Rømer's 8 minutes of proper motion]
    pub fn direction(&self, tdb: JulianDateTdb, observer_m: DVec3) -> DVec3 {
        let years = 2000.0 + (tdb.jd() - crate::constants::J2000_JD) / DAYS_PER_YEAR - self.epoch_year;
        let (place, velocity) = self.place_and_velocity();
        (place + velocity * years - observer_m * (self.parallax_rad / AU_M)).normalize()
    }

    /// Temperature of the black body of the same B − V   [ballesteros2012, eq. 14]; `None` without a colour.
    ///
    /// T = 4600 K (1/(0.92 (B−V) + 1.7) + 1/(0.92 (B−V) + 0.62))
    ///
    /// Colours are held within −0.4..=2.5, which the catalogue leaves only for carbon stars.
    pub fn temperature_k(&self) -> Option<f64> {
        self.b_minus_v.map(|bv| {
            let c = 0.92 * bv.clamp(-0.4, 2.5);
            4600.0 * (1.0 / (c + 1.7) + 1.0 / (c + 0.62))
        })
    }

    /// The temperature as the thesis takes it   [mueller2012, eq. 4.26]: T = 7000 K / (B−V + 0.56), held within the same colours.
    pub fn temperature_thesis_k(&self) -> Option<f64> {
        self.b_minus_v.map(|bv| 7000.0 / (bv.clamp(-0.4, 2.5) + 0.56))
    }

    /// Illuminance above the air in lx: 2.54e-6 lx at V = 0   [allen1973].
    pub fn illuminance_lx(&self) -> f64 {
        crate::physical::illuminance_lx(self.v_magnitude)
    }
}

impl Observer<'_> {
    /// Where a star is seen: motion, parallax, deflection by the Sun, aberration, precession, nutation.
    pub fn apparent_star(&self, star: &Star) -> Apparent {
        // The ephemeris' origin stands for the barycentre.
        let direction = star.direction(self.instant.tdb(), self.state.position_m);
        let mut seen = self.seen(self.aberrated(self.deflected(direction, None)));
        let parallax = star.parallax_rad.max(1e-6 * ARCSECOND_RAD);
        seen.distance_m = AU_M / parallax;
        seen
    }
}
