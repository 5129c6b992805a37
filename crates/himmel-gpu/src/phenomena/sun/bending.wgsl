// How the air lifts what is seen: twins of himmel_air::refraction::Bending, same names, order and units.

// Twin of the Rust struct `BendingUniform`: 32 deviations at the nodes, rad, four to a vector.
struct BendingUniform {
    deviation: array<vec4f, 8>,
    // Deviation at each wavelength over that of the table.
    ratio: vec4f,
    // The lowest elevation that clears the ground, rad.
    lowest: f32,
    // How fast the nodes spread from there, rad.
    width: f32,
    // asinh((π/2 − lowest)/width).
    span: f32,
    padding: f32,
}

const BENDING_BELOW: f32 = 0.02;

fn bending_node(bending: BendingUniform, index: i32) -> f32 {
    let i = clamp(index, 0, 31);
    return bending.deviation[i / 4][i % 4];
}

// Apparent minus true elevation at an apparent elevation, and how it changes with it.
fn bent_deviation(bending: BendingUniform, apparent: f32) -> vec2f {
    let above = clamp(apparent - bending.lowest, -BENDING_BELOW, 1.57079633 - bending.lowest);
    let scaled = abs(above) / bending.width;
    let x = sign(above) * log(scaled + sqrt(scaled * scaled + 1.0)) / bending.span * 31.0;
    let per_rad = 31.0 / (bending.span * sqrt(above * above + bending.width * bending.width));
    let i = clamp(i32(floor(x)), 0, 30);
    let here = bending_node(bending, i);
    let next = bending_node(bending, i + 1);
    let rise = next - here;
    let low = select(0.5 * (next - bending_node(bending, i - 1)), rise, i == 0);
    let high = select(0.5 * (bending_node(bending, i + 2) - here), rise, i == 30);
    let t = x - f32(i);
    if t < 0.0 {
        return vec2f(here + low * t, low * per_rad);
    }
    let a = 3.0 * rise - 2.0 * low - high;
    let b = low + high - 2.0 * rise;
    return vec2f(here + t * (low + t * (a + t * b)), (low + t * (2.0 * a + t * 3.0 * b)) * per_rad);
}
