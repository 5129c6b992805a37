//! Interpolation in tables.

/// Linear interpolation between `a` (at 0) and `b` (at 1). Exact at both ends.
pub fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// Where `x` falls in the ascending `nodes`: index of the lower node and the fraction 0..=1 to the
/// next one. Clamps outside; `nodes` must hold at least one value.
pub fn locate(nodes: &[f64], x: f64) -> (usize, f64) {
    let last = nodes.len().saturating_sub(1);
    if last == 0 || x.is_nan() || x <= nodes[0] {
        return (0, 0.0);
    }
    if x >= nodes[last] {
        return (last - 1, 1.0);
    }
    // Most tables are even: a guess saves the search.
    let guess = ((x - nodes[0]) / (nodes[last] - nodes[0]) * last as f64) as usize;
    let upper = match nodes.get(guess..guess.saturating_add(2)) {
        Some([a, b]) if *a <= x && x < *b => guess + 1,
        _ => nodes.partition_point(|&node| node <= x).clamp(1, last),
    };
    let (a, b) = (nodes[upper - 1], nodes[upper]);
    (upper - 1, if b > a { (x - a) / (b - a) } else { 0.0 })
}

/// Piecewise linear interpolation of `values` over ascending `nodes`, clamped at the ends.
/// Empty tables give 0.
pub fn linear(nodes: &[f64], values: &[f64], x: f64) -> f64 {
    if nodes.is_empty() || values.len() != nodes.len() {
        return 0.0;
    }
    let (i, t) = locate(nodes, x);
    lerp(values[i], values[(i + 1).min(values.len() - 1)], t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_and_uneven_tables_are_found_in() {
        for nodes in [vec![0.0, 1.0, 2.0, 3.0, 4.0], vec![-1e3, 0.0, 0.0, 1e-3, 7.0, 8.0]] {
            for i in 0..1000 {
                let x = nodes[0] + (nodes[nodes.len() - 1] - nodes[0]) * (f64::from(i) + 0.5) / 1000.0;
                let (k, t) = locate(&nodes, x);
                assert!(nodes[k] <= x && x < nodes[k + 1] && (lerp(nodes[k], nodes[k + 1], t) - x).abs() < 1e-9, "{x}");
            }
        }
        assert_eq!(locate(&[0.0, 1.0, 1.0, 2.0], 1.0), (2, 0.0));
    }

    #[test]
    fn linear_is_exact_at_nodes_and_clamps() {
        let (x, y) = ([1.0, 2.0, 4.0], [10.0, 20.0, 0.0]);
        for i in 0..3 {
            assert_eq!(linear(&x, &y, x[i]), y[i]);
        }
        assert_eq!(linear(&x, &y, 3.0), 10.0);
        assert_eq!(linear(&x, &y, -1e30), 10.0);
        assert_eq!(linear(&x, &y, f64::INFINITY), 0.0);
        assert_eq!(linear(&x, &y, f64::NAN), 10.0);
        assert_eq!(linear(&[], &[], 1.0), 0.0);
        assert_eq!(linear(&[3.0], &[7.0], 9.0), 7.0);
    }
}
