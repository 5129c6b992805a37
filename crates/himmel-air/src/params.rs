//! The parameters of air, ground and Sun.

use himmel_core::{choices, params};

choices! {
    /// How finely the air is computed: sizes of its tables, samples along rays, orders of scattering.
    pub enum AirQuality {
        /// For small GPUs: errors of a per cent or two, coarser twilight.
        Low = "low",
        /// Between the two.
        Medium = "medium",
        /// In real time: within a few tenths of a per cent of the moment solver.
        High = "high",
        /// Every pixel marches its own ray: for pictures.
        Film = "film",
    }
}

params! {
    /// What is between you and the stars.
    pub struct AirParams: "air" {
        /// Whether there is air at all.
        enabled: bool = true;
        /// Factor on the amount of every gas that scatters.
        molecules: f64 = 1.0, "", 0.0..=100.0;
        /// Factor on the amount of every aerosol.
        aerosols: f64 = 1.0, "", 0.0..=1000.0;
        /// Factor on the amount of every gas that only absorbs, such as ozone.
        absorbers: f64 = 1.0, "", 0.0..=100.0;
        /// How finely it is computed; unset: high (film for `himmel radiance --solver gpu`).
        quality: Option<AirQuality> = None;
        /// Cells along a ray; unset: those of the quality (16 to 48).
        steps: Option<u32> = None, "", 4.0..=512.0;
        /// First of the four wavelengths that are rendered (red).
        wavelength_1_nm: f64 = 630.0, "nm", 380.0..=780.0;
        /// Second of the four wavelengths (green).
        wavelength_2_nm: f64 = 560.0, "nm", 380.0..=780.0;
        /// Third of the four wavelengths (cyan).
        wavelength_3_nm: f64 = 490.0, "nm", 380.0..=780.0;
        /// Fourth of the four wavelengths (violet).
        wavelength_4_nm: f64 = 430.0, "nm", 380.0..=780.0;
    }
}

params! {
    /// The planet's surface, a sphere that scatters evenly (Lambert).
    pub struct GroundParams: "ground" {
        /// Whether it reflects light; it hides what is behind it either way.
        enabled: bool = true;
        /// Share of light that it reflects; unset: the preset's.
        albedo: Option<f64> = None, "", 0.0..=1.0;
    }
}

params! {
    /// The Sun as a light and as a disc.
    pub struct SunParams: "light.sun" {
        /// Whether the disc is drawn; its light stays.
        disc: bool = true;
        /// Whether the disc darkens towards its limb.
        limb_darkening: bool = true;
        /// Factor on the disc's apparent radius; its illuminance stays.
        radius_scale: f64 = 1.0, "", 0.01..=100.0;
        /// Factor on its illuminance.
        brightness: f64 = 1.0, "", 0.0..=1e6;
        /// Distance; unset: the preset's, or the ephemeris for the Earth.
        distance_au: Option<f64> = None, "au", 0.001..=10000.0;
        /// Azimuth from north through east; unset: from place and time.
        azimuth_deg: Option<f64> = None, "°", -360.0..=360.0;
        /// Altitude above the horizon, without refraction; unset: from place and time.
        altitude_deg: Option<f64> = None, "°", -90.0..=90.0;
    }
}

impl AirParams {
    /// The four wavelengths, nm.
    pub fn wavelengths_nm(&self) -> [f64; 4] {
        [self.wavelength_1_nm, self.wavelength_2_nm, self.wavelength_3_nm, self.wavelength_4_nm]
    }
}
