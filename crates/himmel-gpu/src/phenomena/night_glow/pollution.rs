//! Light of cities: how bright, and of what colour.

use glam::DVec3;

use super::cd_m2_of_mag_arcsec2;
use super::params::{Lamp, LightPollutionParams};

/// Zenith of the Bortle classes 1 to 9 without a Moon, mag/arcsec²: the middle of each class in the ranges that maps of light
/// pollution use (21.99, 21.89, 21.69, 20.49, 19.50, 18.94, 18.38, 17.80 between them). The scale itself speaks of what one
/// sees, not of luminance [bortle2001].
const BORTLE_MAG_ARCSEC2: [f64; 9] = [22.0, 21.94, 21.79, 21.09, 20.0, 19.22, 18.66, 18.09, 17.5];

/// Luminance that lamps add at the zenith, cd m⁻².
pub fn zenith_cd_m2(params: &LightPollutionParams) -> f64 {
    match params.bortle {
        Some(class) => {
            let index = (class.max(1) as usize - 1).min(BORTLE_MAG_ARCSEC2.len() - 1);
            cd_m2_of_mag_arcsec2(BORTLE_MAG_ARCSEC2[index]) - cd_m2_of_mag_arcsec2(BORTLE_MAG_ARCSEC2[0])
        }
        None => params.zenith_mcd_m2 * 1e-3,
    }
}

/// XYZ of the lamps' light with luminance 1: the CIE's illuminants HP1 and LED-B3   [cie15-2018]
pub fn xyz(lamp: Lamp) -> DVec3 {
    let of = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let (sodium, led) = (of(0.5330, 0.4150), of(0.3756, 0.3723));
    match lamp {
        Lamp::Sodium => sodium,
        Lamp::Led => led,
        Lamp::Mixed => 0.5 * (sodium + led),
    }
}

#[cfg(test)]
mod tests {
    use super::super::S10_CD_M2;
    use super::*;

    #[test]
    fn classes_and_luminances() {
        let zenith = |bortle| zenith_cd_m2(&LightPollutionParams { bortle, ..Default::default() });
        assert_eq!((zenith(None), zenith(Some(1))), (0.0, 0.0));
        // An inner city: a hundred times a natural night (225 S10).
        let city = zenith(Some(9)) / (225.0 * S10_CD_M2);
        assert!((40.0..120.0).contains(&city), "{city}");
        for class in 1..9 {
            assert!(zenith(Some(class)) < zenith(Some(class + 1)));
        }
    }
}
