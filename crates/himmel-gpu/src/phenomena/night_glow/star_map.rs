//! A cube map of light from beyond the Solar System, on the CPU: what is uploaded, and the f64 twin of the sampler.

use glam::{DVec3, Vec3};

/// Brightness of code 0 and of code 255 of a map's picture, S10; codes between them are logarithmic.
pub const CODES_S10: [f32; 2] = [3.0, 4000.0];

/// Largest side of a face: 2,048 is 134 MB of texture.
const MOST_SIDE: u32 = 2048;

/// Why a map cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "a star map is a picture of 3 × 2 square faces with a side of 8, 16 … {MOST_SIDE} pixels, got {width} × {height} with {bytes} bytes"
)]
pub struct StarMapError {
    width: u32,
    height: u32,
    bytes: usize,
}

/// Six faces in WebGPU's order (+x −x +y −y +z −z of ICRS axes), linear Rec. 709 whose luminance is in S10.
///
/// Texels share an exponent (as in `Rgb9e5Ufloat`: 0.2 % of the brightest channel), each level averages four texels of the one before.
#[derive(Clone, PartialEq)]
pub struct StarMap {
    side: u32,
    /// By level, then face after face.
    levels: Vec<Vec<u32>>,
    mean: DVec3,
}

impl std::fmt::Debug for StarMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "StarMap of 6 × {0} × {0} texels", self.side)
    }
}

impl StarMap {
    /// From a picture of 8-bit RGB: faces 0 to 2 side by side above 3 to 5, each channel a logarithmic code of [`CODES_S10`].
    pub fn from_codes(width: u32, height: u32, rgb: &[u8]) -> Result<Self, StarMapError> {
        let side = width / 3;
        let error = StarMapError { width, height, bytes: rgb.len() };
        let fits = side.is_power_of_two() && (8..=MOST_SIDE).contains(&side) && width == 3 * side && height == 2 * side;
        if !fits || rgb.len() != 3 * width as usize * height as usize {
            return Err(error);
        }
        let [least, most] = CODES_S10;
        let decode: [f32; 256] = std::array::from_fn(|code| least * (most / least).powf(code as f32 / 255.0));
        let n = side as usize;
        let mut texels = Vec::with_capacity(6 * n * n);
        for face in 0..6 {
            for y in 0..n {
                let row = 3 * ((face / 3 * n + y) * width as usize + face % 3 * n);
                texels.extend(
                    rgb[row..row + 3 * n]
                        .chunks_exact(3)
                        .map(|code| Vec3::from_array(std::array::from_fn(|k| decode[usize::from(code[k])]))),
                );
            }
        }
        Ok(Self::from_texels(side, texels))
    }

    fn from_texels(side: u32, mut texels: Vec<Vec3>) -> Self {
        let mut levels = vec![packed(&texels)];
        let mut n = side as usize;
        while n > 1 {
            let half = n / 2;
            let mut smaller = Vec::with_capacity(6 * half * half);
            for face in 0..6 {
                for y in 0..half {
                    let row = (face * n + 2 * y) * n;
                    for x in 0..half {
                        let at = row + 2 * x;
                        smaller.push(0.25 * (texels[at] + texels[at + 1] + texels[at + n] + texels[at + n + 1]));
                    }
                }
            }
            levels.push(packed(&smaller));
            (texels, n) = (smaller, half);
        }
        let mean = texels.iter().map(|texel| texel.as_dvec3()).sum::<DVec3>() / 6.0;
        Self { side, levels, mean }
    }

    /// Texels along a face.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Packed texels of each level, face after face.
    pub fn levels(&self) -> &[Vec<u32>] {
        &self.levels
    }

    /// Mean over the faces' texels, S10.
    pub fn mean_s10(&self) -> DVec3 {
        self.mean
    }

    /// Linear Rec. 709 in S10 from a direction (ICRS), bilinear within its face. `level`: 0 is the finest.
    ///
    /// Twin of `starlight` in `night_glow.wgsl`.
    pub fn sample_s10(&self, direction: DVec3, level: usize) -> DVec3 {
        let level = level.min(self.levels.len() - 1);
        let n = (self.side as usize >> level).max(1);
        let (face, u, v) = face_of(direction);
        let place = |c: f64| (0.5 * (c + 1.0) * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
        let (x, y) = (place(u), place(v));
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(n - 1), (y0 + 1).min(n - 1));
        let (fx, fy) = (x - x0 as f64, y - y0 as f64);
        let at = |x: usize, y: usize| unpacked(self.levels[level][(face * n + y) * n + x]);
        (at(x0, y0) * (1.0 - fx) + at(x1, y0) * fx) * (1.0 - fy) + (at(x0, y1) * (1.0 - fx) + at(x1, y1) * fx) * fy
    }
}

/// Face and place on it, −1..=1 to the right and down, as WebGPU's cube textures have it
fn face_of(d: DVec3) -> (usize, f64, f64) {
    let d = if d.is_finite() { d } else { DVec3::X };
    let a = d.abs();
    let (face, major, u, v) = if a.x >= a.y && a.x >= a.z {
        if d.x >= 0.0 { (0, a.x, -d.z, -d.y) } else { (1, a.x, d.z, -d.y) }
    } else if a.y >= a.z {
        if d.y >= 0.0 { (2, a.y, d.x, d.z) } else { (3, a.y, d.x, -d.z) }
    } else if d.z >= 0.0 {
        (4, a.z, d.x, -d.y)
    } else {
        (5, a.z, -d.x, -d.y)
    };
    let major = major.max(f64::MIN_POSITIVE);
    (face, u / major, v / major)
}

fn packed(texels: &[Vec3]) -> Vec<u32> {
    texels.iter().map(|texel| pack(*texel)).collect()
}

/// Three values of nine bits with a common exponent of five (bias 15).
fn pack(rgb: Vec3) -> u32 {
    let rgb = rgb.clamp(Vec3::ZERO, Vec3::splat(65_408.0));
    let largest = rgb.max_element();
    // The exponent that gives the largest its nine bits; one more where rounding would overflow them.
    let mut exponent = ((largest.to_bits() >> 23) as i32 - 127).max(-16) + 1;
    let scale = |exponent: i32| f32::from_bits(((136 - exponent) as u32) << 23);
    if (largest * scale(exponent)).round() > 511.0 {
        exponent += 1;
    }
    let [r, g, b] = (rgb * scale(exponent)).round().to_array().map(|value| value as u32);
    ((exponent + 15) as u32) << 27 | b << 18 | g << 9 | r
}

fn unpacked(texel: u32) -> DVec3 {
    let scale = 2f64.powi((texel >> 27) as i32 - 24);
    DVec3::new(f64::from(texel & 511), f64::from(texel >> 9 & 511), f64::from(texel >> 18 & 511)) * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_keep_a_half_per_cent() {
        for i in 0..4000 {
            let value = 1e-3 * 1.004f32.powi(i);
            let texel = Vec3::new(value, 0.7 * value, 0.3 * value);
            let back = unpacked(pack(texel));
            assert!((back - texel.as_dvec3()).abs().max_element() < 2.1e-3 * f64::from(value), "{texel} {back}");
        }
        assert_eq!(unpacked(pack(Vec3::ZERO)), DVec3::ZERO);
        assert!(unpacked(pack(Vec3::splat(1e9))).x > 65_000.0);
    }

    #[test]
    fn faces_are_where_webgpu_has_them() {
        for (face, direction) in
            [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].into_iter().enumerate()
        {
            assert_eq!(face_of(direction), (face, 0.0, 0.0)); // −0 equals 0
        }
        assert_eq!(face_of(DVec3::new(1.0, 0.5, 0.25)), (0, -0.25, -0.5));
        assert_eq!(face_of(DVec3::new(-0.25, -0.5, -1.0)), (5, 0.25, 0.5));
    }

    #[test]
    fn a_map_is_read_and_averaged() {
        let mut rgb = vec![0u8; 24 * 16 * 3];
        rgb[..3].fill(255);
        let map = StarMap::from_codes(24, 16, &rgb).unwrap();
        assert_eq!((map.side(), map.levels().len()), (8, 4));
        let corner = map.sample_s10(DVec3::new(1.0, 1.0 - 1.0 / 8.0, 1.0 - 1.0 / 8.0), 0);
        assert!((corner.x / 4000.0 - 1.0).abs() < 0.003, "{corner}");
        assert!((map.mean_s10().x - (3.0 + 3997.0 / 384.0)).abs() < 0.1, "{}", map.mean_s10());
        assert!(map.sample_s10(DVec3::NAN, 99).is_finite());
    }

    #[test]
    fn other_pictures_are_no_maps() {
        for (width, height, bytes) in [(0, 0, 0), (24, 16, 7), (24, 24, 1728), (30, 20, 1800), (3, 2, 18)] {
            let error = StarMap::from_codes(width, height, &vec![0; bytes]).unwrap_err().to_string();
            assert!(error.contains("3 × 2 square faces"), "{error}");
        }
    }
}
