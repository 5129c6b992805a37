// A ray through the air with all orders of scattering, and what the air leaves of the light behind it.
// Twin of himmel_air::moments::radiance.

//#include "frame/frame.wgsl"
//#include "phenomena/air/medium.wgsl"
//#include "phenomena/ground/ground.wgsl"

// How slant a ray must be (cosine to the vertical) for the two forms of the aerosol's peak to weigh the same.
const EVEN_SLANT: f32 = 0.1;
// Share of the cells that goes to the lit parts of a ray through the planet's shadow.
const LIT_SHARE: f32 = 0.4;

// Whether the aerosols' forward peaks are left to the reader of `weights`, who evaluates them once for the whole ray, at
// its mean depths: for tables. Otherwise every cell evaluates them.
override split_peaks: bool = false;

// Cells that share one look-up of what changes slowly along a ray: the moments' ratios and the peaks' depth to the Sun.
// 1: none.
override group_cells: u32 = 1u;

// Whether something stands before the first light: its shadow is followed through the air.
override eclipses: bool = false;
// Light that is scattered more than once comes from so far around, m.
const BLUR_M: f32 = 150e3;

// Where the cells of a ray lie: distances over the ray's length at shares 0..1 of the cells (columns), for elevations
// (rows, as `elevation_row`). x: of the whole ray; y: by what each stretch scatters, flattened.
@group(1) @binding(1) var cell_table: texture_2d_array<f32>;

// The start of a ray, moved to where it enters the air if it begins above.
struct AirRay {
    altitude_m: f32,
    mu: f32,
    mu_s: f32,
    nu: f32,
    // Angle between ray and Sun.
    theta: f32,
    // Distance from the viewer to the start.
    before_m: f32,
    misses: bool,
    // In view space, and whether something stands before its light: for eclipses.
    direction: vec3f,
    eclipsed: bool,
}

struct AirMarch {
    // Per unit irradiance of the Sun, 1/sr.
    radiance: vec4f,
    // Of the scaled medium: what extended things behind keep.
    through_extended: vec4f,
    // Of the medium: what discs and stars keep.
    through: vec4f,
    // Cosine of the Sun's zenith angle where the ray meets the ground.
    ground_mu_s: f32,
    hits_ground: bool,
    // Of each aerosol, for the peak evaluated elsewhere: weights of the S and the U form (β and 1 − β included) …
    weights: array<vec4f, 8>,
    // … and the mean depths of the peaks at the reference, of S and U.
    depths: vec2f,
}

// sin_theta: sine of the ray's zenith angle, taken from vectors because 1 − µ² cancels far from the planet.
fn enter(altitude_m: f32, mu: f32, sin_theta: f32, mu_s: f32, nu: f32, theta: f32) -> AirRay {
    // Chosen, not branched on: see `exposure_now`.
    let top = airs[body].top_altitude_m;
    let above = altitude_m > top;
    let r = airs[body].bottom_radius_m + altitude_m;
    let r_top = airs[body].bottom_radius_m + top;
    let impact = r * sin_theta;
    let misses = above && (mu >= 0.0 || impact >= r_top);
    let enters = above && !misses;
    let root = sqrt(max((r_top - impact) * (r_top + impact), 0.0));
    let t = -r * mu - root;
    return AirRay(
        select(altitude_m, top, enters), select(mu, -root / r_top, enters),
        select(mu_s, clamp((r * mu_s + t * nu) / r_top, -1.0, 1.0), enters), nu, theta, select(0.0, t, enters), misses,
        vec3f(0.0), false);
}

// The angle between two unit vectors; from their chord where cosines have no digits.
fn angle_between(a: vec3f, b: vec3f) -> f32 {
    let c = dot(a, b);
    if c > 0.0 {
        return 2.0 * asin(min(0.5 * length(a - b), 1.0));
    }
    return PI - 2.0 * asin(min(0.5 * length(a + b), 1.0));
}

// Rows of such tables for rays that meet the ground.
fn rows_below(rows: i32) -> i32 {
    return rows / 3;
}

// Texel row of an elevation in tables that are split at the horizon and crowd there: the first rows are for rays below it,
// none lies between. `below`: which side.
fn elevation_texel(elevation: f32, horizon: f32, below: bool, rows: i32) -> f32 {
    let lower = f32(rows_below(rows));
    let upper = f32(rows) - lower;
    let span = select(0.5 * PI - horizon, 0.5 * PI + horizon, below);
    let x = sqrt(clamp(abs(elevation - horizon) / max(span, 1e-6), 0.0, 1.0));
    return select(lower + x * (upper - 1.0), (1.0 - x) * (lower - 1.0), below);
}

// The elevation of a texel row of such a table.
fn elevation_of_texel(y: i32, rows: i32, horizon: f32) -> f32 {
    let lower = rows_below(rows);
    if y < lower {
        let x = 1.0 - f32(y) / f32(lower - 1);
        return horizon - x * x * (0.5 * PI + horizon);
    }
    let x = f32(y - lower) / f32(rows - lower - 1);
    return horizon + x * x * (0.5 * PI - horizon);
}

// Zenith cosine of a texel: at the horizon itself a little to its side, so that f32 can tell the two apart.
fn texel_mu(y: i32, rows: i32, altitude_m: f32) -> f32 {
    let horizon = horizon_cosine(airs[body].bottom_radius_m, altitude_m);
    let mu = sin(elevation_of_texel(y, rows, asin(horizon)));
    return select(max(mu, horizon + 1e-6), min(mu, horizon - 1e-6), y < rows_below(rows));
}

// Station of another body.
var<private> far_station: u32 = 0u;

fn cell_layer() -> u32 {
    if far_airs && body != 0u {
        return far_station;
    }
    return view.station;
}

// Rows of the cell table that are for rays; one more is for scales.
fn cell_rows() -> i32 {
    return i32(textureDimensions(cell_table).y) - 1;
}

// A column of the cell table, between two rows.
fn cell_texel(x: i32, row: f32) -> vec2f {
    let last = cell_rows() - 1;
    if group_cells > 1u {
        // The nearest row: it only decides where cells lie.
        return textureLoad(cell_table, vec2i(x, clamp(i32(row + 0.5), 0, last)), cell_layer(), 0).xy;
    }
    let base = clamp(i32(row), 0, max(last - 1, 0));
    let next = min(base + 1, last);
    return mix(
        textureLoad(cell_table, vec2i(x, base), cell_layer(), 0).xy,
        textureLoad(cell_table, vec2i(x, next), cell_layer(), 0).xy,
        clamp(row - f32(base), 0.0, 1.0),
    );
}

// Where a share of the cells ends, as a share of the ray.
fn cell_edge(share: f32, row: f32) -> vec2f {
    let last = i32(textureDimensions(cell_table).x) - 1;
    let p = clamp(share, 0.0, 1.0) * f32(last);
    let base = min(i32(p), last - 1);
    return mix(cell_texel(base, row), cell_texel(base + 1, row), p - f32(base));
}

// The share of the flattened cells that ends at a place of the ray.
fn lit_share(place: f32, row: f32) -> f32 {
    let last = i32(textureDimensions(cell_table).x) - 1;
    var low = 0;
    var high = last;
    while high - low > 1 {
        let middle = (low + high) / 2;
        if cell_texel(middle, row).y <= place {
            low = middle;
        } else {
            high = middle;
        }
    }
    let from_place = cell_texel(low, row).y;
    let to_place = cell_texel(high, row).y;
    let within = clamp((place - from_place) / max(to_place - from_place, 1e-9), 0.0, 1.0);
    return (f32(low) + within) / f32(last);
}

// A correction of the forward peak, per unit of scattering, 1/sr. which: 0 for S, 1 for U.
fn peak_correction(layer: u32, which: f32, theta_coordinate: f32, depth: f32) -> vec4f {
    let size = vec2f(textureDimensions(peak_table));
    let depths = 0.5 * (size.y - 2.0);
    let y = which * depths + sqrt(depth / (6.0 + depth)) * (depths - 1.0);
    return table_lookup(peak_table, layer, vec2f(theta_coordinate, y / (size.y - 1.0)));
}

// A row of the peak table that is counted from its end: 1 the mean phase function of the aerosols, 2 an aerosol's own, 1/sr.
fn phase_row(layer: u32, from_end: i32, theta_coordinate: f32) -> vec4f {
    let row = i32(textureDimensions(peak_table).y) - from_end;
    let last = i32(textureDimensions(peak_table).x) - 1;
    let p = clamp(theta_coordinate, 0.0, 1.0) * f32(last);
    let base = min(i32(p), last - 1);
    return mix(
        textureLoad(peak_table, vec2i(base, row), layer, 0),
        textureLoad(peak_table, vec2i(base + 1, row), layer, 0),
        p - f32(base),
    );
}

fn aerosol_phase(layer: u32, theta_coordinate: f32) -> vec4f {
    return phase_row(layer, 2, theta_coordinate);
}

fn mean_phase(theta_coordinate: f32) -> vec4f {
    return phase_row(airs[body].aerosols[0].layer, 1, theta_coordinate);
}

// Coordinate of a scattering angle in the peak table.
fn theta_coordinate_of(theta: f32) -> f32 {
    return sqrt(clamp(theta / PI, 0.0, 1.0));
}

// What the smooth polynomial leaves of an aerosol's phase function, per unit of scattering: the S form at a depth of the
// peaks on the whole way, and the U form at the depth on the way to the Sun.
fn peak_scaled(aerosol: u32, phase: vec4f, theta_coordinate: f32, nu: f32, depth: f32) -> vec4f {
    let second = 0.5 * (3.0 * nu * nu - 1.0);
    let smooth_part = airs[body].aerosols[aerosol].smooth_0 + 3.0 * nu * airs[body].aerosols[aerosol].smooth_1
        + 5.0 * second * airs[body].aerosols[aerosol].smooth_2;
    let polynomial = smooth_part / (4.0 * PI * max(airs[body].aerosols[aerosol].scattering, vec4f(1e-30)));
    let passed = exp(-depth * airs[body].peak_ratio);
    let correction = peak_correction(airs[body].aerosols[aerosol].layer, 0.0, theta_coordinate, depth);
    return passed * (phase - polynomial) + (vec4f(1.0) - passed) * correction;
}

fn peak_unscaled(aerosol: u32, phase: vec4f, theta_coordinate: f32, depth: f32) -> vec4f {
    let passed = exp(-depth * airs[body].peak_ratio);
    let correction = peak_correction(airs[body].aerosols[aerosol].layer, 1.0, theta_coordinate, depth);
    return passed * phase + (vec4f(1.0) - passed) * correction;
}

// ∫ e^(−σt) dt over a cell, and what passes it. Below a depth of 1e-3 the closed form cancels in f32; the series is
// exact to 1e-7.
struct CellPass {
    length: vec4f,
    passed: vec4f,
}

fn pass_cell(extinction: vec4f, dt: f32) -> CellPass {
    let x = extinction * dt;
    let passed = exp(-x);
    let closed = (vec4f(1.0) - passed) / max(extinction, vec4f(1e-30));
    return CellPass(select(closed, dt * (vec4f(1.0) - 0.5 * x + x * x / 6.0), x < vec4f(1e-3)), passed);
}

// A ray under way: what all its cells know.
struct Marcher {
    start: AirRay,
    r0: f32,
    theta_coordinate: f32,
    second: f32,
    phases: array<vec4f, 4>,
    light_scaled: vec4f,
    light_whole: vec4f,
    through_scaled: vec4f,
    through_whole: vec4f,
    // Depth of the peaks from the viewer, and to the Sun (of a group of cells).
    depth_view: f32,
    sun_peak: f32,
    ratios: Moments,
    slant: vec4f,
    slant_weight: vec4f,
    mean_depths: vec2f,
    mean_weights: vec2f,
    weights: array<vec4f, 8>,
}

fn begin_march(start: AirRay) -> Marcher {
    var m: Marcher;
    m.start = start;
    m.r0 = airs[body].bottom_radius_m + start.altitude_m;
    m.second = 0.5 * (3.0 * start.nu * start.nu - 1.0);
    m.theta_coordinate = theta_coordinate_of(start.theta);
    if !split_peaks {
        for (var a = 0u; a < aerosols; a++) {
            m.phases[a] = aerosol_phase(airs[body].aerosols[a].layer, m.theta_coordinate);
        }
    }
    m.through_scaled = vec4f(1.0);
    m.through_whole = vec4f(1.0);
    m.mean_weights = vec2f(1e-30);
    return m;
}

// Looks up what a group of cells shares, at a distance in its middle.
fn begin_group(m: ptr<function, Marcher>, t: f32) {
    let start = (*m).start;
    let radius = airs[body].bottom_radius_m;
    let h = altitude_along(radius, start.altitude_m, start.mu, t);
    let mu_s = clamp(((*m).r0 * start.mu_s + t * start.nu) / (radius + h), -1.0, 1.0);
    let coordinate = altitude_coordinate(h);
    (*m).ratios = moment_ratios(coordinate, suns_coordinate(density_row(SUNS_ROW, coordinate), mu_s).x);
    (*m).sun_peak = peak_to_space(h, mu_s);
}

// What an eclipse leaves of the light at a distance along a ray: of the Sun's, and of what is scattered more than once.
struct Eclipsed {
    sun: vec4f,
    sky: vec4f,
}

fn eclipse_at(ray: AirRay, t: f32) -> Eclipsed {
    if !eclipses || !ray.eclipsed {
        return Eclipsed(vec4f(1.0), vec4f(1.0));
    }
    let offset = ray.direction * (ray.before_m + t);
    return Eclipsed(
        eclipse_fraction_from(eclipse_table, view.table_b, view.shadow, offset),
        eclipse_fraction_blurred(eclipse_table, view.table_b, view.shadow, offset, view.up, BLUR_M),
    );
}

// Adds a cell. lit: share of the Sun's light that reaches it, but for the air.
fn add_cell(m: ptr<function, Marcher>, middle: f32, dt: f32, lit: f32) {
    let start = (*m).start;
    let nu = start.nu;
    let radius = airs[body].bottom_radius_m;
    let h = altitude_along(radius, start.altitude_m, start.mu, middle);
    let r = radius + h;
    let mu = clamp(((*m).r0 * start.mu + middle) / r, -1.0, 1.0);
    let mu_s = clamp(((*m).r0 * start.mu_s + middle * nu) / r, -1.0, 1.0);
    let coordinate = altitude_coordinate(h);
    let local = local_air(coordinate);
    let aerosol_scattering = local.scaled_0 + local.peak - local.molecules_0;
    let column = suns_coordinate(density_row(SUNS_ROW, coordinate), mu_s);
    if group_cells == 1u {
        (*m).ratios = moment_ratios(coordinate, column.x);
        (*m).sun_peak = peak_to_space(h, mu_s);
    }
    let eclipsed = eclipse_at(start, middle);
    let g = eclipsed.sky * moment_g(coordinate, column);
    let axes = frame_of_sun(mu, mu_s, nu);
    var source_scaled = g * scattered((*m).ratios, local.scaled_0, local.scaled_1, local.scaled_2, mu, axes);
    var source_whole = vec4f(0.0);
    if aerosols > 0u {
        source_whole = g * scattered(
            (*m).ratios, local.scaled_0 + local.peak, local.scaled_1 + local.peak, local.scaled_2 + local.peak, mu, axes);
    }
    let cell = pass_cell(local.extinction - local.peak, dt);
    let cell_whole = pass_cell(local.extinction, dt);
    // Not a branch: no lane of a group would skip it alone.
    let sun = lit * eclipsed.sun * scaled_to_space(h, mu_s);
    let smooth_light = local.scaled_0 + 3.0 * nu * local.scaled_1 + 5.0 * (*m).second * local.scaled_2;
    source_scaled += sun * smooth_light / (4.0 * PI);
    if aerosols > 0u {
        source_whole += sun * (local.molecules_0 + 5.0 * (*m).second * local.molecules_2) / (4.0 * PI);
    }
    let depth = (*m).sun_peak + (*m).depth_view;
    for (var a = 0u; a < aerosols; a++) {
        let species = airs[body].aerosols[a].species;
        let n = local.densities[species / 4u][species % 4u];
        let hit = sun * n * airs[body].aerosols[a].scattering;
        if split_peaks {
            let weight_scaled = hit * (*m).through_scaled * cell.length;
            let weight_whole = hit * (*m).through_whole * cell_whole.length;
            (*m).weights[2u * a] += weight_scaled;
            (*m).weights[2u * a + 1u] += weight_whole;
            let weight = vec2f(dot(weight_scaled, vec4f(1.0)), dot(weight_whole, vec4f(1.0)));
            (*m).mean_depths += weight * vec2f(depth, (*m).sun_peak);
            (*m).mean_weights += weight;
        } else {
            source_scaled += hit * peak_scaled(a, (*m).phases[a], (*m).theta_coordinate, nu, depth);
            source_whole += hit * peak_unscaled(a, (*m).phases[a], (*m).theta_coordinate, (*m).sun_peak);
        }
    }
    (*m).light_scaled += (*m).through_scaled * cell.length * source_scaled;
    (*m).through_scaled *= cell.passed;
    if aerosols > 0u {
        let weight = (*m).through_whole * cell_whole.length;
        (*m).light_whole += weight * source_whole;
        (*m).slant_weight += weight * aerosol_scattering;
        (*m).slant += weight * aerosol_scattering * (abs(mu) / (abs(mu) + EVEN_SLANT));
        (*m).depth_view += local.peak_reference * dt;
    }
    (*m).through_whole *= cell_whole.passed;
}

// What came of a march. reflected: radiance of what lies at its end.
fn end_march(m: ptr<function, Marcher>, reflected: vec4f) -> AirMarch {
    var result: AirMarch;
    let scaled = (*m).light_scaled + (*m).through_scaled * reflected;
    let whole = (*m).light_whole + (*m).through_whole * reflected;
    let weighed = (*m).slant_weight > vec4f(0.0);
    let blend = select(vec4f(1.0), (*m).slant / max((*m).slant_weight, vec4f(1e-30)), weighed);
    result.radiance = select(scaled, blend * scaled + (vec4f(1.0) - blend) * whole, vec4<bool>(aerosols > 0u));
    for (var a = 0u; a < aerosols; a++) {
        result.weights[2u * a] = blend * (*m).weights[2u * a];
        result.weights[2u * a + 1u] = (vec4f(1.0) - blend) * (*m).weights[2u * a + 1u];
    }
    result.depths = (*m).mean_depths / (*m).mean_weights;
    result.through_extended = (*m).through_scaled;
    result.through = (*m).through_whole;
    return result;
}

// Marches a ray. cell_row: its row in the cell table. limit_m: where the ray is cut (1e30: where the air ends).
fn march_air(start: AirRay, cell_row: f32, steps: u32, limit_m: f32) -> AirMarch {
    var nothing: AirMarch;
    nothing.through_extended = vec4f(1.0);
    nothing.through = vec4f(1.0);
    if start.misses || limit_m <= 0.0 {
        return nothing;
    }
    let radius = airs[body].bottom_radius_m;
    let nu = start.nu;
    var m = begin_march(start);
    let ground = ground_distance(radius, start.altitude_m, start.mu);
    var end = ground;
    var hits_ground = false;
    var ground_mu_s = 0.0;
    if ground >= 0.0 {
        hits_ground = limit_m >= end;
        ground_mu_s = clamp((m.r0 * start.mu_s + ground * nu) / radius, -1.0, 1.0);
    } else {
        end = top_distance(radius, airs[body].top_altitude_m, start.altitude_m, start.mu);
    }
    let limit = min(end, limit_m);

    // Cells: edges by the table; where the ray crosses the planet's shadow, some of them go to its lit parts alone.
    let dark = min(shadow_interval(radius, start.altitude_m, start.mu, start.mu_s, nu), vec2f(end));
    let is_dark = dark.y > dark.x;
    let crosses = is_dark && (dark.x > 0.0 || dark.y < end);
    var lit_cells = 0u;
    var near_lit = 0.0;
    var far_lit = 1.0;
    if crosses {
        lit_cells = u32(round(LIT_SHARE * f32(steps)));
        if dark.x > 0.0 {
            near_lit = lit_share(dark.x / end, cell_row);
        }
        if dark.y < end {
            far_lit = lit_share(dark.y / end, cell_row);
        }
    }
    let lit_amount = near_lit + 1.0 - far_lit;
    let even_cells = steps - lit_cells;
    var next_even_index = 1u;
    var next_lit_index = 1u;
    var next_even = end * cell_edge(1.0 / f32(even_cells), cell_row).x;
    var next_lit = 2.0 * end;

    var t = 0.0;
    // Every cell of either kind, and the edges of the shadow.
    for (var guard = 0u; guard < steps + 4u && t < limit; guard += group_cells) {
        if group_cells > 1u {
            let ahead = min(f32(next_even_index) - 1.0 + 0.5 * f32(group_cells), f32(even_cells) - 0.5);
            begin_group(&m, max(end * cell_edge(ahead / f32(even_cells), cell_row).x, t));
        }
        for (var in_group = 0u; in_group < group_cells; in_group++) {
            if lit_cells > 0u && next_lit <= t {
                var share = f32(next_lit_index) / f32(lit_cells) * lit_amount;
                share = select(share - near_lit + far_lit, share, share <= near_lit);
                next_lit = end * cell_edge(share, cell_row).y;
                next_lit_index += 1u;
                if next_lit_index > lit_cells + 1u {
                    next_lit = 2.0 * end;
                }
            }
            if next_even <= t {
                next_even_index += 1u;
                next_even = end * cell_edge(f32(next_even_index) / f32(even_cells), cell_row).x;
                if next_even_index >= even_cells {
                    next_even = end;
                }
            }
            var next = min(next_even, limit);
            if lit_cells > 0u {
                next = min(next, max(next_lit, t));
            }
            if is_dark && t < dark.x {
                next = min(next, dark.x);
            } else if is_dark && t < dark.y {
                next = min(next, dark.y);
            }
            let dt = next - t;
            let middle = 0.5 * (t + next);
            let is_lit = !is_dark || middle < dark.x || middle >= dark.y;
            t = next;
            if dt > 0.0 {
                add_cell(&m, middle, dt, select(0.0, 1.0, is_lit));
            }
        }
    }
    var reflected = vec4f(0.0);
    if hits_ground {
        let eclipsed = eclipse_at(start, ground);
        reflected = ground_radiance(ground_mu_s, eclipsed.sun, eclipsed.sky);
    }
    var result = end_march(&m, reflected);
    result.hits_ground = hits_ground;
    result.ground_mu_s = ground_mu_s;
    return result;
}
