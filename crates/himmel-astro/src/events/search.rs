//! Zeros and minima of functions of time that may fail.

use crate::error::Result;

/// Julian dates are settled to this, 0.1 ms; f64 cannot tell much less apart.
const TOLERANCE_DAYS: f64 = 1.2e-9;

/// The zero of `f` between `a` and `b`, where its signs differ (`fa`, `fb`): Illinois' false position with bisection in reserve.
pub(super) fn zero(mut f: impl FnMut(f64) -> Result<f64>, a: f64, fa: f64, b: f64, fb: f64) -> Result<f64> {
    let (mut a, mut fa, mut b, mut fb) = (a, fa, b, fb);
    let mut side = 0;
    for step in 0..100 {
        if (b - a).abs() <= TOLERANCE_DAYS || fa == fb {
            break;
        }
        let secant = (fa * b - fb * a) / (fa - fb);
        let inside = secant > a.min(b) && secant < a.max(b);
        let c = if inside && step % 4 != 3 { secant } else { 0.5 * (a + b) };
        let fc = f(c)?;
        if fc == 0.0 {
            return Ok(c);
        }
        if (fc > 0.0) == (fb > 0.0) {
            if side == -1 {
                fa *= 0.5;
            }
            (b, fb, side) = (c, fc, -1);
        } else {
            if side == 1 {
                fb *= 0.5;
            }
            (a, fa, side) = (c, fc, 1);
        }
        // Both ends close in only by bisection; a short last step of the secant is enough.
        if (secant - c).abs() <= f64::EPSILON && fc.abs() < 1e-13 {
            return Ok(c);
        }
    }
    Ok(0.5 * (a + b))
}

/// The minimum of `f` between `a` and `b` by golden section, to a relative √ε: its argument to about 1e-8 of the bracket.
pub(super) fn minimum(mut f: impl FnMut(f64) -> Result<f64>, a: f64, b: f64, tolerance: f64) -> Result<(f64, f64)> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let (mut a, mut b) = (a, b);
    let mut x1 = b - GOLDEN * (b - a);
    let mut x2 = a + GOLDEN * (b - a);
    let (mut f1, mut f2) = (f(x1)?, f(x2)?);
    while b - a > tolerance {
        if f1 < f2 {
            (b, x2, f2) = (x2, x1, f1);
            x1 = b - GOLDEN * (b - a);
            f1 = f(x1)?;
        } else {
            (a, x1, f1) = (x1, x2, f2);
            x2 = a + GOLDEN * (b - a);
            f2 = f(x2)?;
        }
    }
    Ok(if f1 < f2 { (x1, f1) } else { (x2, f2) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_and_minima_of_known_functions() {
        let z = zero(|x| Ok(x.powi(3) - 2.0), 0.0, -2.0, 3.0, 25.0).unwrap();
        assert!((z - 2f64.cbrt()).abs() < 1e-8, "{z}");
        let (x, f) = minimum(|x| Ok((x - 0.7).powi(2) + 1.0), -1.0, 2.0, 1e-6).unwrap();
        assert!((x - 0.7).abs() < 1e-6 && (f - 1.0).abs() < 1e-10);
    }
}
