//! Twin of `dither.wgsl`: noise that hides the steps of an 8-bit picture.

/// Numbers 0..1 from a pixel and a channel: the PCG hash in three dimensions [jarzynski2020].
pub fn hash_unit(pixel: [u32; 3]) -> [f64; 3] {
    let [mut x, mut y, mut z] = pixel.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        if round == 0 {
            (x, y, z) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16));
        }
    }
    [x, y, z].map(|v| f64::from(v >> 8) / 16_777_216.0)
}

/// Triangular noise of ±1 step for a pixel's three channels.
pub fn triangular_noise(pixel: [u32; 2]) -> [f64; 3] {
    let (a, b) = (hash_unit([pixel[0], pixel[1], 0]), hash_unit([pixel[0], pixel[1], 1]));
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_triangular() {
        let (mut sum, mut squares, n) = (0.0, 0.0, 256 * 256);
        for y in 0..256 {
            for x in 0..256 {
                let value = triangular_noise([x, y])[1];
                assert!(value.abs() < 1.0);
                sum += value;
                squares += value * value;
            }
        }
        // Mean 0, variance 1/6; the error of the mean over 65,536 samples is 0.0016.
        assert!((sum / f64::from(n)).abs() < 0.006 && (squares / f64::from(n) - 1.0 / 6.0).abs() < 0.005);
    }
}
