//! Bodies as a frame needs them.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::error::GpuError;
use crate::frame::MOST_LIGHTS;
use crate::output::tonemap::{srgb_decode, srgb_encode};
use crate::phenomena::air::uniform::MOST_BODIES;

/// Most bodies of a frame besides the one that the camera stands on or above.
pub const MOST_FAR_BODIES: usize = MOST_BODIES - 1;
/// Radii, m: of what is round by its own weight at least, ten Jupiters at most.
const RADII_M: std::ops::RangeInclusive<f64> = 1e3..=1e9;
/// A hundred times Neptune's distance: f32 squares it.
const FARTHEST_M: f64 = 5e14;
/// Largest width of a map: WebGPU guarantees textures of 8,192.
const WIDEST: u32 = 8192;

/// A sun as a body sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarLight {
    /// Unit vector from the body towards it, east-north-up of the observer.
    pub direction: DVec3,
    /// Irradiance at the body at the four wavelengths, relative to the preset's star at 1 au.
    pub irradiance: [f64; 4],
}

/// A planet or moon in the sky.
#[derive(Clone, Debug, PartialEq)]
pub struct FarBody {
    /// Its centre without refraction, metres east, north and up of the observer.
    pub centre_m: DVec3,
    /// Radius of its ground, m; with air, that of the air's preset.
    pub radius_m: f64,
    /// Rows of its frame from east-north-up: z to its north pole, x to longitude 0.
    pub body_from_enu: DMat3,
    /// Albedo of ground where the map is white, or of all ground, at the four wavelengths.
    pub albedo: [f64; 4],
    /// Where it is lighter and darker; `None`: even.
    pub map: Option<Arc<AlbedoMap>>,
    /// Which of [`set_far_airs`](crate::SkyRenderer::set_far_airs)' airs it has; `None`: no air.
    pub air: Option<usize>,
    /// What lights it; at most 4.
    pub lights: Vec<FarLight>,
}

impl FarBody {
    /// Even ground without air, lit by one sun.
    pub fn even(centre_m: DVec3, radius_m: f64, albedo: f64, light: FarLight) -> Self {
        Self {
            centre_m,
            radius_m,
            body_from_enu: DMat3::IDENTITY,
            albedo: [albedo; 4],
            map: None,
            air: None,
            lights: vec![light],
        }
    }

    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let wrong = |what: String| Err(GpuError::View(format!("a body in the sky {what}")));
        if !(self.centre_m.is_finite() && self.centre_m.length() <= FARTHEST_M) {
            return wrong(format!("must stand within {FARTHEST_M:e} m, got {} m", self.centre_m));
        }
        if !RADII_M.contains(&self.radius_m) {
            return wrong(format!(
                "has a radius in {:e}..={:e} m, got {}",
                RADII_M.start(),
                RADII_M.end(),
                self.radius_m
            ));
        }
        if self.centre_m.length() <= self.radius_m {
            return wrong(format!(
                "has the observer inside: its centre is {:.0} m away and its radius is {:.0} m",
                self.centre_m.length(),
                self.radius_m
            ));
        }
        let turn = self.body_from_enu;
        let skew = turn.transpose() * turn - DMat3::IDENTITY;
        if !skew.to_cols_array().iter().all(|value| value.abs() < 1e-3) {
            return wrong("has a body_from_enu that does more than rotate".into());
        }
        if !self.albedo.iter().all(|albedo| (0.0..=1e3).contains(albedo)) {
            return wrong(format!("has an albedo in 0..=1 (more with a dark map), got {:?}", self.albedo));
        }
        if self.lights.len() > MOST_LIGHTS {
            return wrong(format!("has at most {MOST_LIGHTS} suns, got {}", self.lights.len()));
        }
        let fits = |light: &FarLight| {
            light.direction.is_finite() && light.irradiance.iter().all(|value| value.is_finite() && *value >= 0.0)
        };
        if !self.lights.iter().all(fits) {
            return wrong("has suns whose directions and irradiances must be finite".into());
        }
        Ok(())
    }
}

/// Why a map cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "an albedo map is twice as wide as high, 2 × 1 to {WIDEST} pixels wide, got {width} × {height} with {texels} pixels"
)]
pub struct AlbedoMapError {
    width: u32,
    height: u32,
    texels: usize,
}

/// Albedo over longitude and latitude: longitude −180° on the left, north at the top. Red, green and blue are reflectances with
/// sRGB's transfer function, as pictures have them: what a white lamp would show.
#[derive(Clone, PartialEq)]
pub struct AlbedoMap {
    width: u32,
    height: u32,
    levels: Vec<Vec<[u8; 4]>>,
}

impl std::fmt::Debug for AlbedoMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "AlbedoMap of {} × {} texels", self.width, self.height)
    }
}

impl AlbedoMap {
    /// White everywhere.
    pub fn even() -> Self {
        Self { width: 2, height: 1, levels: vec![vec![[255; 4]; 2], vec![[255; 4]]] }
    }

    /// From rows of red, green, blue and anything, and the levels of half their size by means of four, of linear values.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Result<Self, AlbedoMapError> {
        let fits = (2..=WIDEST).contains(&width) && width == 2 * height;
        if !fits || texels.len() != width as usize * height as usize {
            return Err(AlbedoMapError { width, height, texels: texels.len() });
        }
        let linear: Vec<f32> = (0..=255u8).map(|code| decode(code) as f32).collect();
        let mut before: Vec<[f32; 3]> =
            texels.iter().map(|texel| [0, 1, 2].map(|k| linear[usize::from(texel[k])])).collect();
        let mut levels = vec![texels];
        let (mut w, mut h) = (width as usize, height as usize);
        while w > 1 {
            let (half_w, half_h) = ((w / 2).max(1), (h / 2).max(1));
            let at = |x: usize, y: usize| before[y.min(h - 1) * w + x.min(w - 1)];
            let mean = |x: usize, y: usize| {
                let four = [at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)];
                [0, 1, 2].map(|k| four.iter().map(|texel| texel[k]).sum::<f32>() / 4.0)
            };
            let smaller: Vec<[f32; 3]> =
                (0..half_h).flat_map(|y| (0..half_w).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
            levels.push(smaller.iter().map(|&[r, g, b]| [encode(r), encode(g), encode(b), 255]).collect());
            before = smaller;
            (w, h) = (half_w, half_h);
        }
        Ok(Self { width, height, levels })
    }

    /// Mean reflectance of the whole sphere: red, green, blue.
    pub fn mean(&self) -> [f64; 3] {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for (y, row) in self.levels[0].chunks_exact(self.width as usize).enumerate() {
            let area = ((y as f64 + 0.5) / f64::from(self.height) * std::f64::consts::PI).sin();
            for texel in row {
                for k in 0..3 {
                    sum[k] += area * decode(texel[k]);
                }
            }
            weight += area * f64::from(self.width);
        }
        sum.map(|value| value / weight)
    }

    /// Texels along a row and a column.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Texels by level, the finest first.
    pub fn levels(&self) -> &[Vec<[u8; 4]>] {
        &self.levels
    }

    /// Reflectance at four wavelengths of ground that is red, green or blue: it goes straight between the dominant wavelengths
    /// of Rec. 709's primaries (611, 549 and 464 nm), and stays as it is beyond.
    ///
    /// Laws tested: white is white; a wavelength of a primary sees that alone.
    pub fn four_from_rgb(wavelengths_nm: [f64; 4]) -> [[f64; 4]; 3] {
        let blue_to_green = |nm: f64| ((nm - 464.0) / (549.0 - 464.0)).clamp(0.0, 1.0);
        let green_to_red = |nm: f64| ((nm - 549.0) / (611.0 - 549.0)).clamp(0.0, 1.0);
        [
            wavelengths_nm.map(green_to_red),
            wavelengths_nm.map(|nm| blue_to_green(nm) - green_to_red(nm)),
            wavelengths_nm.map(|nm| 1.0 - blue_to_green(nm)),
        ]
    }
}

fn decode(code: u8) -> f64 {
    srgb_decode(DVec3::splat(f64::from(code) / 255.0)).x
}

fn encode(linear: f32) -> u8 {
    (srgb_encode(DVec3::splat(f64::from(linear))).x * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_and_primaries_stand_alone() {
        let [red, green, blue] = AlbedoMap::four_from_rgb([630.0, 549.0, 500.0, 430.0]);
        for k in 0..4 {
            assert!((red[k] + green[k] + blue[k] - 1.0).abs() < 1e-12);
        }
        assert_eq!((red[0], green[1], blue[3]), (1.0, 1.0, 1.0));
    }

    #[test]
    fn smaller_levels_keep_the_light() {
        let texels = (0..8 * 4).map(|i| if (i / 8 + i) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
        let map = AlbedoMap::new(8, 4, texels).unwrap();
        assert_eq!(map.levels().len(), 4);
        assert!(map.levels()[1..].iter().flatten().all(|texel| (decode(texel[0]) - 0.5).abs() < 0.005));
        assert!((map.mean()[1] - 0.5).abs() < 1e-12);
        assert!(AlbedoMap::new(3, 2, vec![[0; 4]; 6]).is_err() && AlbedoMap::new(4, 2, vec![[0; 4]; 7]).is_err());
    }

    #[test]
    fn bodies_without_meaning_are_refused() {
        let light = FarLight { direction: DVec3::X, irradiance: [1.0; 4] };
        let good = FarBody::even(DVec3::Y * 1e9, 1e6, 0.3, light);
        good.check().unwrap();
        for bad in [
            FarBody { radius_m: 0.0, ..good.clone() },
            FarBody { radius_m: 1e30, ..good.clone() },
            FarBody { radius_m: f64::NAN, ..good.clone() },
            FarBody { centre_m: DVec3::NAN, ..good.clone() },
            FarBody { centre_m: DVec3::Y * 1e5, ..good.clone() },
            FarBody { body_from_enu: DMat3::ZERO, ..good.clone() },
            FarBody { albedo: [f64::NAN; 4], ..good.clone() },
            FarBody { lights: vec![light; 5], ..good.clone() },
            FarBody { lights: vec![FarLight { irradiance: [-1.0; 4], ..light }], ..good.clone() },
        ] {
            let error = bad.check().unwrap_err().to_string();
            assert!(error.contains("a body in the sky"), "{error}");
        }
    }
}
