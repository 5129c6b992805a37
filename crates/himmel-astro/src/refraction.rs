//! Bending of light near the horizon, as a formula. The ray-traced one belongs to the air.

use crate::error::{Result, in_range};

/// The air at the observer, as far as refraction by formula needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirAtObserver {
    pressure_hpa: f64,
    temperature_k: f64,
}

impl Default for AirAtObserver {
    /// 1010 hPa and 10 °C, the values that Sæmundsson's formula was made for.
    fn default() -> Self {
        Self { pressure_hpa: 1010.0, temperature_k: 283.15 }
    }
}

/// Airless altitude below which refraction fades, and where it has gone: there the ground is in the way.
const FADE_FROM_DEG: f64 = -1.0;
const FADE_TO_DEG: f64 = -6.0;

impl AirAtObserver {
    /// No air: nothing bends.
    pub const VACUUM: Self = Self { pressure_hpa: 0.0, temperature_k: 283.15 };

    /// Pressure in 0..=1200 hPa, temperature in 100..=400 K.
    pub fn new(pressure_hpa: f64, temperature_k: f64) -> Result<Self> {
        in_range("pressure", "0..=1200 hPa", pressure_hpa, 0.0, 1200.0, " (is this in pascal?)")?;
        in_range("temperature", "100..=400 K", temperature_k, 100.0, 400.0, " (is this in degrees Celsius?)")?;
        Ok(Self { pressure_hpa, temperature_k })
    }

    /// The standard atmosphere's pressure at a height above sea level, 0 above 100 km.
    ///
    /// p = 1010 (1 − 22.558e-6 h)^5.2559 below 11 km, then e^(−(h − 11 km) / 6.3416 km)   [icao1993], with 1010 for 1013.25 so that
    /// the ground keeps the default of Sæmundsson's formula.
    pub fn at_height(height_m: f64) -> Self {
        let h = height_m.max(-1000.0);
        let pressure_hpa = if h.is_nan() || h > 100_000.0 {
            0.0
        } else if h < 11_000.0 {
            1010.0 * (1.0 - 2.2558e-5 * h).powf(5.2559)
        } else {
            1010.0 * 0.223_36 * (-(h - 11_000.0) / 6341.6).exp()
        };
        let temperature_k = if h.is_nan() { 283.15 } else { (283.15 - 0.0065 * h).clamp(216.65, 290.0) };
        Self { pressure_hpa, temperature_k }
    }

    /// How much higher a light appears than it is, by its airless altitude. Never negative, 0 without air.
    ///
    /// R = 1.02′ / tan(h + 10.3° / (h + 5.11°)) · p / 1010 hPa · 283 K / T   [saemundsson1986; meeus1998, eq. 16.4], `h` in degrees
    ///
    /// Below −1° the formula runs towards its pole at −5.11°; R keeps its value at −1° and fades smoothly to 0 at −6°.
    /// Near the zenith, where the formula is −0.0014′, 0 is taken.
    /// Laws tested: 0 in vacuum; continuous, and h + R rises with h everywhere.
    pub fn refraction_rad(&self, airless_altitude_rad: f64) -> f64 {
        if airless_altitude_rad.is_nan() {
            return 0.0;
        }
        let altitude_deg = airless_altitude_rad.to_degrees();
        let h = altitude_deg.clamp(FADE_FROM_DEG, 90.0);
        let arcminutes = 1.02 / (h + 10.3 / (h + 5.11)).to_radians().tan();
        let x = ((altitude_deg - FADE_TO_DEG) / (FADE_FROM_DEG - FADE_TO_DEG)).clamp(0.0, 1.0);
        let fade = x * x * (3.0 - 2.0 * x);
        let scale = self.pressure_hpa / 1010.0 * 283.0 / self.temperature_k;
        (arcminutes.max(0.0) * fade * scale / 60.0).to_radians()
    }

    /// Altitude at which a light is seen, from its airless altitude.
    pub fn refracted_altitude_rad(&self, airless_altitude_rad: f64) -> f64 {
        airless_altitude_rad + self.refraction_rad(airless_altitude_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_values() {
        // [meeus1998, example 16.a]: true altitude 33′14.76″ of the Sun's lower limb is seen at 57.864′.
        let r = AirAtObserver::default().refraction_rad((33.0 + 14.76 / 60.0_f64).to_radians() / 60.0);
        assert!((r.to_degrees() * 60.0 - 24.618).abs() < 0.05, "{}", r.to_degrees() * 60.0);
    }

    #[test]
    fn seen_altitude_rises_with_true_altitude() {
        let air = AirAtObserver::new(1080.0, 220.0).unwrap();
        let mut last = f64::NEG_INFINITY;
        for i in -9000..=9000 {
            let seen = air.refracted_altitude_rad((f64::from(i) / 100.0).to_radians());
            assert!(seen > last && seen.is_finite(), "at {i}");
            last = seen;
        }
    }

    #[test]
    fn nothing_bends_without_air() {
        assert_eq!(AirAtObserver::VACUUM.refraction_rad(0.0), 0.0);
        assert_eq!(AirAtObserver::at_height(4e5).refraction_rad(0.0), 0.0);
        assert_eq!(AirAtObserver::default().refraction_rad(f64::NAN), 0.0);
    }
}
