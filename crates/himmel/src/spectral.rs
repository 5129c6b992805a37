//! The reference: a scene's picture by the Monte Carlo tracer, without a GPU, over the whole visible spectrum.

mod disc;
mod state;
mod wavelengths;

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use himmel_air::reference::{Source, Tracer, for_each_parallel};
use himmel_air::sun::limb_darkening;
use himmel_core::colour::rec709_from_xyz;
use himmel_gpu::output::dither::hash_unit;
use himmel_gpu::output::{display_rgb, metered_factor};
use himmel_gpu::{Exposure, GpuError, MAX_PIXELS, MAX_SIDE, Output, OutputParams, PassTimes, Picture, Pixels, View};

use crate::error::Result;
use crate::model::SkyModel;
use state::{Head, Sums};
pub use wavelengths::{WAVELENGTHS, wavelengths_nm, xyz_weights};

/// Paths of each pass through each pixel: the light of the first order, without noise, costs as much as some thirty.
pub const PATHS_PER_PASS: u32 = 32;

/// Pixels that a thread takes at once.
const CHUNK: usize = 64;
/// Steps of the R2 sequence: the inverses of the plastic number and of its square [roberts2018].
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
/// Pixels darker than this share of the mean do not count for the noise: the black of space beside a lit planet.
const DARK_SHARE: f64 = 1e-3;

/// A picture that converges: each pass adds a ray through each pixel, its light of the first order, and
/// [`PATHS_PER_PASS`] paths for the others, all of them at [`WAVELENGTHS`] wavelengths.
///
/// ```
/// use himmel::{Output, ReferencePicture, Scene, SkyModel};
/// let mut scene = Scene::default();
/// for (key, value) in [("light.sun.altitude_deg", "40"), ("output.width_px", "8"), ("output.height_px", "4")] {
///     scene.set(key, value)?;
/// }
/// let mut reference = ReferencePicture::new(&SkyModel::new(&scene)?, 1)?;
/// for _ in 0..4 {
///     reference.add_pass(&mut |_| true)?;
/// }
/// let picture = reference.picture(&scene.output, Output::Radiance);
/// assert_eq!((picture.width, reference.passes()), (8, 4));
/// # Ok::<(), himmel::Error>(())
/// ```
pub struct ReferencePicture {
    tracer: Tracer<WAVELENGTHS>,
    /// The star as the air sees it; per unit irradiance.
    sun: Source<WAVELENGTHS>,
    /// XYZ of a radiance of 1 per unit irradiance at each wavelength: cd m⁻².
    weights: [DVec3; WAVELENGTHS],
    view: View,
    altitude_m: f64,
    size: (u32, u32),
    seed: u64,
    fingerprint: u64,
    /// What the star's disc adds to pixels that it touches, XYZ in cd m⁻².
    disc: Vec<(usize, DVec3)>,
    /// Direction in which the disc is seen.
    disc_direction: DVec3,
    sums: Vec<Sums>,
    passes: u64,
}

/// Standard errors of luminance relative to it, over the pixels that are not black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Half of the pixels are better.
    pub median: f64,
    /// 95 % of the pixels are better.
    pub percentile_95: f64,
}

impl ReferencePicture {
    /// Prepares a model's picture: its camera, size, air, ground and star (the first of the preset). `seed` of the random
    /// numbers: the same one gives the same picture, whatever the machine's threads.
    ///
    /// Errors: a camera that does not fit, a size out of bounds, a medium that the tracer refuses.
    pub fn new(model: &SkyModel, seed: u64) -> Result<Self> {
        let (view, frame) = (model.view()?, model.frame()?);
        let (width, height) = (frame.output.width_px, frame.output.height_px);
        let count = u64::from(width) * u64::from(height);
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE || count > MAX_PIXELS {
            return Err(GpuError::Size { width, height, max: MAX_SIDE, max_pixels: MAX_PIXELS }.into());
        }
        let nodes = wavelengths_nm();
        let medium = model.atmosphere().medium();
        let light = model.preset().light_at_1_au_w_m2_nm();
        let weights = xyz_weights(&light).map(|weight| weight * frame.sun.irradiance[0]);
        let tracer = Tracer::new(&medium.sampled(&nodes))?.weighted(weights.map(|weight| weight.y));
        let limb = frame.sun.limb_darkening.then(|| nodes.map(limb_darkening));
        let sun = Source {
            direction: frame.sun.direction.normalize_or(DVec3::Z),
            radius_rad: frame.sun.radius_rad,
            irradiance: [1.0; WAVELENGTHS],
            limb,
        };
        let altitude_m = frame.altitude_m.max(0.5);
        // Everything that decides the samples, to the last bit: f64 prints as the shortest text that reads back the same.
        let decides = format!(
            "{} {medium:?} {light:?} {:?} {view:?} {altitude_m:?} {width} {height} {nodes:?} {PATHS_PER_PASS} {seed}",
            env!("CARGO_PKG_VERSION"),
            frame.sun
        );
        let mut sums = Vec::new();
        sums.try_reserve_exact(count as usize)
            .map_err(|_| GpuError::Device(format!("not enough memory for {width}x{height} pixels")))?;
        sums.resize(count as usize, [0.0; 4]);
        let mut reference = Self {
            tracer,
            sun,
            weights,
            view,
            altitude_m,
            size: (width, height),
            seed,
            fingerprint: state::hash(decides.as_bytes()),
            disc: Vec::new(),
            disc_direction: frame.sun.disc_direction.normalize_or(DVec3::Z),
            sums,
            passes: 0,
        };
        // A first question finds what the tracer refuses.
        reference.tracer.sample(std::slice::from_ref(&reference.sun), altitude_m, DVec3::Z, 0, [seed, 0, 0])?;
        if frame.sun.disc {
            reference.disc = reference.draw_disc()?;
        }
        Ok(reference)
    }

    /// The place of a point of a pixel in the picture; `x`, `y` from its top left corner, 0..=1.
    fn ndc(&self, index: usize, x: f64, y: f64) -> [f64; 2] {
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let (column, row) = ((index % width) as f64, (index / width) as f64);
        [2.0 * (column + x) / width as f64 - 1.0, 1.0 - 2.0 * (row + y) / height as f64]
    }

    /// Whether a pixel's centre is in the picture; the corners of a fisheye are not.
    fn inside(&self, index: usize) -> bool {
        self.view.direction(self.ndc(index, 0.5, 0.5)).is_some()
    }

    fn xyz(&self, radiance_per_sr: &[f64; WAVELENGTHS]) -> DVec3 {
        self.weights.iter().zip(radiance_per_sr).map(|(weight, radiance)| *weight * *radiance).sum()
    }

    /// XYZ of one sample of a pixel, cd m⁻², without the star's disc.
    fn sample(&self, index: usize, number: u64) -> Result<DVec3> {
        // Where in the pixel: the R2 sequence from a start of each pixel's own [roberts2018].
        let start = hash_unit([index as u32, (index as u64 >> 32) as u32 ^ self.seed as u32, 7]);
        let shift = |axis: usize| (start[axis] + R2[axis] * number as f64).fract();
        let at = self.ndc(index, shift(0), shift(1));
        let Some(direction) = self.view.direction(at) else { return Ok(DVec3::ZERO) };
        let stream = [self.seed, index as u64, number];
        let sources = std::slice::from_ref(&self.sun);
        let radiance = self.tracer.sample(sources, self.altitude_m, direction.normalize(), PATHS_PER_PASS, stream)?;
        Ok(self.xyz(&radiance))
    }

    /// Adds a pass on all threads. `progress` is told the share of it that is done and answers whether to go on; if not,
    /// what was done of this pass is dropped, and the answer is false.
    pub fn add_pass(&mut self, progress: &mut dyn FnMut(f64) -> bool) -> Result<bool> {
        let count = self.sums.len();
        let chunks = count.div_ceil(CHUNK);
        let range = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
        let work = |chunk: usize| range(chunk).map(|index| self.sample(index, self.passes)).collect::<Result<Vec<_>>>();
        let mut samples = vec![Vec::new(); chunks];
        let (mut done, mut failure) = (0, None);
        let all = for_each_parallel(chunks, work, |chunk, result| {
            done += 1;
            match result {
                Ok(values) => samples[chunk] = values,
                Err(error) => failure = Some(error),
            }
            failure.is_none() && progress(done as f64 / chunks as f64)
        });
        if let Some(error) = failure {
            return Err(error);
        }
        if !all {
            return Ok(false);
        }
        for (sum, xyz) in self.sums.iter_mut().zip(samples.iter().flatten()) {
            for (sum, value) in sum.iter_mut().zip([xyz.x, xyz.y, xyz.z, xyz.y * xyz.y]) {
                *sum += value;
            }
        }
        self.passes += 1;
        Ok(true)
    }

    /// Passes that are in the picture.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Paths of each pixel so far.
    pub fn paths_per_pixel(&self) -> u64 {
        self.passes * u64::from(PATHS_PER_PASS)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Linear Rec. 709 of every pixel in cd m⁻², top row first: air, ground and the star's disc.
    pub fn rgb_cd_m2(&self) -> Vec<DVec3> {
        let rec709: DMat3 = rec709_from_xyz();
        let passes = self.passes.max(1) as f64;
        let mut pixels: Vec<DVec3> = self.sums.iter().map(|sum| DVec3::new(sum[0], sum[1], sum[2]) / passes).collect();
        for (index, xyz) in &self.disc {
            pixels[*index] += *xyz;
        }
        pixels.into_iter().map(|xyz| rec709 * xyz).collect()
    }

    /// Standard error of each pixel's luminance in cd m⁻², from the scatter of the passes; NaN before the second.
    pub fn error_cd_m2(&self) -> Vec<f64> {
        self.sums.iter().map(|sum| standard_error(sum, self.passes)).collect()
    }

    /// How noisy the picture is; `None` before the second pass, or where all of it is black.
    pub fn noise(&self) -> Option<Noise> {
        let n = self.passes as f64;
        let mean = self.sums.iter().map(|sum| sum[1]).sum::<f64>() / self.sums.len() as f64;
        if self.passes < 2 || mean.is_nan() || mean <= 0.0 {
            return None;
        }
        let bright = self.sums.iter().filter(|sum| sum[1] > DARK_SHARE * mean);
        let mut errors: Vec<f64> = bright.map(|sum| standard_error(sum, self.passes) * n / sum[1]).collect();
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors.get((share * errors.len() as f64) as usize).copied();
        Some(Noise { median: at(0.5)?, percentile_95: at(0.95)? })
    }

    /// The picture so far. Exposure, tone mapper and dithering come from `output`; a metered exposure is that of the whole
    /// picture's pixels, by the renderer's rule.
    pub fn picture(&self, output: &OutputParams, kind: Output) -> Picture {
        let rgb = self.rgb_cd_m2();
        let colour = |index: usize| self.inside(index).then(|| rgb[index]);
        let factor = match output.exposure_for(kind) {
            Exposure::Auto => metered_factor(output, (0..rgb.len()).map(colour)),
            chosen => chosen.factor().unwrap_or(1.0),
        };
        let exposure = factor * output.compensation_ev.exp2();
        let width = self.size.0 as usize;
        let pixels = match kind {
            Output::Radiance => Pixels::Radiance(
                rgb.iter().flat_map(|colour| (*colour * exposure).to_array().map(|value| value as f32)).collect(),
            ),
            Output::Display => Pixels::Display(
                rgb.iter()
                    .enumerate()
                    .flat_map(|(index, colour)| {
                        // Nothing is drawn outside a fisheye, not even noise.
                        let pixel = [(index % width) as u32, (index / width) as u32];
                        if self.inside(index) {
                            display_rgb(output, *colour * exposure, exposure, pixel)
                        } else {
                            [0; 3]
                        }
                    })
                    .collect(),
            ),
        };
        let ev100 = -(exposure * 1.2).log2();
        Picture { width: self.size.0, height: self.size.1, pixels, exposure, ev100, times: PassTimes::default() }
    }

    /// Illuminance of a level surface at the observer, lx: by the star and by the sky, all orders. `rays`: samples of the
    /// sky, of [`PATHS_PER_PASS`] paths each; 128 know it within some per cent.
    pub fn illuminance_lx(&self, rays: u32) -> Result<(f64, f64)> {
        let seen = [Source { direction: self.disc_direction, ..self.sun.clone() }];
        let direct = self.tracer.direct_irradiance(&seen, self.altitude_m, DVec3::Z)?;
        let sources = std::slice::from_ref(&self.sun);
        let sample = |i: usize| {
            // Directions by their cosine, so that each stands for π / rays [roberts2018].
            let [x, y] = R2.map(|step| (0.5 + step * (i + 1) as f64).fract());
            let (sine, (sin, cos)) = (x.sqrt(), (TAU * y).sin_cos());
            let direction = DVec3::new(sine * cos, sine * sin, (1.0 - x).sqrt()).normalize();
            let stream = [self.seed, u64::MAX, i as u64];
            Ok(self.xyz(&self.tracer.sample(sources, self.altitude_m, direction, PATHS_PER_PASS, stream)?).y)
        };
        let mut each = vec![0.0; rays as usize];
        let mut failure = Ok(());
        for_each_parallel(each.len(), sample, |i, result: Result<f64>| {
            match result {
                Ok(luminance) => each[i] = luminance,
                Err(error) => failure = Err(error),
            }
            failure.is_ok()
        });
        failure?;
        Ok((self.xyz(&direct).y, each.iter().sum::<f64>() * std::f64::consts::PI / f64::from(rays.max(1))))
    }

    /// Illuminance of a surface that faces the star, by it alone, lx.
    pub fn sun_illuminance_lx(&self) -> Result<f64> {
        let seen = [Source { direction: self.disc_direction, ..self.sun.clone() }];
        Ok(self.xyz(&self.tracer.direct_irradiance(&seen, self.altitude_m, self.disc_direction)?).y)
    }

    /// The samples so far, for [`resume`](Self::resume): 32 bytes for each pixel.
    pub fn state(&self) -> Vec<u8> {
        state::write(&Head { fingerprint: self.fingerprint, passes: self.passes }, &self.sums)
    }

    /// Takes the samples of a [`state`](Self::state) instead of its own. Going on from them gives the same picture as never
    /// having stopped. Exposure and tone mapping may have changed meanwhile.
    ///
    /// Errors (and changes nothing): bytes that are cut off or damaged, of another version, or of a picture that anything
    /// else differs in.
    pub fn resume(&mut self, state: &[u8]) -> Result<()> {
        (self.passes, self.sums) = state::read(state, self.fingerprint, self.sums.len())?;
        Ok(())
    }
}

/// Standard error of the mean of `n` values from their sum and the sum of their squares.
fn standard_error(sum: &Sums, passes: u64) -> f64 {
    let n = passes as f64;
    let mean = sum[1] / n;
    ((sum[3] / n - mean * mean).max(0.0) / (n - 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use himmel_air::reference::Effort;

    fn reference(settings: &[(&str, &str)]) -> ReferencePicture {
        let mut scene = Scene::default();
        scene.set("clock.time", "2012-09-06T12:00Z").unwrap();
        for (key, value) in settings {
            scene.set(key, value).unwrap();
        }
        ReferencePicture::new(&SkyModel::new(&scene).unwrap(), 1).unwrap()
    }

    /// A clear noon: one pixel of a degree, away from the Sun, against the tracer's own answer in its middle. 2 %: four errors
    /// of 8,192 paths each.
    #[test]
    fn a_pixel_is_what_the_tracer_answers() {
        let mut reference = reference(&[
            ("light.sun.altitude_deg", "60"),
            ("light.sun.azimuth_deg", "180"),
            ("camera.look", "0,40"),
            ("camera.fov_deg", "1"),
            ("output.width_px", "2"),
            ("output.height_px", "2"),
        ]);
        for _ in 0..64 {
            assert!(reference.add_pass(&mut |_| true).unwrap());
        }
        let direction = reference.view.direction([0.0, 0.0]).unwrap();
        let effort = Effort { samples: 8192, seed: 9, ..Effort::default() };
        let sources = std::slice::from_ref(&reference.sun);
        let answer = reference.tracer.radiance(sources, reference.altitude_m, direction, &effort, 0).unwrap();
        let expected = rec709_from_xyz() * reference.xyz(&answer.value);
        let mean = reference.rgb_cd_m2().into_iter().sum::<DVec3>() / 4.0;
        println!("{mean} for {expected} cd/m², noise {:?}", reference.noise());
        assert!(((mean - expected) / expected).abs().max_element() < 0.02, "{mean} {expected}");
        // A clear blue sky, 40° up, opposite to the Sun.
        assert!((1500.0..6000.0).contains(&mean.y) && mean.z > mean.x, "{mean}");
        // The scatter of the pixels is what the errors say: the mean of four within 5 of their errors.
        let error = reference.error_cd_m2().iter().map(|error| error * error).sum::<f64>().sqrt() / 4.0;
        let own = reference.xyz(&answer.standard_error).y;
        assert!((mean.y - expected.y).abs() < 5.0 * error.hypot(own) + 0.003 * expected.y, "{error} {own}");
    }

    /// The disc's pixels hold the Sun's illuminance, whether it fills the picture or a part of a pixel; and half a disc on
    /// the horizon holds a part of it.
    #[test]
    fn the_disc_keeps_its_light() {
        for (fov_deg, side) in [("1", "24"), ("5", "21"), ("90", "9")] {
            let reference = reference(&[
                ("light.sun.altitude_deg", "40"),
                ("camera.look", "sun"),
                ("camera.fov_deg", fov_deg),
                ("output.width_px", side),
                ("output.height_px", side),
            ]);
            let half = (0.5 * fov_deg.parse::<f64>().unwrap()).to_radians().tan();
            let side: f64 = side.parse().unwrap();
            // Solid angle of a pixel near the axis.
            let solid_angle = (2.0 * half / side).powi(2);
            let lux: f64 = reference.disc.iter().map(|(_, xyz)| xyz.y * solid_angle).sum();
            let expected = reference.sun_illuminance_lx().unwrap();
            println!("{fov_deg}°: {lux} of {expected} lx in {} pixels", reference.disc.len());
            assert!((lux / expected - 1.0).abs() < 0.02, "{fov_deg}°: {lux} {expected}");
        }
        let none = reference(&[("light.sun.disc", "off"), ("light.sun.altitude_deg", "40"), ("camera.look", "sun")]);
        assert!(none.disc.is_empty());
    }

    /// Threads, interruptions and resumption change nothing; exposure may change, the scene may not.
    #[test]
    fn samples_go_on_where_they_stopped() {
        let settings = [
            ("light.sun.altitude_deg", "10"),
            ("output.width_px", "9"),
            ("output.height_px", "5"),
            ("air.molecules", "0.5"),
        ];
        let mut whole = reference(&settings);
        for _ in 0..3 {
            whole.add_pass(&mut |_| true).unwrap();
        }
        let mut part = reference(&settings);
        part.add_pass(&mut |_| true).unwrap();
        assert!(!part.add_pass(&mut |_| false).unwrap(), "a pass that is stopped does not count");
        assert!(part.noise().is_none() && part.passes() == 1);
        let mut again = reference(&[&settings[..], &[("output.exposure", "12")]].concat());
        again.resume(&part.state()).unwrap();
        again.add_pass(&mut |_| true).unwrap();
        again.add_pass(&mut |_| true).unwrap();
        assert!(again.state() == whole.state() && again.rgb_cd_m2() == whole.rgb_cd_m2());
        let mut other = reference(&[&settings[..], &[("ground.albedo", "0.9")]].concat());
        assert!(other.resume(&part.state()).is_err() && other.passes() == 0);
    }

    /// No air, no light at all, above everything: finite pictures.
    #[test]
    fn odd_scenes_are_finite() {
        for settings in [
            &[("air.enabled", "off"), ("light.sun.altitude_deg", "20")][..],
            &[("light.sun.altitude_deg", "-80")],
            &[("observer.altitude_m", "1e8"), ("camera.look", "nadir"), ("camera.fov_deg", "10")],
            &[("light.sun.brightness", "0")],
            &[("camera.projection", "fisheye"), ("camera.fov_deg", "360"), ("light.sun.altitude_deg", "20")],
        ] {
            let size = [("output.width_px", "4"), ("output.height_px", "3")];
            let mut reference = reference(&[&size[..], settings].concat());
            reference.add_pass(&mut |_| true).unwrap();
            reference.add_pass(&mut |_| true).unwrap();
            assert!(reference.rgb_cd_m2().iter().all(|rgb| rgb.is_finite()), "{settings:?}");
            let picture = reference.picture(&OutputParams::default(), Output::Display);
            assert!(picture.exposure.is_finite() && picture.exposure > 0.0, "{settings:?}");
        }
    }
}
