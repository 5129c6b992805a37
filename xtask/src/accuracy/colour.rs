//! Colour methods against the full spectrum, with all orders of scattering: ΔE2000.
//!
//! The tracer carries the spectrum and the four wavelengths along the same paths, so that their noise is one noise.

use std::fmt::Write as _;

use glam::{DVec3, DVec4};
use himmel_air::colour::{SPECTRAL_NM, Sample, fit_xyz_from_four};
use himmel_air::reference::{Effort, Source, Tracer, for_each_parallel};
use himmel_air::sharp::{Prefilter, xyz_adapted_to_d65};
use himmel_air::{Columns, Preset};
use himmel_core::colour::{D65_XY, Observer, bradford, delta_e_2000, lab_from_xyz, xyz_of_chromaticity};

use super::{Work, quantile, view};

const FOUR_NM: [f64; 4] = [630.0, 560.0, 490.0, 430.0];
/// The fine spectrum and the four, carried together.
const TOGETHER: usize = 52;

pub fn table(work: Work) -> Result<String, String> {
    let mut text = String::from(
        "| preset | four wavelengths, fitted matrix | thesis B's sharp channels | Sun of the worst |\n|---|---|---|---|\n",
    );
    let white = xyz_of_chromaticity(D65_XY);
    for name in ["earth", "earth-haze", "mars", "m-dwarf-ocean"] {
        let preset = Preset::named(name).map_err(|error| error.to_string())?;
        let light = preset.light_at_1_au_w_m2_nm();
        let columns = Columns::new(&preset.medium);
        let rows = fit_xyz_from_four(&preset.medium, &columns, &light, &FOUR_NM);
        let wavelengths: [f64; TOGETHER] =
            std::array::from_fn(|k| if k < 48 { SPECTRAL_NM[k] } else { FOUR_NM[k - 48] });
        let efficacy = wavelengths.map(|nm| (Observer::cie1931().at(nm).y + 0.05) * light.at(nm));
        let spectral =
            Tracer::new(&preset.medium.sampled(&wavelengths)).map_err(|error| error.to_string())?.weighted(efficacy);
        let prefilter = Prefilter::new(&light);
        let channels = Tracer::new(&prefilter.sampled(&preset.medium)).map_err(|error| error.to_string())?;
        let own_white = Observer::cie1931().xyz_of(|nm| light.at(nm));
        let adapt = bradford(own_white / own_white.y, white);
        let (mut by_four, mut by_sharp, mut worst) = (Vec::new(), Vec::new(), (0.0, 0.0));
        for sun_deg in [60.0f64, 20.0, 5.0, 0.0, -4.0, -6.0] {
            let zenith_rad = (90.0 - sun_deg).to_radians();
            let directions: Vec<DVec3> = [1.0, 25.0, 50.0, 70.0, 85.0]
                .into_iter()
                .flat_map(|zenith| [20.0, 60.0, 100.0, 140.0, 180.0].map(|azimuth| view(zenith, azimuth)))
                .collect();
            let effort = Effort { samples: work.count(16_384).max(1024), ..Effort::default() };
            // Channels have a noise of their own: more paths.
            let more = Effort { samples: 8 * effort.samples, ..effort };
            let mut skies = Vec::new();
            for_each_parallel(
                directions.len(),
                |i| {
                    let question = i as u64;
                    let full = spectral.radiance(
                        &[Source::at_zenith_angle(zenith_rad)],
                        0.0,
                        directions[i],
                        &effort,
                        question,
                    );
                    let sharp =
                        channels.radiance(&[Source::at_zenith_angle(zenith_rad)], 0.0, directions[i], &more, question);
                    full.and_then(|full| sharp.map(|sharp| (full.value, sharp.value)))
                },
                |_, answer| {
                    if let Ok((full, sharp)) = answer {
                        let sample = Sample {
                            fine: std::array::from_fn(|k| full[k]),
                            four: std::array::from_fn(|k| full[48 + k]),
                        };
                        let four = DVec4::from_array(sample.four);
                        let ours = DVec3::from_array(rows.map(|row| row.dot(four)));
                        let sharp = xyz_adapted_to_d65(DVec3::from_array(sharp)) * own_white.y;
                        skies.push((adapt * sample.xyz(&light), adapt * ours, sharp));
                    }
                    true
                },
            );
            let scale = 1.0 / skies.iter().map(|sky| sky.0.y).fold(1e-30, f64::max);
            let lab = |xyz: DVec3| lab_from_xyz(xyz * scale, white);
            for sky in &skies {
                let difference = delta_e_2000(lab(sky.0), lab(sky.1));
                if difference > worst.0 {
                    worst = (difference, sun_deg);
                }
                by_four.push(difference);
                by_sharp.push(delta_e_2000(lab(sky.0), lab(sky.2)));
            }
        }
        let both = |values: &mut Vec<f64>| format!("{:.2} / {:.2}", quantile(values, 0.5), quantile(values, 1.0));
        let _ = writeln!(text, "| `{name}` | {} | {} | {}° |", both(&mut by_four), both(&mut by_sharp), worst.1);
        eprintln!("{}", text.lines().last().unwrap_or_default());
    }
    text.push_str(
        "\nΔE2000, median / worst of 150 views: Sun at 60, 20, 5, 0, −4, −6°, 25 directions each, all orders of scattering; adapted to \
         D65 (Bradford, or the sharp channels' own), the sky's brightest point at Y = 100.\n",
    );
    Ok(text)
}
