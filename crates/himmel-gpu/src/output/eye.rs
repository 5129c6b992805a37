//! Twin of `eye.wgsl`: what an eye makes of a luminance. Its parts are in [`himmel_core::vision`].

use glam::DVec3;
use himmel_core::vision::{EIGENGRAU_CD_M2, mesopic, scotopic_from_rec709};

/// Linear Rec. 709 of the chromaticity (0.25, 0.25) at luminance 1: the blue that painters give to the night [jensen2000].
pub const NIGHT_BLUE: DVec3 = DVec3::new(0.70636524, 0.98983398, 1.96559615);

/// Weights of luminance in linear Rec. 709 [iec61966-2-1].
pub const LUMINANCE_WEIGHTS: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// What is seen of a luminance: its mesopic luminance [cie191], as much of its colour as cones give, and the retina's own
/// light.
///
/// `rgb`: linear Rec. 709 in cd m⁻².  `rod_colour`: what light that rods alone see looks like, at luminance 1; white is what
/// they report, [`NIGHT_BLUE`] an artistic setting.
/// Laws tested: from 5 cd m⁻² up nothing changes; below 0.005 there is no colour; blue grows brighter than red; black is the
/// retina's own light.
pub fn seen_by_eye(rgb: DVec3, rod_colour: DVec3) -> DVec3 {
    let photopic = rgb.dot(LUMINANCE_WEIGHTS);
    let (m, luminance) = mesopic(photopic, rgb.dot(scotopic_from_rec709()) + EIGENGRAU_CD_M2);
    let colour = if photopic > 0.0 { rgb / photopic } else { DVec3::ONE };
    luminance * rod_colour.lerp(colour, m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_goes_with_the_light() {
        let red = DVec3::new(1.0, 0.1, 0.05);
        let blue = DVec3::new(0.1, 0.3, 1.0);
        let at = |colour: DVec3, luminance: f64| {
            seen_by_eye(colour * (luminance / colour.dot(LUMINANCE_WEIGHTS)), DVec3::ONE)
        };
        let day = at(red, 50.0);
        assert!((day - red * (50.0 / red.dot(LUMINANCE_WEIGHTS))).length() < 1e-9, "{day}");
        let night = at(red, 0.001);
        assert!((night.x - night.z).abs() < 1e-12, "{night}");
        // Purkinje: equal by day, at night blue is several times as bright as red.
        assert!((at(blue, 50.0).dot(LUMINANCE_WEIGHTS) - 50.0).abs() < 1e-6);
        let ratio = at(blue, 0.001).y / at(red, 0.001).y;
        assert!(ratio > 4.0, "{ratio}");
        assert_eq!(seen_by_eye(DVec3::ZERO, DVec3::ONE), DVec3::splat(EIGENGRAU_CD_M2));
        assert!((NIGHT_BLUE.dot(LUMINANCE_WEIGHTS) - 1.0).abs() < 1e-3);
    }
}
