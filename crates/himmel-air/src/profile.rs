//! Density profiles: how much of a component there is at an altitude, relative to a reference.

use himmel_core::interpolate;
use himmel_core::quadrature::gauss_legendre_unit;

/// A density profile over altitude in metres. Dimensionless: it multiplies a component's coefficients.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// `exp(−h / H)`, 1 on the ground.
    Exponential {
        /// Scale height H, m.
        scale_height_m: f64,
    },
    /// `exp(−½ ((h − centre) / width)²)`, 1 at its centre.
    Gaussian {
        /// Altitude of the maximum, m.
        centre_m: f64,
        /// Standard deviation, m.
        width_m: f64,
    },
    /// Linear from 0 at the bottom to 1 at the peak to 0 at the top.
    Tent {
        /// Where it begins, m.
        bottom_m: f64,
        /// Where it is 1, m.
        peak_m: f64,
        /// Where it ends, m.
        top_m: f64,
    },
    /// Piecewise linear; the end values hold below the first node, 0 holds above the last.
    Table {
        /// Ascending altitudes, m.
        altitude_m: Vec<f64>,
        /// The profile there.
        value: Vec<f64>,
    },
    /// As a table, with the logarithm linear between the nodes: what gases do. 0 above the last node.
    LogTable {
        /// Ascending altitudes, m.
        altitude_m: Vec<f64>,
        /// The profile there, positive.
        value: Vec<f64>,
    },
    /// `Σ weight · profile`: several exponentials, layers on a base.
    Sum(Vec<(f64, Profile)>),
    /// Thesis B's base and layers, each of which replaces the base where it is:
    /// b + Σ (v_i − b) exp(−½ ((h − h_i)/S_i)²), b = exp(−h/H), never below 0   [klupiec2024, eq. 15].
    Layered {
        /// Scale height H of the base, m.
        scale_height_m: f64,
        /// Altitude h_i (m), standard deviation S_i (m) and value v_i of each layer, relative to the base on the ground.
        layers: Vec<[f64; 3]>,
    },
}

impl Profile {
    /// The profile at an altitude in metres. Never negative.
    pub fn at(&self, altitude_m: f64) -> f64 {
        match self {
            Self::Exponential { scale_height_m } => (-altitude_m / scale_height_m).exp(),
            Self::Gaussian { centre_m, width_m } => (-0.5 * ((altitude_m - centre_m) / width_m).powi(2)).exp(),
            Self::Tent { bottom_m, peak_m, top_m } => {
                let rising = (altitude_m - bottom_m) / (peak_m - bottom_m);
                let falling = (top_m - altitude_m) / (top_m - peak_m);
                rising.min(falling).clamp(0.0, 1.0)
            }
            Self::Table { altitude_m: nodes, value } => {
                if nodes.last().is_some_and(|&top| altitude_m > top) {
                    0.0
                } else {
                    interpolate::linear(nodes, value, altitude_m)
                }
            }
            Self::LogTable { altitude_m: nodes, value } => {
                if value.is_empty() || value.len() != nodes.len() || nodes.last().is_some_and(|&top| altitude_m > top) {
                    return 0.0;
                }
                let (i, t) = interpolate::locate(nodes, altitude_m);
                let (a, b) = (value[i], value[(i + 1).min(value.len() - 1)]);
                a * (b / a).powf(t)
            }
            Self::Sum(parts) => parts.iter().map(|(weight, part)| weight * part.at(altitude_m)).sum::<f64>().max(0.0),
            Self::Layered { scale_height_m, layers } => {
                let base = (-altitude_m / scale_height_m).exp();
                let corrections = layers.iter().map(|[centre, width, value]| {
                    (value - base) * (-0.5 * ((altitude_m - centre) / width).powi(2)).exp()
                });
                (base + corrections.sum::<f64>()).max(0.0)
            }
        }
    }

    /// The vertical column from `from_m` to `to_m`: ∫ profile dh, in metres.
    pub fn column_m(&self, from_m: f64, to_m: f64) -> f64 {
        let mut cuts = vec![from_m, to_m];
        match self {
            Self::Exponential { scale_height_m } => {
                return scale_height_m * ((-from_m / scale_height_m).exp() - (-to_m / scale_height_m).exp());
            }
            Self::Gaussian { centre_m, width_m } => cuts.extend((-6..=6).map(|i| centre_m + f64::from(i) * width_m)),
            Self::Tent { bottom_m, peak_m, top_m } => cuts.extend([*bottom_m, *peak_m, *top_m]),
            Self::Table { altitude_m, .. } | Self::LogTable { altitude_m, .. } => cuts.extend(altitude_m),
            Self::Sum(parts) => return parts.iter().map(|(weight, part)| weight * part.column_m(from_m, to_m)).sum(),
            Self::Layered { scale_height_m, layers } => {
                cuts.extend((0..=60).map(|i| from_m + f64::from(i) * scale_height_m));
                cuts.extend(
                    layers
                        .iter()
                        .flat_map(|[centre, width, _]| (-12..=12).map(move |i| centre + 0.5 * f64::from(i) * width)),
                );
            }
        }
        cuts.retain(|cut| (from_m..=to_m).contains(cut));
        cuts.sort_by(f64::total_cmp);
        let rule = gauss_legendre_unit(8);
        cuts.windows(2)
            .map(|cut| {
                let length = cut[1] - cut[0];
                // The nodes lie inside, so a jump at a table's end does no harm.
                length * rule.iter().map(|(x, w)| w * self.at(cut[0] + x * length)).sum::<f64>()
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_the_closed_integrals() {
        let exponential = Profile::Exponential { scale_height_m: 8000.0 };
        assert!((exponential.column_m(0.0, 1e6) - 8000.0).abs() < 1e-6);
        let gaussian = Profile::Gaussian { centre_m: 20e3, width_m: 2e3 };
        assert!((gaussian.column_m(0.0, 1e5) / (2e3 * (2.0 * std::f64::consts::PI).sqrt()) - 1.0).abs() < 1e-8);
        let tent = Profile::Tent { bottom_m: 10e3, peak_m: 25e3, top_m: 40e3 };
        assert!((tent.column_m(0.0, 60e3) - 15e3).abs() < 1e-6);
        let table = Profile::Table { altitude_m: vec![0.0, 10e3], value: vec![1.0, 0.0] };
        assert!((table.column_m(0.0, 60e3) - 5e3).abs() < 1e-6);
        assert_eq!(table.at(10_001.0), 0.0);
    }

    #[test]
    fn compound_profiles_are_what_they_are_made_of() {
        let exponential = Profile::Exponential { scale_height_m: 8000.0 };
        let altitude_m: Vec<f64> = (0..=40).map(|i| 2500.0 * f64::from(i)).collect();
        let value = altitude_m.iter().map(|&h| exponential.at(h)).collect();
        let table = Profile::LogTable { altitude_m, value };
        assert!((table.at(3333.0) / exponential.at(3333.0) - 1.0).abs() < 1e-12);
        assert!((table.column_m(0.0, 1e5) / exponential.column_m(0.0, 1e5) - 1.0).abs() < 1e-9);
        let layer = Profile::Gaussian { centre_m: 20e3, width_m: 2e3 };
        let sum = Profile::Sum(vec![(2.0, exponential.clone()), (0.5, layer.clone())]);
        assert_eq!(sum.at(20e3), 2.0 * exponential.at(20e3) + 0.5);
        assert_eq!(sum.column_m(0.0, 1e5), 2.0 * exponential.column_m(0.0, 1e5) + 0.5 * layer.column_m(0.0, 1e5));
        // Thesis B: at the layer's altitude the concentration is the layer's.
        let layered = Profile::Layered { scale_height_m: 8000.0, layers: vec![[20e3, 1e3, 0.4]] };
        assert!((layered.at(20e3) - 0.4).abs() < 1e-12 && (layered.at(0.0) - 1.0).abs() < 1e-12);
        let expected = {
            let n = 200_000;
            (0..n).map(|i| layered.at((f64::from(i) + 0.5) * 1e5 / f64::from(n)) * 1e5 / f64::from(n)).sum::<f64>()
        };
        assert!((layered.column_m(0.0, 1e5) / expected - 1.0).abs() < 1e-6);
    }
}
