// What passes of points share: the list, what a view makes of it, and where a direction lies in a picture.

//#include "sky.wgsl"
//#include "phenomena/stars/psf.wgsl"

// Whether glare has the fine rays of an eye's lens; whether all is drawn as the thesis does.
override with_corona_rays: bool = false;
override as_thesis: bool = false;
// Whether any of them twinkle.
override twinkling: bool = true;

// A point as the list keeps it.
struct PointLight {
    // Unit vector at J2000.0, or now.
    place: vec3f,
    // Annual parallax, rad.
    parallax: f32,
    // Change of the place per Julian year.
    velocity: vec3f,
    // Share of scintillation: 0 for planets, whose discs are wider than the pattern.
    scintillation: f32,
    // Irradiance above the air relative to the preset's star at 1 au.
    four: vec4f,
    // Full width of what is no point: a comet's coma, rad.
    width: f32,
    // A number of its own.
    number: f32,
    padding_0: f32,
    padding_1: f32,
}

struct PointsUniform {
    // Columns of view-from-list.
    view_from_list_x: vec3f,
    years: f32,
    view_from_list_y: vec3f,
    // Full width of the seeing at the zenith, rad.
    seeing: f32,
    view_from_list_z: vec3f,
    // Standard deviation of scintillation at the zenith.
    scintillation: f32,
    // The observer's velocity by the speed of light, along the list's axes.
    beta: vec3f,
    // Exposed value at which glare ends.
    glare_floor: f32,
    // The observer's place in au, along the list's axes.
    observer_au: vec3f,
    // Softening of the glare, rad.
    glare_soft: f32,
    // Glare: inverse cube, inverse square; farthest, rad.
    glare: vec3f,
    // 1: all points are wide.
    all_wide: u32,
    // Apparent minus true elevation, over true elevation.
    lift: BendingUniform,
    // Discs before the points: unit vector without refraction; chord of the radius, 0 where there is none.
    hider: array<vec4f, 4>,
    phases: array<vec4f, 2>,
    shift: vec4f,
    strength: vec4f,
    // A pixel in ndc of the picture, or a guess that is not too small.
    pixel: vec2f,
    // Solid angle per area of ndc at the middle of a linear projection, times its distance cubed.
    area: f32,
    // The thesis: illuminance of m_a, lx.
    thesis_lx: f32,
    // I_T for Δ_m = 1; pixels of glare for I_G = 1.
    thesis_core_scale: f32,
    thesis_glare_px: f32,
    // The list's length; where its prepared points begin.
    count: u32,
    first: u32,
    // All points of the view: how many, and where they begin.
    view_count: u32,
    view_first: u32,
    // Bins along the sides of the picture; where what the view keeps of them begins.
    bins: vec2u,
    bins_first: u32,
    // Where the lists of all views begin, and their wide points.
    lists_first: u32,
    wide_first: u32,
    // Texel at which points in bins begin, see binned.wgsl.
    binned_first: u32,
    // Bits of points that this view draws as discs.
    discs: vec4u,
    // The runs of the list that this view may show, two in each: where they begin among the points that are moved, and in
    // the list.
    runs: array<vec4u, 48>,
}

// A point as a view sees it.
struct SeenPoint {
    // The point in ndc of the picture; half the size of its square there, 0: not seen.
    centre: vec2f,
    half_size: vec2f,
    // Illuminance, linear Rec. 709 in lx; share of the core.
    light: vec4f,
    // Widening of the core across and upward.
    widen: vec2f,
    // Solid angle per area of ndc.
    per_ndc: f32,
    // 1: it is drawn as a square; 0: it stands in bins, and the sky's pixels read it.
    wide: u32,
    // Where the point is seen, in view space; the radius of its glare, rad.
    seen: vec4f,
    // Softening of the glare; a number of its own, 0..1; radius of the thesis' glare in pixels.
    own: vec4f,
    // Of a wide point in a finished picture: the sky behind, exposed; the same finished.
    sky: vec4f,
    finished_sky: vec4f,
}

@group(2) @binding(0) var<uniform> points: PointsUniform;

// Where a point of the list is in view space without refraction: proper motion, parallax, aberration.
fn airless_direction(place: vec3f, velocity: vec3f, parallax: f32) -> vec3f {
    let moved = normalize(place + velocity * points.years - parallax * points.observer_au);
    let along = dot(moved, points.beta);
    let slow = 1.0 - 0.5 * dot(points.beta, points.beta);
    let aberrated = normalize(moved * slow + points.beta * (1.0 + 0.5 * along));
    return aberrated.x * points.view_from_list_x + aberrated.y * points.view_from_list_y
        + aberrated.z * points.view_from_list_z;
}

fn lift_node(index: i32) -> f32 {
    let i = clamp(index, 0, 31);
    return points.lift.deviation[i / 4][i % 4];
}

// The same as bent_deviation(points.lift, …).x, without a copy of the table for each call.
fn lift_at(elevation: f32) -> f32 {
    let above = clamp(elevation - points.lift.lowest, -BENDING_BELOW, 1.57079633 - points.lift.lowest);
    let scaled = abs(above) / points.lift.width;
    let x = sign(above) * log(scaled + sqrt(scaled * scaled + 1.0)) / points.lift.span * 31.0;
    let i = clamp(i32(floor(x)), 0, 30);
    let here = lift_node(i);
    let next = lift_node(i + 1);
    let rise = next - here;
    let low = select(0.5 * (next - lift_node(i - 1)), rise, i == 0);
    let high = select(0.5 * (lift_node(i + 2) - here), rise, i == 30);
    let t = x - f32(i);
    let cubic = here + t * (low + t * ((3.0 * rise - 2.0 * low - high) + t * (low + high - 2.0 * rise)));
    return select(cubic, here + low * t, t < 0.0);
}

// A vector turned towards the zenith by a small angle, from true to apparent place.
fn lifted(direction: vec3f) -> vec3f {
    let sine = dot(direction, view.up);
    let level = direction - sine * view.up;
    let across = length(level);
    let angle = lift_at(atan2(sine, across));
    let tangent = (view.up - sine * direction) / max(across, 1e-6);
    // Series: exact to 1e-7 up to 0.3 rad, where sin and cos of WGSL may err by 5e-4.
    let a2 = angle * angle;
    let s = angle * (1.0 - a2 / 6.0 * (1.0 - a2 / 20.0));
    let c = 1.0 - 0.5 * a2 * (1.0 - a2 / 12.0);
    return normalize(c * direction + s * tangent);
}

// Where a direction of view space lies in the picture, ndc; z: 1 if it does.
fn picture_place(direction: vec3f) -> vec3f {
    if linear {
        let normal = cross(view.ray_x, view.ray_y);
        let depth = dot(direction, normal) / dot(view.ray_origin, normal);
        let inside = direction / max(depth, 1e-6) - view.ray_origin;
        let scale = 1.0 / dot(normal, normal);
        let x = dot(cross(inside, view.ray_y), normal) * scale;
        let y = dot(cross(view.ray_x, inside), normal) * scale;
        return vec3f(x, y, f32(depth > 1e-6));
    }
    if view.projection == 1u {
        let across = length(direction.xy);
        let angle = atan2(across, -direction.z);
        let place = direction.xy / max(across, 1e-9) * (angle / view.half_angle) / vec2f(view.aspect, 1.0);
        return vec3f(place, f32(angle <= min(view.half_angle, PI)));
    }
    let azimuth = atan2(dot(direction, view.east), dot(direction, view.north));
    let sine = dot(direction, view.up);
    let altitude = atan2(sine, length(direction - sine * view.up));
    return vec3f(azimuth / PI, altitude / (0.5 * PI), 1.0);
}

// Solid angle per area of ndc at a place of the picture.
fn solid_angle_per_ndc(place: vec2f) -> f32 {
    if linear {
        let ray = view.ray_origin + view.ray_x * place.x + view.ray_y * place.y;
        let inverse = inverseSqrt(dot(ray, ray));
        return points.area * inverse * inverse * inverse;
    }
    if view.projection == 1u {
        let angle = max(length(place * vec2f(view.aspect, 1.0)) * view.half_angle, 1e-6);
        return view.half_angle * view.half_angle * view.aspect * sin(min(angle, PI)) / angle;
    }
    // The rows at the poles still have some width: half a row.
    return max(cos(place.y * 0.5 * PI), 0.25 * points.pixel.y) * 0.5 * PI * PI;
}

fn luminance_of(rgb: vec3f) -> f32 {
    return dot(rgb, vec3f(0.2126, 0.7152, 0.0722));
}

// Finished colour of exposed light, as the target blends it.
fn finished_colour(exposed: vec3f) -> vec3f {
    let mapped = tonemap(frame.tonemap, clamp(exposed, vec3f(0.0), vec3f(1e30)), exposure_now());
    let encoded = clamp(mapped, vec3f(0.0), vec3f(1.0));
    if !target_is_srgb {
        return encoded;
    }
    return select(encoded, srgb_decode(encoded), frame.encoding == 2u);
}

// What the air leaves of light from an apparent direction.
fn air_transmittance(direction: vec3f, mu: f32) -> vec4f {
    let start = enter(view.altitude_m, mu, length(cross(direction, view.up)), 0.0, 0.0, 0.0);
    return select(transmittance_to_space(start.altitude_m, start.mu), vec4f(1.0), start.misses);
}

// Luminance of the sky in a direction, for what is tone mapped together with it.
fn sky_behind(direction: vec3f) -> vec3f {
    return sky_luminance(table_scales(), direction, vec3f(0.0), vec3f(0.0));
}
