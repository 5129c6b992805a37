// Moves the points of a list for a view, lifts and dims them, and counts in which bins of the picture they stand.

//#include "phenomena/stars/bins.wgsl"

@group(2) @binding(1) var<storage, read> point_list: array<PointLight>;

fn run_of(slot: u32) -> vec2u {
    let pair = points.runs[slot / 2u];
    return select(pair.xy, pair.zw, (slot & 1u) == 1u);
}

// The place in the list of a point that is moved.
fn place_in_list_of(index: u32) -> u32 {
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
    let place_in_list = place_in_list_of(index);
    let point = point_list[place_in_list];
    let direction = airless_direction(point.place, point.velocity, point.parallax);
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
    let light = rec709_of(four);
    let bright = luminance_of(light);

    let per_ndc = solid_angle_per_ndc(place.xy);
    let pixel_sr = per_ndc * points.pixel.x * points.pixel.y;
    // Seeing widens the core where a pixel is finer: the spline's own full width is 1.44 pixels.
    let blurred = vec2f(points.seeing * pow(min(air_mass(mu), 40.0), 0.6), point.width) / (1.44 * sqrt(pixel_sr));
    // 500: a comet that fills a picture.
    var widen = vec2f(min(sqrt(1.0 + dot(blurred, blurred)), 500.0));
    let radial_px = radial_pixel(place.xy, points.pixel.y);
    if !linear {
        // Round on the sphere, not in an equirectangular picture; 64: what a pole may take.
        let stretch = min(1.0 / max(cos(place.y * 0.5 * PI), 1e-6), 64.0);
        widen.x *= select(1.0, stretch, view.projection == 2u);
    }

    // A hundredth of a pixel for rounding.
    var half_size = 2.0 * widen + 0.01;
    var glare = vec3f(0.0, 1.0, 0.0);
    if with_glare {
        let soft = max(max(points.glare_soft, radial_px), point.width);
        let reach = min(glare_reach(points.glare.xy, points.glare_floor / max(bright * exposure_now(), 1e-30), soft), points.glare.z);
        let share = glare_share(points.glare.xy, max(reach, 1e-9), soft);
        glare = vec3f(reach, soft, select(0.0, share, reach > 0.0));
        half_size = max(half_size, vec2f(glare.x / radial_px) * widen / widen.y);
    }
    var thesis_glare_px = 0.0;
    if as_thesis {
        let relative = bright / points.thesis_lx;
        // Δ_m(m + V_T − 1) − 1.
        thesis_glare_px = points.thesis_glare_px * sqrt(max(relative * 1.0544 - 1.0, 0.0));
        half_size = vec2f(max(2.5, thesis_glare_px));
    }

    let half_ndc = half_size * points.pixel;
    // Half a bin: it stands in four of them at most.
    let wide = as_thesis || points.all_wide == 1u || (with_glare && point.width > 0.0) || any(half_ndc * vec2f(points.bins) > vec2f(1.0));
    let seen_here = !hidden && place.z > 0.5 && bright > 0.0;
    let point_seen = SeenPoint(
        place.xy, select(vec2f(0.0), half_ndc, seen_here), vec4f(light, 1.0 - glare.z), widen, per_ndc, u32(wide),
        vec4f(seen, glare.x), vec4f(glare.y, seed, thesis_glare_px, 0.0), vec4f(0.0), vec4f(0.0));
    prepared_points[points.first + index] = point_seen;
    let reach = bins_of(point_seen);
    for (var i = 0u; i < reach.count.x * reach.count.y; i++) {
        atomicAdd(&point_bins[bin_slot(reach, i)], 1u);
    }
}
