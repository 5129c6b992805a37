//! The first order without chance: sunlight scattered once, or reflected once by the ground, by quadrature.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;
use himmel_core::quadrature::gauss_legendre_unit;

use super::line::{Line, cylinder_m, in_shadow, tidy};
use super::optics::Optics;
use super::source::Source;

/// Nodes in a cell of a line of sight.
const NODES: usize = 6;
/// Step of a line of sight and of a line to the light, in square roots of the air's shortest scale.
const STEP: f64 = 0.7;
const LIGHT_STEP: f64 = 1.2;
/// Cells of more optical depth than this are split.
const THICK: f64 = 1.0;
/// Beyond this optical depth nothing is seen: e⁻⁴⁵ is 3e-20.
const OPAQUE: f64 = 45.0;

/// Nodes, weights, and integrals from 0 to each node of the polynomials through the nodes.
struct Rule {
    nodes: Vec<(f64, f64)>,
    until: [[f64; NODES]; NODES],
}

fn rule() -> &'static Rule {
    static RULE: OnceLock<Rule> = OnceLock::new();
    RULE.get_or_init(|| {
        let nodes = gauss_legendre_unit(NODES);
        let mut until = [[0.0; NODES]; NODES];
        for (i, row) in until.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                for (x, w) in &nodes {
                    let at = x * nodes[i].0;
                    let others = nodes.iter().enumerate().filter(|(m, _)| *m != j);
                    let lagrange: f64 = others.map(|(_, (other, _))| (at - other) / (nodes[j].0 - other)).product();
                    *value += w * nodes[i].0 * lagrange;
                }
            }
        }
        Rule { nodes, until }
    })
}

/// Memory that is used again and again.
#[derive(Default)]
pub(super) struct Scratch {
    pub edges: Vec<f64>,
    pub light_edges: Vec<f64>,
    pub densities: Vec<f64>,
    node_densities: Vec<f64>,
    light_columns_m: Vec<f64>,
}

impl Scratch {
    pub fn new<const N: usize>(optics: &Optics<N>) -> Self {
        let zeros = vec![0.0; optics.components.len()];
        Self {
            densities: zeros.clone(),
            light_columns_m: zeros.clone(),
            node_densities: vec![0.0; zeros.len() * NODES],
            ..Self::default()
        }
    }
}

/// Nodes of a line to a light.
pub(super) fn light_rule() -> &'static [(f64, f64)] {
    static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    RULE.get_or_init(|| gauss_legendre_unit(5))
}

/// Transmittance from a point to space along a direction; 0 where the planet is in the way.
pub(super) fn transmittance_to<const N: usize>(
    optics: &Optics<N>,
    point: DVec3,
    direction: DVec3,
    scratch: &mut Scratch,
) -> [f64; N] {
    if in_shadow(optics, point, direction) {
        return [0.0; N];
    }
    let line = Line::new(optics, point, direction);
    line.cut(optics, LIGHT_STEP, &mut scratch.light_edges);
    scratch.light_columns_m.fill(0.0);
    line.columns(optics, &scratch.light_edges, light_rule(), &mut scratch.densities, &mut scratch.light_columns_m);
    optics.depth(&scratch.light_columns_m).map(|depth| (-depth).exp())
}

/// What a line of sight shows of order 1.
pub(super) struct First<const N: usize> {
    /// Radiance in the sources' unit per sr.
    pub radiance: [f64; N],
    /// Transmittance to the line's end.
    pub transmittance: [f64; N],
}

/// Sunlight scattered once along a line, and reflected once where the line ends on the ground.
///
/// Every edge of the planet's shadow, and of the shadows that layers of air throw, is an edge of a cell.
/// `albedo_at`: the ground's albedo by the unit vector from the planet's centre.
pub(super) fn first_order<const N: usize>(
    optics: &Optics<N>,
    line: &Line,
    sources: &[Source<N>],
    albedo_at: &dyn Fn(DVec3) -> [f64; N],
    scratch: &mut Scratch,
) -> First<N> {
    let mut result = First { radiance: [0.0; N], transmittance: [1.0; N] };
    for source in sources {
        let points = points_for(optics, line, source);
        for (direction, weight) in points {
            let one = from_direction(optics, line, direction, albedo_at, scratch);
            result.transmittance = one.transmittance;
            for k in 0..N {
                result.radiance[k] += one.radiance[k] * weight[k] * source.irradiance[k];
            }
        }
    }
    if sources.is_empty() {
        result.transmittance = from_direction(optics, line, DVec3::Z, albedo_at, scratch).transmittance;
    }
    result
}

/// A disc's centre will do where the line is far from it and nowhere near the edge of its light.
pub(super) fn points_for<const N: usize>(
    optics: &Optics<N>,
    line: &Line,
    source: &Source<N>,
) -> Vec<(DVec3, [f64; N])> {
    let distance = line.direction.angle_between(source.direction);
    let grazes = |t: f64| {
        let point = line.at(t);
        let horizon = (optics.radius_m / point.length()).min(1.0).acos();
        let height = (point.dot(source.direction) / point.length()).clamp(-1.0, 1.0).asin();
        // Below 3° of the horizon a beam's transmittance bends over the disc.
        height + horizon < source.radius_rad + 0.05
    };
    // 60 radii: what curvature of a phase function adds over the disc falls below 1e-3 there.
    let far = distance > 60.0 * source.radius_rad;
    if far && ![0.0, line.nearest_m(), line.end_m].into_iter().any(grazes) {
        return vec![(source.direction, [1.0; N])];
    }
    source.points()
}

fn from_direction<const N: usize>(
    optics: &Optics<N>,
    line: &Line,
    direction: DVec3,
    albedo_at: &dyn Fn(DVec3) -> [f64; N],
    scratch: &mut Scratch,
) -> First<N> {
    let mut edges = std::mem::take(&mut scratch.edges);
    line.cut(optics, STEP, &mut edges);
    let dark = cylinder_m(line, direction, optics.radius_m);
    if let Some(dark) = dark {
        edges.extend(dark);
        // Where the light passes close over the ground it changes quickest: cells by the altitude at which it passes.
        let mut low = 0.25 * optics.scale_m;
        let mut passes = optics.kinks_m.clone();
        while low < optics.top_m {
            passes.push(low);
            low *= 2.0;
        }
        for altitude_m in passes {
            edges.extend(cylinder_m(line, direction, optics.radius_m + altitude_m).unwrap_or_default());
        }
        tidy(&mut edges, line.end_m);
    }
    let nu = line.direction.dot(direction).clamp(-1.0, 1.0);
    let phases: Vec<[f64; N]> =
        optics.components.iter().map(|c| c.lobe.as_ref().map_or([0.0; N], |lobe| lobe.at(nu))).collect();
    let count = optics.components.len();
    let rule = rule();
    let mut before_m = vec![0.0; count];
    let mut radiance = [0.0; N];
    // Cells still to do, nearest last.
    let mut cells: Vec<(f64, f64)> = edges.windows(2).rev().map(|pair| (pair[0], pair[1])).collect();
    scratch.edges = edges;
    while let Some((from, to)) = cells.pop() {
        let length = to - from;
        let depth_before = optics.depth(&before_m);
        if depth_before.iter().all(|depth| *depth > OPAQUE) {
            before_m.fill(f64::INFINITY);
            break;
        }
        let mut whole_m = vec![0.0; count];
        for (i, (x, w)) in rule.nodes.iter().enumerate() {
            let densities = &mut scratch.node_densities[i * count..(i + 1) * count];
            optics.densities(line.altitude_m(from + x * length), densities);
            for (column, density) in whole_m.iter_mut().zip(densities.iter()) {
                *column += w * length * density;
            }
        }
        let thickness = optics.depth(&whole_m).into_iter().fold(0.0, f64::max);
        // 1e-9 of the ray: what is thicker still within that is a wall.
        if thickness > THICK && length > 1e-9 * line.end_m.max(1.0) {
            let middle = from + 0.5 * length;
            cells.extend([(middle, to), (from, middle)]);
            continue;
        }
        let middle = from + 0.5 * length;
        if !dark.is_some_and(|[a, b]| middle > a && middle < b) {
            for (i, (x, w)) in rule.nodes.iter().enumerate() {
                let t = from + x * length;
                let light = transmittance_to(optics, line.at(t), direction, scratch);
                let mut depth = depth_before;
                for (j, share) in rule.until[i].iter().enumerate() {
                    for (c, component) in optics.components.iter().enumerate() {
                        let column = share * length * scratch.node_densities[j * count + c];
                        for k in 0..N {
                            depth[k] += column * component.extinction_per_m[k];
                        }
                    }
                }
                for (c, component) in optics.components.iter().enumerate() {
                    let density = scratch.node_densities[i * count + c];
                    for k in 0..N {
                        radiance[k] += w
                            * length
                            * (-depth[k]).exp()
                            * light[k]
                            * density
                            * component.scattering_per_m[k]
                            * phases[c][k];
                    }
                }
            }
        }
        for (before, whole) in before_m.iter_mut().zip(&whole_m) {
            *before += whole;
        }
    }
    // 0 · ∞ where a component is missing: an opaque line lets nothing through.
    let transmittance = optics.depth(&before_m).map(|depth| if depth.is_nan() { 0.0 } else { (-depth).exp() });
    if line.ground && transmittance.iter().any(|t| *t > 0.0) {
        let point = line.at(line.end_m).normalize() * optics.radius_m;
        let cosine = point.dot(direction) / optics.radius_m;
        if cosine > 0.0 {
            let light = transmittance_to(optics, point, direction, scratch);
            let albedo = albedo_at(point / optics.radius_m);
            for k in 0..N {
                radiance[k] += transmittance[k] * albedo[k] / PI * cosine * light[k];
            }
        }
    }
    First { radiance, transmittance }
}
