//! The colour spaces that FLIP walks through: sRGB → linear → XYZ → YCxCz or L*a*b*.
//!
//! White is the XYZ of linear RGB (1, 1, 1), D65, so that greys have no chroma at all.

/// Linear sRGB to CIE XYZ, rows X, Y, Z: the matrix that the sRGB primaries and D65 (0.3127, 0.3290) give.
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [0.412_390_799_265_959_5, 0.357_584_339_383_878, 0.180_480_788_401_834_3],
    [0.212_639_005_871_510_36, 0.715_168_678_767_756, 0.072_192_315_360_733_71],
    [0.019_330_818_715_591_85, 0.119_194_779_794_625_99, 0.950_532_152_249_660_5],
];

/// The inverse of [`XYZ_FROM_RGB`].
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_941_904_521_3, -1.537_383_177_570_093_5, -0.498_610_760_293_003_4],
    [-0.969_243_636_280_879_8, 1.875_967_501_507_720_7, 0.041_555_057_407_175_61],
    [0.055_630_079_696_993_61, -0.203_976_958_888_976_57, 1.056_971_514_242_878_6],
];

/// Relative luminance of linear sRGB (Rec. 709 primaries): the Y row of the matrix to XYZ.
pub(crate) fn luminance(rgb: [f64; 3]) -> f64 {
    let y = XYZ_FROM_RGB[1];
    y[0] * rgb[0] + y[1] * rgb[1] + y[2] * rgb[2]
}

/// An 8-bit sRGB code value as linear light in 0..=1.
pub(crate) fn linear_from_srgb8(code: u8) -> f64 {
    let s = f64::from(code) / 255.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

/// Linear light as the nearest 8-bit sRGB code value; values outside 0..=1 are clamped, NaN gives 0.
pub(crate) fn srgb8_from_linear(linear: f64) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let s = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * s).round() as u8 // `as` saturates and takes NaN to 0
}

/// XYZ of linear RGB, divided by white: (X/Xn, Y/Yn, Z/Zn).
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    XYZ_FROM_RGB.map(|row| {
        let white: f64 = row.iter().sum();
        (row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]) / white
    })
}

/// YCxCz, CIELAB without its cube root: the space in which FLIP's eye blurs.
///
/// Y = 116 Y/Yn − 16,  Cx = 500 (X/Xn − Y/Yn),  Cz = 200 (Y/Yn − Z/Zn)     [andersson2020flip, colour pipeline]
pub(crate) fn ycxcz_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`ycxcz_from_linear`].
pub(crate) fn linear_from_ycxcz(c: [f64; 3]) -> [f64; 3] {
    let y = (c[0] + 16.0) / 116.0;
    let relative = [y + c[1] / 500.0, y, y - c[2] / 200.0];
    let mut xyz = [0.0; 3];
    for (i, row) in XYZ_FROM_RGB.iter().enumerate() {
        xyz[i] = relative[i] * row.iter().sum::<f64>();
    }
    RGB_FROM_XYZ.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
}

/// CIE L*a*b* of linear RGB.
fn lab_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| {
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz(rgb).map(f);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// L*a*b* with the Hunt effect: colours look more colourful where it is bright.
///
/// a_h = 0.01 L* a*,  b_h = 0.01 L* b*     [andersson2020flip, colour pipeline]
pub(crate) fn hunt_lab_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let [l, a, b] = lab_from_linear(rgb);
    [l, 0.01 * l * a, 0.01 * l * b]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ycxcz_and_back_is_the_identity() {
        for rgb in [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.7, 0.05], [1.0, 0.0, 0.3]] {
            let back = linear_from_ycxcz(ycxcz_from_linear(rgb));
            for i in 0..3 {
                assert!((back[i] - rgb[i]).abs() < 1e-12, "{rgb:?} came back as {back:?}");
            }
        }
    }

    #[test]
    fn every_code_value_survives_linear_light() {
        for code in 0..=255 {
            assert_eq!(srgb8_from_linear(linear_from_srgb8(code)), code);
        }
        assert_eq!(srgb8_from_linear(f64::NAN), 0);
        assert_eq!(srgb8_from_linear(f64::INFINITY), 255);
    }

    #[test]
    fn white_is_l_100_and_grey_has_no_chroma() {
        let [l, a, b] = hunt_lab_from_linear([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-12 && a.abs() < 1e-12 && b.abs() < 1e-12);
        let [_, a, b] = hunt_lab_from_linear([0.18; 3]);
        assert!(a.abs() < 1e-12 && b.abs() < 1e-12);
    }
}
