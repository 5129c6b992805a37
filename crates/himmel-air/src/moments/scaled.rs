//! What extended things keep on their way through the air: the transmittance T′ of the medium without its forward peaks.

use crate::columns::Columns;
use crate::medium::Sampled;

use super::optics::Optics;

/// Extinction of each component less what it scatters into its forward peak, m⁻¹ where its profile is 1.
#[derive(Clone, Debug)]
pub struct Scaled {
    extinction_per_m: Vec<[f64; 4]>,
}

impl Scaled {
    /// Of a medium.
    pub fn new(air: &Sampled<'_, 4>) -> Self {
        // Four moments tell the peak.
        let extinction =
            |s: &super::optics::Scatterer<4>| std::array::from_fn(|k| s.extinction_per_m[k] - s.peak_per_m[k]);
        Self { extinction_per_m: Optics::new(air, 4).scatterers.iter().map(extinction).collect() }
    }

    /// From an altitude within the air to space. Directions below the horizon are taken as the horizon: the caller decides.
    pub fn transmittance(&self, columns: &Columns, altitude_m: f64, mu: f64) -> [f64; 4] {
        let mut depth = [0.0; 4];
        columns.for_each_column(altitude_m, mu, |component, column_m| {
            if let Some(extinction) = self.extinction_per_m.get(component) {
                for k in 0..4 {
                    depth[k] += column_m * extinction[k];
                }
            }
        });
        depth.map(|depth| (-depth).exp())
    }
}
