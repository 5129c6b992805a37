//! From spectra to colours: the CIE 1931 2° observer, XYZ, linear sRGB, colour differences.

use std::sync::OnceLock;

use glam::{DMat3, DVec3};

use crate::constants::LUMINOUS_EFFICACY_LM_W;
use crate::interpolate;
use crate::spectrum::read_columns;

/// Chromaticity of the CIE standard illuminant D65, 2° observer [iec61966-2-1].
pub const D65_XY: (f64, f64) = (0.3127, 0.3290);

/// Chromaticities of the red, green and blue primaries of Rec. 709 and sRGB [iec61966-2-1].
pub const REC709_XY: [(f64, f64); 3] = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)];

/// The colour-matching functions x̄, ȳ, z̄ of the CIE 1931 2° observer [cie1931], 360–830 nm.
pub struct Observer {
    wavelength_nm: Vec<f64>,
    xyz_bar: [Vec<f64>; 3],
}

impl Observer {
    /// The table of `assets/colour/cie1931_2deg.csv`, read once.
    pub fn cie1931() -> &'static Self {
        static OBSERVER: OnceLock<Observer> = OnceLock::new();
        OBSERVER.get_or_init(|| {
            let csv = include_str!("../../../assets/colour/cie1931_2deg.csv");
            let (wavelength_nm, x) = read_columns(csv, 0, 1);
            Self { wavelength_nm, xyz_bar: [x, read_columns(csv, 0, 2).1, read_columns(csv, 0, 3).1] }
        })
    }

    /// x̄, ȳ, z̄ at a wavelength in nm; zero outside 360–830 nm.
    pub fn at(&self, wavelength_nm: f64) -> DVec3 {
        let (Some(&first), Some(&last)) = (self.wavelength_nm.first(), self.wavelength_nm.last()) else {
            return DVec3::ZERO;
        };
        if !(first..=last).contains(&wavelength_nm) {
            return DVec3::ZERO;
        }
        DVec3::from_array([0, 1, 2].map(|i| interpolate::linear(&self.wavelength_nm, &self.xyz_bar[i], wavelength_nm)))
    }

    /// Photometric tristimulus values of a spectrum: 683 lm/W · ∫ S(λ) (x̄, ȳ, z̄) dλ.
    ///
    /// `spectrum` gives W m⁻² sr⁻¹ nm⁻¹ (then Y is in cd m⁻²) or W m⁻² nm⁻¹ (then Y is in lx).
    /// Trapezoidal sum over the observer's own 5 nm grid.
    pub fn xyz_of(&self, spectrum: impl Fn(f64) -> f64) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for i in 0..self.wavelength_nm.len() {
            let step_nm = match i {
                0 => 0.5 * (self.wavelength_nm[1] - self.wavelength_nm[0]),
                _ if i + 1 == self.wavelength_nm.len() => 0.5 * (self.wavelength_nm[i] - self.wavelength_nm[i - 1]),
                _ => 0.5 * (self.wavelength_nm[i + 1] - self.wavelength_nm[i - 1]),
            };
            let bar = DVec3::new(self.xyz_bar[0][i], self.xyz_bar[1][i], self.xyz_bar[2][i]);
            sum += bar * (step_nm * spectrum(self.wavelength_nm[i]));
        }
        sum * LUMINOUS_EFFICACY_LM_W
    }
}

/// XYZ of a chromaticity at Y = 1.
pub fn xyz_of_chromaticity((x, y): (f64, f64)) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// XYZ-from-linear-sRGB: columns are the primaries, scaled so that (1, 1, 1) is D65 at Y = 1.
pub fn xyz_from_rec709() -> DMat3 {
    let primaries = DMat3::from_cols_array_2d(&REC709_XY.map(|xy| xyz_of_chromaticity(xy).to_array()));
    let weights = primaries.inverse() * xyz_of_chromaticity(D65_XY);
    primaries * DMat3::from_diagonal(weights)
}

/// Linear-sRGB-from-XYZ, the inverse of [`xyz_from_rec709`].
pub fn rec709_from_xyz() -> DMat3 {
    xyz_from_rec709().inverse()
}

/// XYZ seen under one white as it would look under another: von Kries' law in Bradford's cone space [lam1985].
///
/// M⁻¹ · diag(M·to / M·from) · M. Laws tested: white becomes white; the same white changes nothing.
pub fn bradford(from_white: DVec3, to_white: DVec3) -> DMat3 {
    let cones = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    cones.inverse() * DMat3::from_diagonal((cones * to_white) / (cones * from_white)) * cones
}

/// CIE 1976 L*a*b* of XYZ relative to a white point [cie15].
pub fn lab_from_xyz(xyz: DVec3, white: DVec3) -> DVec3 {
    let f = |t: f64| {
        const DELTA: f64 = 6.0 / 29.0;
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let (fx, fy, fz) = (f(xyz.x / white.x), f(xyz.y / white.y), f(xyz.z / white.z));
    DVec3::new(116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz))
}

/// Colour difference ΔE2000 of two L*a*b* colours, parametric factors 1 [sharma2005].
pub fn delta_e_2000(a: DVec3, b: DVec3) -> f64 {
    let seven = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let mean_chroma = 0.5 * (a.y.hypot(a.z) + b.y.hypot(b.z));
    let g = 0.5 * (1.0 - seven(mean_chroma));
    let (a1, a2) = (a.y * (1.0 + g), b.y * (1.0 + g));
    let (c1, c2) = (a1.hypot(a.z), a2.hypot(b.z));
    let hue = |x: f64, y: f64| if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x).to_degrees().rem_euclid(360.0) };
    let (h1, h2) = (hue(a1, a.z), hue(a2, b.z));
    let chromatic = c1 * c2 != 0.0;
    let mut dh = h2 - h1;
    if !chromatic {
        dh = 0.0;
    } else if dh > 180.0 {
        dh -= 360.0;
    } else if dh < -180.0 {
        dh += 360.0;
    }
    let (dl, dc) = (b.x - a.x, c2 - c1);
    let dbig_h = 2.0 * (c1 * c2).sqrt() * (0.5 * dh).to_radians().sin();
    let (mean_l, mean_c) = (0.5 * (a.x + b.x), 0.5 * (c1 + c2));
    let mean_h = if !chromatic {
        h1 + h2
    } else if (h1 - h2).abs() <= 180.0 {
        0.5 * (h1 + h2)
    } else if h1 + h2 < 360.0 {
        0.5 * (h1 + h2 + 360.0)
    } else {
        0.5 * (h1 + h2 - 360.0)
    };
    let cos_deg = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos_deg(mean_h - 30.0) + 0.24 * cos_deg(2.0 * mean_h) + 0.32 * cos_deg(3.0 * mean_h + 6.0)
        - 0.20 * cos_deg(4.0 * mean_h - 63.0);
    let l50 = (mean_l - 50.0).powi(2);
    let s_l = 1.0 + 0.015 * l50 / (20.0 + l50).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * mean_c, 1.0 + 0.015 * mean_c * t);
    let rotation = -(60.0 * (-((mean_h - 275.0) / 25.0).powi(2)).exp()).to_radians().sin() * 2.0 * seven(mean_c);
    let (l, c, h) = (dl / s_l, dc / s_c, dbig_h / s_h);
    (l * l + c * c + h * h + rotation * c * h).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rec709_matrix_is_the_published_one() {
        // IEC 61966-2-1 prints XYZ-from-RGB with four digits.
        let published = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        let ours = xyz_from_rec709();
        for (row, values) in published.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                assert!((ours.col(column)[row] - value).abs() < 6e-5, "{row} {column}");
            }
        }
    }

    /// From illuminant A (1.09850, 1, 0.35585) to D65: the matrix printed by Lindbloom has 0.8446965 in its corner.
    #[test]
    fn bradford_maps_white_to_white() {
        let (a, d65) = (DVec3::new(1.09850, 1.0, 0.35585), xyz_of_chromaticity(D65_XY));
        assert!((bradford(a, d65) * a - d65).length() < 1e-12);
        assert!((bradford(a, a) * d65 - d65).length() < 1e-12);
        assert!((bradford(a, d65).col(0).x - 0.8446965).abs() < 2e-4, "{}", bradford(a, d65));
    }

    #[test]
    fn an_equal_energy_spectrum_is_white() {
        let xyz = Observer::cie1931().xyz_of(|_| 1.0);
        assert!((xyz.x / xyz.y - 1.0).abs() < 1e-3 && (xyz.z / xyz.y - 1.0).abs() < 1e-3, "{xyz}");
        // ∫ ȳ dλ = 106.857 nm.
        assert!((xyz.y / 683.0 - 106.857).abs() < 0.01, "{}", xyz.y / 683.0);
    }

    /// Pairs 1, 4, 7, 17 and 25 of Sharma, Wu and Dalal 2005, table 1.
    #[test]
    fn delta_e_2000_matches_published_pairs() {
        for (a, b, published) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ] {
            let ours = delta_e_2000(DVec3::from_array(a), DVec3::from_array(b));
            assert!((ours - published).abs() < 1e-4, "{ours} {published}");
        }
    }
}
