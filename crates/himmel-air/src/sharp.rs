//! Thesis B's way from spectra to colour: spectra are filtered into three sharp channels before light is followed.

use glam::{DMat3, DVec3};
use himmel_core::colour::{D65_XY, Observer, xyz_of_chromaticity};
use himmel_core::spectrum::Spectrum;

use crate::medium::{Medium, Sampled, SampledComponent};

/// Sharp-RGB-from-XYZ [klupiec2024, eq. 27; ward2002].
pub const SHARP_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(1.2694, -0.8364, 0.0297),
    DVec3::new(-0.0988, 1.8006, -0.0315),
    DVec3::new(-0.1706, 0.0357, 1.0018),
);

/// Wavelengths that stand for the three channels where only one will do, such as phase functions: the channels'
/// centres of mass under equal energy, to 5 nm (test).
pub const CHANNELS_NM: [f64; 3] = [590.0, 540.0, 455.0];

/// A light that is the white of everything under it.
#[derive(Clone, Debug)]
pub struct Prefilter {
    light: Spectrum,
    reference: DVec3,
}

impl Prefilter {
    /// From the dominant light's spectrum.
    pub fn new(light: &Spectrum) -> Self {
        let reference = SHARP_FROM_XYZ * Observer::cie1931().xyz_of(|nm| light.at(nm));
        Self { light: light.clone(), reference }
    }

    /// A light relative to the dominant one, channel by channel [klupiec2024, eq. 28].
    pub fn light(&self, other: &Spectrum) -> DVec3 {
        SHARP_FROM_XYZ * Observer::cie1931().xyz_of(|nm| other.at(nm)) / self.reference
    }

    /// An albedo, cross section or coefficient in three channels: its mean under the light [klupiec2024, eq. 29].
    ///
    /// Laws tested: a constant stays itself. Channels may go below zero for narrow bands, which the matrix's negative
    /// entries allow; a medium cannot use that, so [`Prefilter::sampled`] holds them at zero.
    pub fn property(&self, property: &Spectrum) -> DVec3 {
        SHARP_FROM_XYZ * Observer::cie1931().xyz_of(|nm| self.light.at(nm) * property.at(nm)) / self.reference
    }

    /// The medium in three channels.
    pub fn sampled<'a>(&self, medium: &'a Medium) -> Sampled<'a, 3> {
        let channels = |spectrum: &Spectrum| self.property(spectrum).max(DVec3::ZERO).to_array();
        let components = medium.components.iter().map(|component| {
            let scattering_per_m = channels(&component.scattering_per_m).map(|s| s * component.amount);
            let absorption = channels(&component.absorption_per_m);
            let extinction_per_m = std::array::from_fn(|i| scattering_per_m[i] + absorption[i] * component.amount);
            SampledComponent { scattering_per_m, extinction_per_m }
        });
        Sampled {
            medium,
            wavelengths_nm: CHANNELS_NM,
            components: components.collect(),
            ground_albedo: channels(&medium.ground_albedo),
        }
    }

    /// XYZ of a radiance in channels per unit irradiance of the light, as the light itself would look: no adaptation.
    pub fn xyz(&self, channels: DVec3) -> DVec3 {
        SHARP_FROM_XYZ.inverse() * (channels * self.reference)
    }
}

/// XYZ with D65 for white, at Y = 1 for channels of 1: von Kries in sharp channels [klupiec2024, eq. 30–31]. Multiply
/// with Rec.-709-from-XYZ for linear sRGB.
pub fn xyz_adapted_to_d65(channels: DVec3) -> DVec3 {
    let white = SHARP_FROM_XYZ * xyz_of_chromaticity(D65_XY);
    SHARP_FROM_XYZ.inverse() * (channels * white)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{fit_xyz_from_four, sky_sample};
    use crate::single::{Ray, march};
    use crate::{Columns, Preset};
    use glam::DVec4;
    use himmel_core::colour::{bradford, delta_e_2000, lab_from_xyz};

    #[test]
    fn a_constant_stays_itself_and_white_is_white() {
        let prefilter = Prefilter::new(&Spectrum::PowerLaw { reference_nm: 550.0, value: 1.0, exponent: -2.0 });
        assert!((prefilter.property(&Spectrum::Constant(0.3)) - DVec3::splat(0.3)).length() < 1e-12);
        let white = xyz_adapted_to_d65(DVec3::ONE);
        assert!((white - xyz_of_chromaticity(D65_XY)).length() < 1e-12);
        assert!((prefilter.light(&prefilter.light.clone()) - DVec3::ONE).length() < 1e-12);
    }

    #[test]
    fn the_channels_have_their_wavelengths() {
        for (channel, stated) in CHANNELS_NM.iter().enumerate() {
            let (mut mass, mut moment) = (0.0, 0.0);
            for i in 0..=470 {
                let nm = 360.0 + f64::from(i);
                let weight = (SHARP_FROM_XYZ * Observer::cie1931().at(nm))[channel].max(0.0);
                mass += weight;
                moment += weight * nm;
            }
            assert!((moment / mass - stated).abs() < 5.0, "{channel}: {}", moment / mass);
        }
    }

    /// Four wavelengths and sharp channels against the full spectrum, single scattering, adapted to D65 (Bradford, or
    /// the sharp channels' own), brightest point at Y = 100: printed for `docs/air.md`. Four wavelengths must be better.
    #[test]
    fn four_wavelengths_beat_three_sharp_channels() {
        let four_nm = [630.0, 560.0, 490.0, 430.0];
        let white = xyz_of_chromaticity(D65_XY);
        for name in ["earth", "earth-haze", "mars", "m-dwarf-ocean"] {
            let preset = Preset::named(name).unwrap();
            let (medium, columns, light) =
                (&preset.medium, Columns::new(&preset.medium), preset.light_at_1_au_w_m2_nm());
            let rows = fit_xyz_from_four(medium, &columns, &light, &four_nm);
            let prefilter = Prefilter::new(&light);
            let channels = prefilter.sampled(medium);
            let own_white = Observer::cie1931().xyz_of(|nm| light.at(nm));
            let adapt = bradford(own_white / own_white.y, white);
            let (mut by_four, mut by_sharp) = (Vec::new(), Vec::new());
            for sun_deg in [60.0f64, 20.0, 5.0, 0.0, -4.0, -6.0] {
                let mut skies = Vec::new();
                for view_deg in [1.0f64, 25.0, 50.0, 70.0, 85.0] {
                    for azimuth_deg in [20.0f64, 60.0, 100.0, 140.0, 180.0] {
                        let sample = sky_sample(medium, &columns, &four_nm, sun_deg, view_deg, azimuth_deg);
                        let (sun, view) = (sun_deg.to_radians(), view_deg.to_radians());
                        let nu = view.sin() * sun.cos() * azimuth_deg.to_radians().cos() + view.cos() * sun.sin();
                        let ray = Ray { altitude_m: 0.0, mu: view.cos(), mu_s: sun.sin(), nu };
                        let sharp = DVec3::from_array(march(&channels, &columns, &ray, 16).radiance_per_sr);
                        let four = DVec4::from_array(sample.four);
                        let ours = DVec3::from_array(rows.map(|row| row.dot(four)));
                        skies.push((adapt * sample.xyz(&light), adapt * ours, xyz_adapted_to_d65(sharp) * own_white.y));
                    }
                }
                let scale = 1.0 / skies.iter().map(|sky| sky.0.y).fold(1e-30, f64::max);
                let lab = |xyz: DVec3| lab_from_xyz(xyz * scale, white);
                by_four.extend(skies.iter().map(|sky| delta_e_2000(lab(sky.0), lab(sky.1))));
                by_sharp.extend(skies.iter().map(|sky| delta_e_2000(lab(sky.0), lab(sky.2))));
            }
            let middle = |values: &mut Vec<f64>| {
                values.sort_by(f64::total_cmp);
                (values[values.len() / 2], values[values.len() - 1])
            };
            let (four, sharp) = (middle(&mut by_four), middle(&mut by_sharp));
            println!(
                "{name}: four wavelengths {:.2} / {:.2}, sharp channels {:.2} / {:.2} (median / worst)",
                four.0, four.1, sharp.0, sharp.1
            );
            assert!(four.0 < sharp.0, "{name}");
        }
    }
}
