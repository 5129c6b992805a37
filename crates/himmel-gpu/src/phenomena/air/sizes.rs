//! How finely the air is computed: the quality table.

use himmel_air::AirQuality;
use himmel_air::moments::Quality;

/// Sizes of the air's tables and sums. What each costs and does to the picture is measured in `docs/air-on-the-gpu.md`.
#[derive(Clone, Debug, PartialEq)]
pub struct AirSizes {
    /// The moment table and the sums that fill it. `tolerance`, `max_orders`: when the orders end.
    pub moments: Quality,
    /// Altitudes of the densities. Too few: the horizon bands where the air is layered.
    pub densities: u32,
    /// Directions and altitudes of the optical depth. Too few: the colour of the low Sun steps.
    pub depth: [u32; 2],
    /// Azimuths (over half a circle) and elevations of the sky view's rays, between which it is interpolated; `None`:
    /// every pixel marches its own ray. Too few: soft twilight arch and horizon.
    pub sky_view: Option<[u32; 2]>,
    /// Elevations of the table that says where the cells of a ray lie.
    pub cell_rows: u32,
    /// Cells along a ray. Too few: deep twilight and haze.
    pub steps: u32,
    /// Froxels of the aerial perspective along each side; `None`: every pixel marches its own ray.
    pub froxels: Option<u32>,
}

impl AirSizes {
    /// The sizes of a quality.
    pub fn of(quality: AirQuality) -> Self {
        let recipe = Quality::default();
        let film = Self {
            moments: recipe.clone(),
            densities: 1024,
            depth: [256, 128],
            sky_view: None,
            cell_rows: 96,
            steps: 48,
            froxels: None,
        };
        match quality {
            AirQuality::Film => film,
            AirQuality::High => Self {
                densities: 512,
                depth: [128, 64],
                sky_view: Some([24, 72]),
                cell_rows: 48,
                steps: 24,
                froxels: Some(32),
                ..film
            },
            AirQuality::Medium => Self {
                moments: Quality { rows: 24, columns: 48, max_orders: 12, ..recipe },
                densities: 512,
                depth: [128, 64],
                sky_view: Some([20, 60]),
                cell_rows: 36,
                steps: 20,
                froxels: Some(32),
            },
            AirQuality::Low => Self {
                moments: Quality {
                    rows: 16,
                    columns: 32,
                    directions: [8, 6, 5],
                    deep_directions: [10, 8, 6],
                    fine_cells: 150,
                    lit_samples: 16,
                    max_orders: 5,
                    ..recipe
                },
                densities: 256,
                depth: [128, 64],
                sky_view: Some([16, 48]),
                cell_rows: 24,
                steps: 16,
                froxels: Some(24),
            },
        }
    }
}
