//! How finely the moments are computed.

/// Sizes of the moment table and of the sums that fill it. The default is the measured recipe of `moment-tables.md`.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Rows of the table, over altitude. Too few: the sky from an aeroplane is a little too bright or dark; 24 are
    /// nearly as good as 32.
    pub rows: usize,
    /// Columns, over the Sun. Too few: twilight fades in steps; 48 are nearly as good as 64.
    pub columns: usize,
    /// Directions of the sums by day: above the horizon, below it, azimuths over half a circle.
    pub directions: [usize; 3],
    /// The same for Suns more than 8° under the level, when only an arch of the sky is lit. Too few: deep
    /// twilight is uneven.
    pub deep_directions: [usize; 3],
    /// Cells of the march that prepares a ray.
    pub fine_cells: usize,
    /// Cells of a ray for the orders ≥ 2. Too few: haze is too dark near the ground.
    pub cells: usize,
    /// Cells of the cumulative table of a ray, for the first order.
    pub cumulative_cells: usize,
    /// Samples in the lit part of a ray, first order. Too few: deep twilight is off by tens of percent.
    pub lit_samples: usize,
    /// No more orders of scattering than this; 0: the table stays empty, [`radiance`] gives the first order alone.
    /// Clear air needs 6, haze and Mars 8, `titan-reference` 19, `titan` 66 (with 30,
    /// parts of its sky are off by 20 to 27 %). What runs into the limit keeps a geometric tail, and
    /// [`Moments::last_change`] says so.
    ///
    /// [`Moments::last_change`]: super::Moments::last_change
    /// [`radiance`]: super::radiance
    pub max_orders: usize,
    /// The orders end when the last changed no G, tail included, by more than this share (deep twilight counts less).
    pub tolerance: f64,
    /// Legendre moments of the aerosols' phase functions. Too few: see [`Moments::peak_remainder`]. More than 256
    /// exceed what [`Phase::legendre_moments`] resolves.
    ///
    /// [`Moments::peak_remainder`]: super::Moments::peak_remainder
    /// [`Phase::legendre_moments`]: crate::Phase::legendre_moments
    pub legendre_terms: usize,
    /// Scattering angles in the tables of the forward peak, crowded towards the Sun.
    pub peak_angles: usize,
    /// Optical depths in them.
    pub peak_depths: usize,
    /// Rounds what the tables store to half floats, as the GPU does.
    pub half_floats: bool,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            rows: 32,
            columns: 64,
            directions: [12, 8, 6],
            deep_directions: [16, 12, 8],
            fine_cells: 300,
            cells: 16,
            cumulative_cells: 128,
            lit_samples: 24,
            max_orders: 80,
            tolerance: 1e-3,
            legendre_terms: 192,
            peak_angles: 128,
            peak_depths: 32,
            half_floats: false,
        }
    }
}

impl Quality {
    /// The least that makes sense, and not more than memory holds.
    pub fn sane(&self) -> Self {
        let directions = |d: [usize; 3]| [d[0].clamp(2, 256), d[1].clamp(2, 256), d[2].clamp(1, 256)];
        Self {
            rows: self.rows.clamp(2, 1024),
            columns: self.columns.clamp(2, 4096),
            directions: directions(self.directions),
            deep_directions: directions(self.deep_directions),
            fine_cells: self.fine_cells.clamp(8, 100_000),
            cells: self.cells.clamp(1, 4096),
            cumulative_cells: self.cumulative_cells.clamp(1, 4096),
            lit_samples: self.lit_samples.clamp(2, 4096),
            max_orders: self.max_orders.min(1000),
            legendre_terms: self.legendre_terms.clamp(4, 1024),
            peak_angles: self.peak_angles.clamp(2, 4096),
            peak_depths: self.peak_depths.clamp(2, 1024),
            tolerance: if self.tolerance.is_finite() { self.tolerance } else { 0.0 },
            half_floats: self.half_floats,
        }
    }
}
