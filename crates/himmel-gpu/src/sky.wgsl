// The whole sky in one pass at infinite depth: air with Sun before the ground. More phenomena join here, in the order
// star map, stars, planets, Moon, air with Sun, clouds.

//#include "phenomena/air/sky_view_table.wgsl"
//#include "phenomena/sun/sun.wgsl"
//#include "output/tonemap.wgsl"
//#include "output/dither.wgsl"

// Depth at infinity: 0 where depth is reversed, else 1.
override far_depth: f32 = 1.0;
// 0: linear Rec. 709 times exposure; 1: tone mapped and display-encoded.
override finished: u32 = 0u;
// The metering picture is not exposed, whatever the frame says.
override metering: bool = false;

struct SkyVertex {
    @builtin(position) position: vec4f,
    @location(0) ndc: vec2f,
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> SkyVertex {
    let ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return SkyVertex(vec4f(ndc, far_depth, 1.0), view.tile.xy + view.tile.zw * ndc);
}

// The look direction of a point of the picture in view space; zero outside the picture (fisheye).
fn look_direction(ndc: vec2f) -> vec3f {
    switch view.projection {
        case 1u: {
            // Fisheye: the angle from the axis grows evenly with the distance from the centre.
            let p = ndc * vec2f(view.aspect, 1.0);
            let angle = length(p) * view.half_angle;
            if angle > min(view.half_angle, PI) {
                return vec3f(0.0);
            }
            let direction = p / max(length(p), 1e-9);
            return vec3f(direction * sin(angle), -cos(angle));
        }
        case 2u: {
            // Equirectangular: the middle column looks along the camera's azimuth, the middle row at the horizon.
            let azimuth = ndc.x * PI;
            let altitude = ndc.y * 0.5 * PI;
            return cos(altitude) * (cos(azimuth) * view.north + sin(azimuth) * view.east) + sin(altitude) * view.up;
        }
        default: {
            return normalize(view.ray_origin + view.ray_x * ndc.x + view.ray_y * ndc.y);
        }
    }
}

// Radiance along a ray with zenith cosine mu, all lights. `below`: whether it meets the ground.
fn sky_radiance(ray: vec3f, dx: vec3f, dy: vec3f, mu: f32, sin_theta: f32, below: bool) -> vec4f {
    var sum = vec4f(0.0);
    let radius = airs[body].bottom_radius_m;
    for (var light = 0u; light < frame.light_count; light++) {
        var radiance = vec4f(0.0);
        var through = vec4f(1.0);
        var disc = vec4f(0.0);
        if !below {
            disc = sun_disc_radiance(light, ray, dx, dy);
        }
        if view.sky_view == 1u {
            radiance = sky_view_radiance(light, ray, mu, below);
            if any(disc > vec4f(0.0)) {
                through = transmittance_to_space(view.altitude_m, mu);
            }
        } else {
            let sun = view.lights[light].direction;
            let start = enter(
                view.altitude_m, mu, sin_theta, view.lights[light].mu_s, clamp(dot(ray, sun), -1.0, 1.0),
                angle_between(ray, sun));
            let rows = i32(textureDimensions(cell_table).y);
            let altitude = min(view.altitude_m, airs[body].top_altitude_m);
            let horizon = asin(horizon_cosine(radius, altitude));
            let air = march_air(start, elevation_texel(asin(start.mu), horizon, below, rows), 1.0, 1e30);
            radiance = air.radiance;
            through = air.through;
        }
        sum += view.lights[light].irradiance * (max(radiance, vec4f(0.0)) + through * disc);
    }
    return sum;
}

// Linear Rec. 709 in cd/m². The horizon is smoothed over a pixel: there the ground below and the sky above it are mixed.
// `dx`, `dy`: how the ray changes to the next pixel.
fn sky_luminance(ray: vec3f, dx: vec3f, dy: vec3f) -> vec3f {
    let pixel = 0.5 * (length(dx) + length(dy));
    let mu = dot(ray, view.up);
    let horizon = horizon_cosine(airs[body].bottom_radius_m, view.altitude_m);
    // Height above the horizon in pixels; cosines near it differ as angles do, times the sine.
    let sine = max(sqrt(1.0 - horizon * horizon), 1e-3);
    let above = (mu - horizon) / (sine * max(pixel, 1e-9));
    var four = vec4f(0.0);
    if abs(above) >= 0.5 {
        four = sky_radiance(ray, dx, dy, mu, length(cross(ray, view.up)), above < 0.0);
    } else {
        // 1e-6 tells the two sides apart in f32. From within the air by the cosine, from above by the sine, R / r, which
        // cancels nothing far away.
        let sine_of_limb = airs[body].bottom_radius_m / (airs[body].bottom_radius_m + view.altitude_m);
        for (var side = -1.0; side < 2.0; side += 2.0) {
            let sin_theta = min(sine_of_limb * (1.0 + side * 1e-6), 1.0);
            four += (0.5 + side * above) * sky_radiance(ray, dx, dy, min(horizon + side * 1e-6, 0.0), sin_theta, side < 0.0);
        }
    }
    return vec3f(
        dot(frame.rec709_from_four_r, four),
        dot(frame.rec709_from_four_g, four),
        dot(frame.rec709_from_four_b, four),
    );
}

@fragment
fn sky_fragment(in: SkyVertex) -> @location(0) vec4f {
    let look = look_direction(in.ndc);
    // Derivatives are taken before anything branches. Where the picture tears (the seam of an equirectangular one, the
    // edge of a fisheye) they are the tear: no pixel spans more than 0.2.
    var dx = dpdx(look);
    var dy = dpdy(look);
    dx *= min(1.0, 0.2 / max(length(dx), 1e-9));
    dy *= min(1.0, 0.2 / max(length(dy), 1e-9));
    if dot(look, look) < 0.5 {
        // Nothing: the corners of a fisheye.
        return vec4f(0.0);
    }
    var luminance = sky_luminance(look, dx, dy);
    if metering {
        return vec4f(luminance, 1.0);
    }
    var exposure = frame.exposure;
    if exposure == 0.0 {
        exposure = textureLoad(exposure_texture, vec2i(0), 0).x * frame.compensation;
    }
    luminance *= exposure;
    if finished == 0u {
        return vec4f(clamp(luminance, vec3f(-frame.largest), vec3f(frame.largest)), 1.0);
    }
    // 1e30 keeps the tone mappers finite; negative values are colours outside Rec. 709.
    var encoded = tonemap(frame.tonemap, clamp(luminance, vec3f(0.0), vec3f(1e30)));
    if frame.dither_levels > 0.0 {
        encoded += triangular_noise(vec2u(in.position.xy + view.pixel)) / frame.dither_levels;
    }
    encoded = clamp(encoded, vec3f(0.0), vec3f(1.0));
    return vec4f(select(encoded, srgb_decode(encoded), frame.encoding == 2u), 1.0);
}
