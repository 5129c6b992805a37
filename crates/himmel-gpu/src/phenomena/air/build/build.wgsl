// What the passes that fill the moment table share. Twins: himmel_air::moments, its files build.rs and rays.rs.
//
// Rays: for each row of the table the directions of the sums, first those for the day, then the finer ones for Suns deep
// below the horizon. All that a ray weighs is computed once and shared by all Suns, azimuths and orders.

//#include "phenomena/air/medium.wgsl"

struct BuildUniform {
    rows: u32,
    columns: u32,
    // Directions above and below the horizon, azimuths over half a circle.
    up: u32,
    down: u32,
    azimuths: u32,
    deep_up: u32,
    deep_down: u32,
    deep_azimuths: u32,
    // Cells of the march that prepares a ray; of a ray for orders ≥ 2; of its cumulative table.
    fine_cells: u32,
    cells: u32,
    cumulative_cells: u32,
    // Samples in the lit part of a ray, order 1.
    lit_samples: u32,
    body: u32,
    // The order that is computed, 1 …
    order: u32,
    // Rows of this dispatch.
    first_row: u32,
    row_count: u32,
    // The orders end when the last changed no G by more than this share.
    tolerance: f32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(1) @binding(0) var<uniform> build: BuildUniform;

// Vectors of a ray before its cells: (µ, sine, weight, end), through, (hits the ground, 0, 0, 0).
const HEAD: u32 = 3u;
// Vectors of a cell: three weights, (t, r, µ, row coordinate), columns of the moments there (see SUNS_ROW).
const CELL: u32 = 5u;
// Vectors of a texel: six moments and the irradiance from above.
const SEVEN: u32 = 7u;

fn rays_per_row() -> u32 {
    return build.up + build.down + build.deep_up + build.deep_down;
}

fn ray_base(row: u32, ray: u32) -> u32 {
    return (row * rays_per_row() + ray) * (HEAD + CELL * build.cells);
}

// Cumulative tables exist for the rows of a dispatch only.
fn cumulative_base(row: u32, ray: u32) -> u32 {
    return ((row - build.first_row) * rays_per_row() + ray) * (build.cumulative_cells + 1u) * 4u;
}

// Altitude of a row: the last stands just under the top, so that it sees air.
fn row_altitude(row: u32) -> f32 {
    let v = f32(row) / f32(build.rows - 1u);
    return airs[body].top_altitude_m * min(v * v, 0.9999);
}

// Zenith cosine of a column of the moment table at an altitude.
fn column_mu_s(column: u32, suns: vec4f) -> f32 {
    let u = f32(column) / f32(build.columns - 1u);
    let a = suns.z + u / suns.w;
    // sinh by its definition: the built-in loses its small values on some drivers.
    let x = SUNS_CENTRE + SUNS_WIDTH * 0.5 * (exp(a) - exp(-a));
    return sin(clamp(x - suns.x, -0.5 * PI, 0.5 * PI));
}
