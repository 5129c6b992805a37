// Points that are too wide for bins: a square each, added to what is there: luminance, or what it changes in the finished colour.

//#include "phenomena/stars/bins.wgsl"

@group(2) @binding(3) var<storage, read> seen_points: array<SeenPoint>;
// The same as `point_bins`, not to be written.
@group(2) @binding(11) var<storage, read> wide_points: array<u32>;

struct PointVertex {
    @builtin(position) position: vec4f,
    // From the point, in ndc of the picture.
    @location(0) offset: vec2f,
    // As in SeenPoint; light times exposure.
    @location(1) @interpolate(flat) centre: vec4f,
    @location(2) @interpolate(flat) light: vec4f,
    // The sky behind, exposed and finished.
    @location(3) @interpolate(flat) sky: vec3f,
    @location(4) @interpolate(flat) finished_sky: vec3f,
    @location(5) @interpolate(flat) seen: vec4f,
    @location(6) @interpolate(flat) own: vec4f,
}

// Looks what is behind wide points, for what is tone mapped together with it.
@compute @workgroup_size(64)
fn look_behind(@builtin(global_invocation_id) id: vec3u) {
    if 6u * id.x >= wide_points[points.bins_first] {
        return;
    }
    let index = wide_points[points.wide_first + points.view_first + id.x];
    let sky = sky_behind(prepared_points[index].seen.xyz) * exposure_now();
    prepared_points[index].sky = vec4f(sky, 0.0);
    prepared_points[index].finished_sky = vec4f(finished_colour(sky), 0.0);
}

// instance: equirectangular pictures draw each point twice, since it may lie on their seam.
@vertex
fn point_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PointVertex {
    let seen = seen_points[wide_points[points.wide_first + points.view_first + vertex / 6u]];
    let half_size = seen.half_size;
    var centre = seen.centre;
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
    return PointVertex(
        // Outside: all corners are one point.
        vec4f(select(ndc, vec2f(2.0), beyond), far_depth, 1.0), offset, vec4f(centre, seen.widen),
        vec4f(seen.light.rgb * exposure_now(), seen.light.a), seen.sky.rgb, seen.finished_sky.rgb, seen.seen, seen.own);
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
