// Points of light drawn over the sky: stars, planets, satellites. One invocation moves, lifts and dims each of them for a
// view; then each is a triangle. Added to what is there: luminance, or what it changes in the finished colour.

//#include "sky.wgsl"
//#include "phenomena/stars/psf.wgsl"

// Whether points have glare; whether it has the fine rays of an eye's lens; whether all is drawn as the thesis does.
override with_glare: bool = false;
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
    padding: u32,
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
    // Bits of points that this view draws as discs.
    discs: vec4u,
    // The runs of the list that this view may show, two in each: where they begin among the points that are moved, and in
    // the list.
    runs: array<vec4u, 48>,
}

// A point as a view sees it.
struct SeenPoint {
    // The point in ndc of the picture; half the size of its triangle's square there, 0: not seen.
    centre: vec2f,
    half_size: vec2f,
    // Illuminance times exposure, linear Rec. 709; share of the core.
    light: vec4f,
    // The sky behind, exposed; widening of the core across …
    sky: vec3f,
    widen_x: f32,
    // … and finished; widening upward.
    finished_sky: vec3f,
    widen_y: f32,
    // Where the point is seen, in view space; the radius of its glare, rad.
    seen: vec4f,
    // Softening of the glare; a number of its own, 0..1; radius of the thesis' glare in pixels.
    own: vec4f,
}

@group(2) @binding(0) var<uniform> points: PointsUniform;
@group(2) @binding(1) var<storage, read> point_list: array<PointLight>;
@group(2) @binding(2) var<storage, read_write> prepared_points: array<SeenPoint>;
// The same buffer, as the drawing reads it.
@group(2) @binding(3) var<storage, read> seen_points: array<SeenPoint>;

struct PointVertex {
    @builtin(position) position: vec4f,
    // From the point, in ndc of the picture.
    @location(0) offset: vec2f,
    // As in SeenPoint.
    @location(1) @interpolate(flat) centre: vec4f,
    @location(2) @interpolate(flat) light: vec4f,
    @location(3) @interpolate(flat) sky: vec3f,
    @location(4) @interpolate(flat) finished_sky: vec3f,
    @location(5) @interpolate(flat) seen: vec4f,
    @location(6) @interpolate(flat) own: vec4f,
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

fn run_of(slot: u32) -> vec2u {
    let pair = points.runs[slot / 2u];
    return select(pair.xy, pair.zw, (slot & 1u) == 1u);
}

// The place in the list of a point that is moved.
fn listed(index: u32) -> u32 {
    var slot = 0u;
    for (var step = 64u; step > 0u; step /= 2u) {
        let next = min(slot + step, 95u);
        slot = select(slot, next, run_of(next).x <= index);
    }
    let run = run_of(slot);
    return run.y + index - run.x;
}

@compute @workgroup_size(64)
fn move_points(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x;
    if index >= points.count {
        return;
    }
    let place_in_list = listed(index);
    let point = point_list[place_in_list];
    let moved = normalize(point.place + point.velocity * points.years - point.parallax * points.observer_au);
    let along = dot(moved, points.beta);
    let slow = 1.0 - 0.5 * dot(points.beta, points.beta);
    let aberrated = normalize(moved * slow + points.beta * (1.0 + 0.5 * along));
    let direction = aberrated.x * points.view_from_list_x + aberrated.y * points.view_from_list_y
        + aberrated.z * points.view_from_list_z;
    let bits = points.discs[min(place_in_list / 32u, 3u)];
    var hidden = place_in_list < 128u && ((bits >> (place_in_list % 32u)) & 1u) == 1u;
    // All four: an unused one has no radius.
    for (var i = 0u; i < 4u; i++) {
        hidden = hidden || length(direction - points.hider[i].xyz) < points.hider[i].w;
    }
    let seen = lifted(direction);
    let mu = dot(seen, view.up);
    hidden = hidden || mu < view.horizon_mu;
    let place = picture_place(seen);
    // Spread over 0..1.
    let seed = fract(point.number * 0.618033988 + 0.5);
    var four = point.four * air_transmittance(seen, mu);
    if twinkling {
        let flicker = twinkle(
            seed, mu, points.scintillation, points.phases[0], points.phases[1], points.shift, points.strength);
        four *= mix(vec4f(1.0), flicker, point.scintillation);
    }
    let exposure = exposure_now();
    let light = rec709_of(four) * exposure;
    let bright = luminance_of(light);

    let per_ndc = solid_angle_per_ndc(place.xy);
    let pixel_sr = per_ndc * points.pixel.x * points.pixel.y;
    // Seeing widens the core where a pixel is finer: the spline's own full width is 1.44 pixels.
    let blurred = vec2f(points.seeing * pow(min(air_mass(mu), 40.0), 0.6), point.width) / (1.44 * sqrt(pixel_sr));
    // 500: a comet that fills a picture.
    var widen = vec2f(min(sqrt(1.0 + dot(blurred, blurred)), 500.0));
    var radial_px = sqrt(pixel_sr);
    if linear {
        let ray = view.ray_origin + view.ray_x * place.x + view.ray_y * place.y;
        radial_px = points.pixel.y * length(view.ray_y) / dot(ray, ray);
    } else if view.projection == 1u {
        radial_px = points.pixel.y * view.half_angle;
    } else {
        // Round on the sphere, not in the picture; 64: what a pole may take.
        widen.x *= min(1.0 / max(cos(place.y * 0.5 * PI), 1e-6), 64.0);
        radial_px = points.pixel.y * 0.5 * PI;
    }

    // A hundredth of a pixel for rounding.
    var half_size = 2.0 * widen + 0.01;
    var glare = vec3f(0.0, 1.0, 0.0);
    if with_glare {
        let soft = max(max(points.glare_soft, radial_px), point.width);
        let reach = min(glare_reach(points.glare.xy, points.glare_floor / max(bright, 1e-30), soft), points.glare.z);
        let share = glare_share(points.glare.xy, max(reach, 1e-9), soft);
        let worth = reach > 2.0 * radial_px;
        glare = vec3f(select(0.0, reach, worth), soft, select(0.0, share, worth));
        half_size = max(half_size, vec2f(glare.x / radial_px) * widen / widen.y);
    }
    var thesis_glare_px = 0.0;
    if as_thesis {
        let relative = bright / (exposure * points.thesis_lx);
        // Δ_m(m + V_T − 1) − 1.
        thesis_glare_px = points.thesis_glare_px * sqrt(max(relative * 1.0544 - 1.0, 0.0));
        half_size = vec2f(max(2.5, thesis_glare_px));
    }

    var sky = vec3f(0.0);
    var finished_sky = vec3f(0.0);
    if finished != 0u {
        sky = sky_behind(seen) * exposure;
        finished_sky = finished_colour(sky);
        // A tenth of a step of 8 bits: nothing to draw.
        let peak = bright * 0.4445 / (pixel_sr * widen.x * widen.y);
        hidden = hidden || (!as_thesis && peak < 2e-3 * luminance_of(max(sky, vec3f(0.0))) + 1e-6);
    }
    if hidden || place.z < 0.5 || !(bright > 0.0) {
        half_size = vec2f(0.0);
    }
    prepared_points[points.first + index] = SeenPoint(
        place.xy, half_size * points.pixel, vec4f(light, 1.0 - glare.z), sky, widen.x, finished_sky, widen.y,
        vec4f(seen, glare.x), vec4f(glare.y, seed, thesis_glare_px, 0.0));
}

// Luminance of the sky in a direction, for what is tone mapped together with it.
fn sky_behind(direction: vec3f) -> vec3f {
    return sky_luminance(table_scales(), direction, vec3f(0.0), vec3f(0.0));
}

// instance: equirectangular pictures draw each point twice, since it may lie on their seam.
@vertex
fn point_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PointVertex {
    let index = points.first + vertex / 6u;
    let half_size = seen_points[index].half_size;
    var centre = seen_points[index].centre;
    var beyond = !(half_size.x > 0.0);
    if instance == 1u {
        centre.x -= 2.0 * sign(centre.x);
        beyond = beyond || abs(centre.x) - 1.0 > half_size.x;
    }
    let corner = vertex % 6u;
    // (−,−) (+,−) (−,+), (−,+) (+,−) (+,+).
    let right = corner == 1u || corner == 4u || corner == 5u;
    let offset = vec2f(select(-1.0, 1.0, right), select(-1.0, 1.0, corner == 2u || corner == 3u || corner == 5u)) * half_size;
    let ndc = (centre + offset - view.tile.xy) / view.tile.zw;
    let seen = seen_points[index];
    return PointVertex(
        // Outside: all corners are one point.
        vec4f(select(ndc, vec2f(2.0), beyond), far_depth, 1.0), offset, vec4f(centre, seen.widen_x, seen.widen_y),
        seen.light, seen.sky, seen.finished_sky, seen.seen, seen.own);
}

@fragment
fn point_fragment(in: PointVertex) -> @location(0) vec4f {
    // Pixels from the point. The size of a pixel is taken from the picture itself, so it is right for any target.
    let step = vec2f(abs(dpdx(in.offset.x)), abs(dpdy(in.offset.y)));
    let pixels = in.offset / max(step, vec2f(1e-30));
    let place = in.centre.xy + in.offset;
    var light = vec3f(0.0);
    if as_thesis {
        let exposed_lx = points.thesis_lx * exposure_now();
        let relative = luminance_of(in.light.rgb) / exposed_lx;
        let distance = length(pixels);
        let excess = clamp(relative * 1.0544 - 1.0, 0.0, 1.0);
        let value = relative * points.thesis_core_scale * thesis_core(0.5 * distance)
            + excess * thesis_glare(distance / max(in.own.z, 1e-6)) * f32(in.own.z > 0.0);
        light = in.light.rgb / max(luminance_of(in.light.rgb), 1e-30) * value;
    } else {
        let at = pixels / in.centre.zw;
        let weight = core_weight(at.x) * core_weight(at.y) / (in.centre.z * in.centre.w);
        let pixel_sr = solid_angle_per_ndc(place) * step.x * step.y;
        var spread = in.light.a * weight / pixel_sr;
        if with_glare && in.seen.w > 0.0 {
            let theta = length(look_direction(place) - in.seen.xyz);
            var veil = max(glare_per_sr(points.glare.xy, theta, in.own.x)
                - glare_per_sr(points.glare.xy, in.seen.w, in.own.x), 0.0);
            if with_corona_rays {
                veil *= ciliary_corona(in.offset / step, in.own.y);
            }
            spread += veil;
        }
        light = in.light.rgb * spread;
    }
    if finished == 0u {
        return vec4f(min(light, vec3f(frame.largest)), 0.0);
    }
    return vec4f(finished_colour(in.sky + light) - in.finished_sky, 0.0);
}
