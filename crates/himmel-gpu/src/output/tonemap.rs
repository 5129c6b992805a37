//! Twins of `tonemap.wgsl`: from exposed linear Rec. 709 to display-encoded values 0..1.

use glam::{DMat3, DVec3};

use super::eye::{NIGHT_BLUE, seen_by_eye};
use super::params::Tonemap;

/// Display encoding of sRGB, 0..1 to 0..1 [iec61966-2-1].
pub fn srgb_encode(linear: DVec3) -> DVec3 {
    linear.map_each(|c| if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 })
}

/// Inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: DVec3) -> DVec3 {
    encoded.map_each(|c| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) })
}

/// Clamps.
pub fn tonemap_linear(colour: DVec3) -> DVec3 {
    srgb_encode(colour.clamp(DVec3::ZERO, DVec3::ONE))
}

/// (0.38317 x)^(1/2.2) below 1.413, else 1 − e^(−x)   [collienne2013, eq. 4.25 with its threshold corrected]
///
/// Contains the display's gamma. Laws tested: continuous within 0.002 at 1.413; rises; 0 at 0.
pub fn tonemap_reinhard(colour: DVec3) -> DVec3 {
    colour.map_each(|x| if x < 1.413 { (0.38317 * x).powf(1.0 / 2.2) } else { 1.0 - (-x).exp() })
}

/// x (6.2 x + 0.5) / (x (6.2 x + 1.7) + 0.06)   [collienne2013, eq. 4.29]
///
/// Contains the display's gamma. Hejl's own form subtracts 0.004 first [hable2010]; the thesis does not.
/// Laws tested: rises; 0 at 0; below 1.
pub fn tonemap_hejl(colour: DVec3) -> DVec3 {
    colour.map_each(|c| {
        let x = c.min(1e4);
        (x * (6.2 * x + 0.5)) / (x * (6.2 * x + 1.7) + 0.06)
    })
}

/// AgX: inset, logarithm over 16.5 stops, sixth-order contrast curve, outset   [wrensch2023, from Sobotka's AgX]
///
/// Laws tested: greys stay grey; rises; ends below 1.
pub fn tonemap_agx(colour: DVec3) -> DVec3 {
    agx(colour, 1.0, 1.0)
}

/// AgX with its "punchy" look: power 1.35 and saturation 1.4 between contrast and outset   [wrensch2023]
pub fn tonemap_agx_punchy(colour: DVec3) -> DVec3 {
    agx(colour, 1.35, 1.4)
}

/// AgX with a look: `power`, `saturation`; 1, 1 is none.
fn agx(colour: DVec3, power: f64, saturation: f64) -> DVec3 {
    let inset = DMat3::from_cols_array(&[
        0.842479062253094,
        0.0423282422610123,
        0.0423756549057051,
        0.0784335999999992,
        0.878468636469772,
        0.0784336,
        0.0792237451477643,
        0.0791661274605434,
        0.879142973793104,
    ]);
    let outset = DMat3::from_cols_array(&[
        1.19687900512017,
        -0.0528968517574562,
        -0.0529716355144438,
        -0.0980208811401368,
        1.15190312990417,
        -0.0980434501171241,
        -0.0990297440797205,
        -0.0989611768448433,
        1.15107367264116,
    ]);
    let shaped = (inset * colour).map_each(|c| {
        let x = ((c.max(1e-10).log2() + 12.47393) / (4.026069 + 12.47393)).clamp(0.0, 1.0);
        15.5 * x.powi(6) - 40.14 * x.powi(5) + 31.96 * x.powi(4) - 6.868 * x.powi(3) + 0.4298 * x * x + 0.1191 * x
            - 0.00232
    });
    let shaped = shaped.max(DVec3::ZERO).map_each(|c| c.powf(power));
    let grey = DVec3::splat(shaped.dot(DVec3::new(0.2126, 0.7152, 0.0722)));
    let contrast = grey + saturation * (shaped - grey);
    let display_linear = (outset * contrast).max(DVec3::ZERO).map_each(|c| c.powf(2.2));
    srgb_encode(display_linear.clamp(DVec3::ZERO, DVec3::ONE))
}

/// Khronos PBR Neutral: untouched up to 0.8, then compressed and desaturated   [khronos2024neutral]
///
/// Laws tested: rises; hue of moderate colours stays.
pub fn tonemap_neutral(colour: DVec3) -> DVec3 {
    let start = 0.8 - 0.04;
    let x = colour.min_element();
    let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let mut shifted = colour - DVec3::splat(offset);
    let peak = shifted.max_element();
    if peak >= start {
        let d = 1.0 - start;
        let new_peak = 1.0 - d * d / (peak + d - start);
        shifted *= new_peak / peak;
        let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
        shifted = shifted.lerp(DVec3::splat(new_peak), g);
    }
    srgb_encode(shifted.clamp(DVec3::ZERO, DVec3::ONE))
}

/// What an eye sees of it, then [`tonemap_agx_punchy`].
///
/// `exposure`: what luminance was multiplied by to give `colour`.  `rod_colour`: see [`seen_by_eye`].
pub fn tonemap_eye(colour: DVec3, exposure: f64, rod_colour: DVec3) -> DVec3 {
    // 1e-20 for pictures that nobody exposed.
    let factor = exposure.max(1e-20);
    tonemap_agx_punchy((seen_by_eye(colour / factor, rod_colour) * factor).max(DVec3::ZERO))
}

/// One of the tone mappers. `exposure`: what luminance was multiplied by to give `colour`.
pub fn tonemap(operator: Tonemap, colour: DVec3, exposure: f64) -> DVec3 {
    match operator {
        Tonemap::Linear => tonemap_linear(colour),
        Tonemap::Reinhard => tonemap_reinhard(colour),
        Tonemap::Hejl => tonemap_hejl(colour),
        Tonemap::Agx => tonemap_agx(colour),
        Tonemap::AgxPunchy => tonemap_agx_punchy(colour),
        Tonemap::Neutral => tonemap_neutral(colour),
        Tonemap::Eye => tonemap_eye(colour, exposure, DVec3::ONE),
        Tonemap::EyeBlue => tonemap_eye(colour, exposure, NIGHT_BLUE),
    }
}

trait MapEach {
    fn map_each(self, f: impl Fn(f64) -> f64) -> Self;
}

impl MapEach for DVec3 {
    fn map_each(self, f: impl Fn(f64) -> f64) -> Self {
        Self::new(f(self.x), f(self.y), f(self.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operator_rises_from_black_within_the_display() {
        for &operator in Tonemap::ALL {
            let mut last = -1e-9;
            for i in 0..2000 {
                let grey = tonemap(operator, DVec3::splat(1e-4 * 1.01f64.powi(i)), 1e-4);
                assert!(grey.is_finite() && grey.min_element() >= 0.0 && grey.max_element() <= 1.0 + 1e-9);
                assert!(grey.y >= last - 2e-3, "{operator:?} falls at {i}: {last} {}", grey.y);
                assert!((grey.x - grey.z).abs() < 2e-3, "{operator:?}: greys stay grey");
                last = grey.y;
            }
            assert!(tonemap(operator, DVec3::ZERO, 1.0).max_element() < 0.01, "{operator:?}");
            assert!(last > 0.97, "{operator:?} ends at {last}");
        }
    }

    #[test]
    fn reinhard_is_continuous_and_srgb_inverts() {
        let (below, above) = (tonemap_reinhard(DVec3::splat(1.4129999)), tonemap_reinhard(DVec3::splat(1.4130001)));
        assert!((below - above).length() < 0.002 * 3f64.sqrt(), "{below} {above}");
        for i in 0..=100 {
            let c = DVec3::splat(f64::from(i) / 100.0);
            assert!((srgb_decode(srgb_encode(c)) - c).length() < 1e-6);
        }
    }
}
