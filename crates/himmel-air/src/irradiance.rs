//! Light that falls on a level surface: directly from the Sun and from the sky.

use std::f64::consts::PI;

use himmel_core::quadrature::gauss_legendre_unit;

use crate::columns::Columns;
use crate::medium::Sampled;
use crate::single::{Ray, march};

/// Directions over which the sky is summed.
#[derive(Clone, Copy, Debug)]
pub struct Directions {
    /// Gauss–Legendre nodes in the zenith cosine.
    pub zenith: usize,
    /// Azimuths over half a circle (the sky is symmetric about the Sun).
    pub azimuth: usize,
    /// Samples along each ray.
    pub steps: usize,
}

impl Directions {
    /// For one answer: within 1 % of four times as many, for every preset with its Sun above −6°.
    pub const FINE: Self = Self { zenith: 32, azimuth: 24, steps: 48 };
    /// For the renderer's table of the lit ground.
    pub const TABLE: Self = Self { zenith: 12, azimuth: 8, steps: 16 };
}

/// Irradiance from the sky (sunlight scattered once) on a level surface, per unit irradiance of the Sun above the air.
pub fn sky_irradiance<const N: usize>(
    air: &Sampled<'_, N>,
    columns: &Columns,
    altitude_m: f64,
    mu_s: f64,
    directions: Directions,
) -> [f64; N] {
    let sin_s = (1.0 - mu_s * mu_s).max(0.0).sqrt();
    let mut sum = [0.0; N];
    for (x, w) in gauss_legendre_unit(directions.zenith) {
        // µ = x²: the horizon is where the sky changes fastest.
        let (mu, d_mu) = (x * x, 2.0 * x * w);
        let sin = (1.0 - mu * mu).sqrt();
        for j in 0..directions.azimuth {
            let azimuth = PI * (j as f64 + 0.5) / directions.azimuth as f64;
            let nu = (mu * mu_s + sin * sin_s * azimuth.cos()).clamp(-1.0, 1.0);
            let sky = march(air, columns, &Ray { altitude_m, mu, mu_s, nu }, directions.steps);
            let weight = mu * d_mu * 2.0 * PI / directions.azimuth as f64;
            for k in 0..N {
                sum[k] += weight * sky.radiance_per_sr[k];
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    #[test]
    fn fine_directions_have_converged() {
        let more = Directions { zenith: 64, azimuth: 96, steps: 96 };
        for name in ["earth", "mars-reference"] {
            let preset = Preset::named(name).unwrap();
            let columns = Columns::new(&preset.medium);
            let air = preset.medium.sampled(&[550.0]);
            for elevation_deg in [50.0f64, 10.0, 1.0, -3.0, -6.0] {
                let mu_s = elevation_deg.to_radians().sin();
                let fine = sky_irradiance(&air, &columns, 0.0, mu_s, Directions::FINE)[0];
                let finer = sky_irradiance(&air, &columns, 0.0, mu_s, more)[0];
                assert!((fine / finer - 1.0).abs() < 0.01, "{name} {elevation_deg}°: {fine} {finer}");
            }
        }
    }

    /// A sky that only scatters can at most return what it takes from the beam.
    #[test]
    fn sky_and_beam_do_not_exceed_what_arrives() {
        let preset = Preset::named("bruneton2017").unwrap();
        let columns = Columns::new(&preset.medium);
        let air = preset.medium.sampled(&[440.0]);
        for elevation_deg in [90.0f64, 40.0, 15.0] {
            let mu_s = elevation_deg.to_radians().sin();
            let beam = (-columns.optical_depth(&air, 0.0, mu_s)[0]).exp() * mu_s;
            let sky = sky_irradiance(&air, &columns, 0.0, mu_s, Directions::FINE)[0];
            assert!(sky > 0.0 && beam + sky < mu_s, "{elevation_deg}: {beam} + {sky}");
        }
    }
}
