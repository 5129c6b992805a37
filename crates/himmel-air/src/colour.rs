//! From four wavelengths to colour.

use glam::{DMat3, DMat4, DVec3, DVec4};
use himmel_core::colour::{Observer, rec709_from_xyz};
use himmel_core::interpolate;
use himmel_core::spectrum::Spectrum;
use himmel_core::vision::scotopic_of;

use crate::columns::Columns;
use crate::hillaire::{Hillaire, Placement, Settings};
use crate::medium::{Medium, Sampled};
use crate::single::{Ray, march};

/// Wavelengths of the spectra that the matrix is fitted to: 360, 370 … 830 nm.
pub const SPECTRAL_NM: [f64; 48] = {
    let mut wavelengths = [0.0; 48];
    let mut i = 0;
    while i < 48 {
        wavelengths[i] = 360.0 + 10.0 * i as f64;
        i += 1;
    }
    wavelengths
};

/// A spectrum relative to the light's, at [`SPECTRAL_NM`] and at the renderer's four wavelengths.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Per unit irradiance of the light, on the fine grid.
    pub fine: [f64; 48],
    /// Per unit irradiance of the light, at the four wavelengths.
    pub four: [f64; 4],
}

impl Sample {
    /// Photometric XYZ of the fine spectrum under a light in W m⁻² nm⁻¹.
    pub fn xyz(&self, light_w_m2_nm: &Spectrum) -> DVec3 {
        Observer::cie1931().xyz_of(|wavelength_nm| {
            interpolate::linear(&SPECTRAL_NM, &self.fine, wavelength_nm) * light_w_m2_nm.at(wavelength_nm)
        })
    }

    /// Its scotopic luminance, cd m⁻².
    pub fn scotopic(&self, light_w_m2_nm: &Spectrum) -> f64 {
        scotopic_of(|wavelength_nm| {
            interpolate::linear(&SPECTRAL_NM, &self.fine, wavelength_nm) * light_w_m2_nm.at(wavelength_nm)
        })
    }
}

/// Sun elevations, view zenith angles and azimuths (degrees) whose skies, seen from the ground, the matrix is fitted to.
const TRAINING_SUN_DEG: [f64; 7] = [75.0, 40.0, 15.0, 5.0, 1.0, -2.0, -5.0];
const TRAINING_VIEW_DEG: [f64; 4] = [10.0, 50.0, 75.0, 87.0];
const TRAINING_AZIMUTH_DEG: [f64; 3] = [10.0, 90.0, 180.0];
/// The same of a planet seen from space: heights over the limb as shares of the air's, and cosines of nadir angles.
const TRAINING_SPACE_SUN_DEG: [f64; 3] = [70.0, 20.0, 3.0];
const TRAINING_LIMB: [f64; 3] = [0.05, 0.15, 0.3];
const TRAINING_DOWN: [f64; 2] = [1.0, 0.5];
const TRAINING_SPACE_AZIMUTH_DEG: [f64; 2] = [40.0, 130.0];

/// All orders of scattering for them: coarse, since only spectra matter, and those of thick air are made by its later orders.
const TRAINING: Settings = Settings {
    transmittance: None,
    placement: Placement::Crowded,
    suns: 12,
    altitudes: 8,
    zeniths: 5,
    azimuths: 2,
    direction_steps: 12,
    frame_steps: 16,
};

fn training_rays(medium: &Medium) -> Vec<Ray> {
    let mut rays = Vec::new();
    let mut add = |altitude_m: f64, mu: f64, sun_deg: f64, azimuth_deg: f64| {
        let (sin_s, cos_s) = sun_deg.to_radians().sin_cos();
        let nu = (1.0 - mu * mu).max(0.0).sqrt() * cos_s * azimuth_deg.to_radians().cos() + mu * sin_s;
        rays.push(Ray { altitude_m, mu, mu_s: sin_s, nu: nu.clamp(-1.0, 1.0) });
    };
    for sun_deg in TRAINING_SUN_DEG {
        for view_deg in TRAINING_VIEW_DEG {
            for azimuth_deg in TRAINING_AZIMUTH_DEG {
                add(0.0, view_deg.to_radians().cos(), sun_deg, azimuth_deg);
            }
        }
    }
    let (radius_m, top_m) = (medium.bottom_radius_m, medium.top_altitude_m);
    for sun_deg in TRAINING_SPACE_SUN_DEG {
        for azimuth_deg in TRAINING_SPACE_AZIMUTH_DEG {
            for share in TRAINING_LIMB {
                let sine = (radius_m + share * top_m) / (radius_m + top_m);
                add(top_m, -(1.0 - sine * sine).max(0.0).sqrt(), sun_deg, azimuth_deg);
            }
            for down in TRAINING_DOWN {
                add(top_m, -down, sun_deg, azimuth_deg);
            }
        }
    }
    rays
}

/// The spectra along rays with all orders of scattering, by a coarse solver: for colours, not for brightness.
pub fn skies(medium: &Medium, columns: &Columns, four_nm: &[f64; 4], rays: &[Ray]) -> Vec<Sample> {
    fn radiances<const N: usize>(air: &Sampled<'_, N>, columns: &Columns, rays: &[Ray]) -> Vec<[f64; N]> {
        let sky = Hillaire::build(air, columns, &TRAINING);
        rays.iter().map(|ray| sky.radiance(air, columns, ray)).collect()
    }
    let fine = radiances(&medium.sampled(&SPECTRAL_NM), columns, rays);
    let four = radiances(&medium.sampled(four_nm), columns, rays);
    fine.into_iter().zip(four).map(|(fine, four)| Sample { fine, four }).collect()
}

/// A ray on the ground: the Sun's elevation, the ray's zenith angle and its azimuth from the Sun, degrees.
pub fn ground_ray(sun_deg: f64, view_deg: f64, azimuth_deg: f64) -> Ray {
    let (sun, view) = (sun_deg.to_radians(), view_deg.to_radians());
    let nu = view.sin() * sun.cos() * azimuth_deg.to_radians().cos() + view.cos() * sun.sin();
    Ray { altitude_m: 0.0, mu: view.cos(), mu_s: sun.sin(), nu: nu.clamp(-1.0, 1.0) }
}

/// The spectrum of light scattered once at one geometry, seen from the ground.
pub fn sky_sample(
    medium: &Medium,
    columns: &Columns,
    four_nm: &[f64; 4],
    sun_deg: f64,
    view_deg: f64,
    azimuth_deg: f64,
) -> Sample {
    let ray = ground_ray(sun_deg, view_deg, azimuth_deg);
    let fine = march(&medium.sampled(&SPECTRAL_NM), columns, &ray, 16).radiance_per_sr;
    let four = march(&medium.sampled(four_nm), columns, &ray, 16).radiance_per_sr;
    Sample { fine, four }
}

/// The light itself after some air; elevation 90° and zero depth stands for space.
fn beam_sample(medium: &Medium, columns: &Columns, four_nm: &[f64; 4], sun_deg: f64) -> Sample {
    fn through<const N: usize>(air: &Sampled<'_, N>, columns: &Columns, mu: f64) -> [f64; N] {
        columns.optical_depth(air, 0.0, mu).map(|depth| (-depth).exp())
    }
    let mu = sun_deg.to_radians().sin();
    Sample {
        fine: through(&medium.sampled(&SPECTRAL_NM), columns, mu),
        four: through(&medium.sampled(four_nm), columns, mu),
    }
}

/// XYZ-from-four-wavelengths: least squares over many skies and beams of this medium under this light, from the ground and
/// from space, with all orders of scattering.
///
/// Rows X, Y, Z. Multiplies radiance per unit irradiance of the light (sr⁻¹) and gives cd m⁻² for Y; every sample is
/// weighted by 1/Y, so that a dim twilight counts as much as noon. The light above the air is one of the samples.
pub fn fit_xyz_from_four(
    medium: &Medium,
    columns: &Columns,
    light_w_m2_nm: &Spectrum,
    four_nm: &[f64; 4],
) -> [DVec4; 3] {
    let samples = training(medium, columns, four_nm);
    let xyz: Vec<DVec3> = samples.iter().map(|sample| sample.xyz(light_w_m2_nm)).collect();
    fit(&samples, &xyz.iter().map(|xyz| xyz.y).collect::<Vec<_>>(), |i| xyz[i].to_array())
}

/// The fifth row beside them: scotopic luminance, what rods see, in cd m⁻² (or lx), fitted to the same samples.
///
/// Skies within 0.8 %, the median 0.1 %; illuminant A +2.6 %, D65 −0.5 % by `earth`'s rows: see tests/truth.
pub fn fit_scotopic_from_four(
    medium: &Medium,
    columns: &Columns,
    light_w_m2_nm: &Spectrum,
    four_nm: &[f64; 4],
) -> DVec4 {
    let samples = training(medium, columns, four_nm);
    let scotopic: Vec<f64> = samples.iter().map(|sample| sample.scotopic(light_w_m2_nm)).collect();
    let [row] = fit(&samples, &scotopic, |i| [scotopic[i]]);
    row
}

/// The skies and beams that rows are fitted to.
fn training(medium: &Medium, columns: &Columns, four_nm: &[f64; 4]) -> Vec<Sample> {
    let mut samples = vec![Sample { fine: [1.0; 48], four: [1.0; 4] }];
    samples.extend([90.0, 30.0, 10.0, 4.0, 1.5].map(|sun_deg| beam_sample(medium, columns, four_nm, sun_deg)));
    samples.extend(skies(medium, columns, four_nm, &training_rays(medium)));
    samples
}

/// Rows that give `wanted` from four values, each sample weighted by one over its `scale`.
fn fit<const N: usize>(samples: &[Sample], scale: &[f64], wanted: impl Fn(usize) -> [f64; N]) -> [DVec4; N] {
    let mut normal = DMat4::ZERO;
    let mut right = [DVec4::ZERO; N];
    for (i, sample) in samples.iter().enumerate() {
        // Skies without light (no air, or a Sun too deep) say nothing about colour.
        if !(scale[i].is_finite() && scale[i] > 1e-12) {
            continue;
        }
        let four = DVec4::from_array(sample.four) / scale[i];
        normal += DMat4::from_cols(four * four.x, four * four.y, four * four.z, four * four.w);
        for (row, value) in right.iter_mut().zip(wanted(i)) {
            *row += four * (value / scale[i]);
        }
    }
    // A trace of regularisation: a medium of one constant colour leaves the four wavelengths undetermined.
    let size = (normal.x_axis.x + normal.y_axis.y + normal.z_axis.z + normal.w_axis.w) / 4.0;
    let inverse = (normal + DMat4::from_diagonal(DVec4::splat(1e-9 * size))).inverse();
    right.map(|row| inverse * row)
}

/// Linear-Rec.709-from-XYZ applied to such a matrix: rows R, G, B.
pub fn rec709_rows(xyz_rows: &[DVec4; 3]) -> [DVec4; 3] {
    let matrix: DMat3 = rec709_from_xyz();
    [0, 1, 2].map(|row| (0..3).fold(DVec4::ZERO, |sum, i| sum + xyz_rows[i] * matrix.col(i)[row]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Preset, sun};
    use himmel_core::colour::{D65_XY, delta_e_2000, lab_from_xyz};

    /// Single-scattering skies of `earth` at geometries that the fit has not seen, against their full spectrum:
    /// median ΔE2000 ≤ 1 and worst ≤ 3, the aim of atmosphere.md §2. Brightest point of each sky at Y = 100.
    #[test]
    fn four_wavelengths_reproduce_the_full_spectrum() {
        let preset = Preset::named("earth").unwrap();
        let columns = Columns::new(&preset.medium);
        let four_nm = [630.0, 560.0, 490.0, 430.0];
        let light = sun::irradiance_w_m2_nm();
        let rows = fit_xyz_from_four(&preset.medium, &columns, light, &four_nm);
        let white = DVec3::new(D65_XY.0 / D65_XY.1, 1.0, (1.0 - D65_XY.0 - D65_XY.1) / D65_XY.1) * 100.0;
        let mut differences = Vec::new();
        for sun_deg in [60.0, 20.0, 3.0, 0.0, -4.0] {
            let mut skies = Vec::new();
            for view_deg in [0.0, 30.0, 60.0, 80.0, 88.0] {
                for azimuth_deg in [30.0, 60.0, 120.0, 150.0] {
                    let sample = sky_sample(&preset.medium, &columns, &four_nm, sun_deg, view_deg, azimuth_deg);
                    let four = DVec4::from_array(sample.four);
                    skies.push((sample.xyz(light), DVec3::from_array(rows.map(|row| row.dot(four)))));
                }
            }
            let brightest = skies.iter().map(|sky| sky.0.y).fold(0.0, f64::max);
            differences.extend(skies.iter().map(|(full, ours)| {
                let scale = 100.0 / brightest;
                delta_e_2000(lab_from_xyz(*full * scale, white), lab_from_xyz(*ours * scale, white))
            }));
        }
        differences.sort_by(f64::total_cmp);
        let (median, worst) = (differences[differences.len() / 2], differences[differences.len() - 1]);
        println!("ΔE2000 of four wavelengths against the full spectrum: median {median:.2}, worst {worst:.2}");
        assert!(median <= 1.0 && worst <= 3.0, "median {median} worst {worst}");
    }
}
