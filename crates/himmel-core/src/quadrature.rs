//! Gauss–Legendre quadrature.

use std::f64::consts::PI;

/// Nodes and weights of the `n`-point Gauss–Legendre rule on 0..1, exact for polynomials up to
/// degree 2n − 1 (Newton's iteration on the Legendre polynomial [press2007, §4.6]).
pub fn gauss_legendre_unit(n: usize) -> Vec<(f64, f64)> {
    let mut rule = Vec::with_capacity(n);
    for i in 0..n {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut derivative = 1.0;
        for _ in 0..100 {
            let (mut p, mut p_before) = (1.0, 0.0);
            for j in 0..n {
                let p_new = ((2 * j + 1) as f64 * x * p - j as f64 * p_before) / (j + 1) as f64;
                (p_before, p) = (p, p_new);
            }
            derivative = n as f64 * (x * p - p_before) / (x * x - 1.0);
            let step = p / derivative;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        rule.push(((1.0 - x) / 2.0, 1.0 / ((1.0 - x * x) * derivative * derivative)));
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_polynomials_exactly() {
        for n in 1..24 {
            let rule = gauss_legendre_unit(n);
            for degree in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (degree as f64 + 1.0)).abs() < 1e-13, "n {n} degree {degree}");
            }
        }
    }
}
