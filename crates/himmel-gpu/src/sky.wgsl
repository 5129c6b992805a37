// The whole sky in one pass at infinite depth: air with Sun before the ground. More phenomena join here, in the order
// star map, stars, planets, Moon, air with Sun, clouds.

//#include "phenomena/air/sky_view_table.wgsl"
//#include "phenomena/night_glow/night_glow.wgsl"
//#include "phenomena/sun/sun.wgsl"
//#include "phenomena/moon/moon.wgsl"
//#include "phenomena/stars/binned.wgsl"
//#include "output/tonemap.wgsl"
//#include "output/dither.wgsl"

// Depth at infinity: 0 where depth is reversed, else 1.
override far_depth: f32 = 1.0;
// 0: linear Rec. 709 times exposure; 1: tone mapped and display-encoded.
override finished: u32 = 0u;
// Whether the target may encode sRGB by itself.
override target_is_srgb: bool = true;
// The metering picture is not exposed, whatever the frame says.
override metering: bool = false;
// Whether every pixel marches its own ray, or looks the sky up in the sky-view table.
override marching: bool = true;
// Whether the picture is drawn in tiles, each by the pipeline that has what it needs and nothing else.
override tiled: bool = false;
// What this pipeline has: the horizon, the aureoles of lights, their discs.
override with_horizon: bool = true;
override with_aureole: bool = true;
override with_disc: bool = true;
// Whether the projection is linear (a matrix): every other costs more.
override linear: bool = false;

// How many lights the frame has: a constant, so that loops over them unroll and one alone is read in place.
override light_count: u32 = 1u;

// Whether the Moon is in the picture.
override with_moon: bool = false;
// Whether the night's own glow is drawn, and whether it is read from its grid.
override night: bool = false;
override night_grid: bool = false;

// Of other bodies along a ray: light and what they let through of what lies behind; of those behind this body's air, and
// of those before it.
var<private> far_light: vec4f;
var<private> far_through: vec4f;
var<private> near_light: vec4f;
var<private> near_through: vec4f;

// What glows along the rays of a view, without the Moon before it: linear Rec. 709 in units of the view. a: the share that comes
// from behind the Moon.
@group(2) @binding(6) var night_grid_table: texture_2d_array<f32>;
// Its texels; the same in grid.rs.
const NIGHT_GRID: vec2f = vec2f(384.0, 216.0);

// Cells along the sides of a picture; the same in tiles.rs.
const CELLS: vec2u = vec2u(64u, 72u);

struct SkyVertex {
    @builtin(position) position: vec4f,
    @location(0) ndc: vec2f,
    // The same for all pixels: factor on luminance …
    @location(1) @interpolate(flat) exposure: f32,
    // … and what the light of the sky-view table is to be multiplied by, for each light.
    @location(2) @interpolate(flat) from_table: vec4f,
    // Where the pixel lies in the night's grid.
    @location(3) night_uv: vec2f,
    // Of pipelines for the Moon off the horizon: logarithm of what the air leaves of it, by powers of its elevation as `moon_elevation`
    // has it.
    @location(4) @interpolate(flat) moon_ln_0: vec4f,
    @location(5) @interpolate(flat) moon_ln_1: vec4f,
    @location(6) @interpolate(flat) moon_ln_2: vec4f,
    @location(7) @interpolate(flat) moon_ln_3: vec4f,
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> SkyVertex {
    var ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    if tiled {
        let packed = view.rectangles[instance / 4u][instance % 4u];
        let low = vec2u(packed & 0xffu, (packed >> 8u) & 0xffu);
        let high = vec2u((packed >> 16u) & 0xffu, packed >> 24u);
        // Two triangles: (0,0) (1,0) (0,1), (0,1) (1,0) (1,1).
        let far = vec2<bool>(index == 1u || index == 4u || index == 5u, index == 2u || index == 3u || index == 5u);
        ndc = vec2f(select(low, high, far)) / vec2f(CELLS) * 2.0 - 1.0;
    }
    return sky_vertex_at(ndc);
}

// The vertex at a place of the target.
fn sky_vertex_at(ndc: vec2f) -> SkyVertex {
    let exposure = select(exposure_now(), frame.exposure, metering);
    let dimming = moon_dimming();
    return SkyVertex(
        vec4f(ndc, far_depth, 1.0), view.tile.xy + view.tile.zw * ndc, exposure, table_scales(),
        // Its outermost texels lie on the edges.
        ((0.5 + 0.5 * ndc) * (NIGHT_GRID - 1.0) + 0.5) / NIGHT_GRID,
        dimming[0], dimming[1], dimming[2], dimming[3]);
}

// Factor on luminance. It is chosen, not branched on: lavapipe 22.3 compiles a shader anew each time it is bound if a branch or the
// bound of a loop hangs on uniforms and constants alone (`update_inline_shader_state` in Mesa's lvp_execute.c).
fn exposure_now() -> f32 {
    let metered = textureLoad(exposure_texture, vec2i(0), 0).x * frame.compensation;
    return select(frame.exposure, metered, frame.exposure == 0.0);
}

// What the light of the sky-view table is to be multiplied by, for each light.
fn table_scales() -> vec4f {
    var scales = vec4f(0.0);
    if !marching {
        scales[0] = 1.0 / sky_view_scale(0u);
        for (var light = 1u; light < light_count; light++) {
            scales[light] = 1.0 / sky_view_scale(light);
        }
    }
    return scales;
}

// The look direction of a point of the picture in view space; it goes on beyond the edge of a fisheye, so that derivatives
// there are right.
fn look_direction(ndc: vec2f) -> vec3f {
    if linear {
        return normalize(view.ray_origin + view.ray_x * ndc.x + view.ray_y * ndc.y);
    }
    switch view.projection {
        case 1u: {
            // Fisheye: the angle from the axis grows evenly with the distance from the centre.
            let p = ndc * vec2f(view.aspect, 1.0);
            let angle = length(p) * view.half_angle;
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

// Share of a pixel (its side in ndc) that lies within the picture: the edge of a fisheye is smoothed as horizon and discs are.
fn inside(ndc: vec2f, pixel: f32) -> f32 {
    if linear || view.projection != 1u {
        return 1.0;
    }
    return clamp(0.5 + (1.0 - length(ndc * vec2f(view.aspect, 1.0))) / max(pixel, 1e-9), 0.0, 1.0);
}

// How much of the pixel the Moon covers, for the night's grid.
var<private> moon_cover: f32 = 0.0;
// As SkyVertex has it.
var<private> moon_ln: array<vec4f, 4>;

// Radiance along a ray with zenith cosine mu, all lights. `below`: whether it meets the ground.
fn sky_radiance(from_table: vec4f, ray: vec3f, dx: vec3f, dy: vec3f, mu: f32, sin_theta: f32, below: bool) -> vec4f {
    var sum = light_radiance(0u, from_table.x, ray, dx, dy, mu, sin_theta, below);
    for (var light = 1u; light < light_count; light++) {
        sum += light_radiance(light, from_table[light], ray, dx, dy, mu, sin_theta, below);
    }
    var moon = MoonLight(vec4f(0.0), 0.0);
    if with_moon && !below {
        moon = moon_light(ray, dx, dy);
        if with_horizon {
            moon.radiance *= transmittance_behind(mu, sin_theta);
        } else {
            let at = moon_elevation(mu);
            moon.radiance *= exp(moon_ln[0] + at * (moon_ln[1] + at * (moon_ln[2] + at * moon_ln[3])));
        }
        moon_cover = moon.cover;
    }
    var uncovered = 1.0 - moon.cover;
    if far_airs && !below {
        moon.radiance = moon.radiance * far_through + far_light * transmittance_behind(mu, sin_theta);
        uncovered *= dot(far_through, vec4f(0.25));
    }
    if night && !night_grid {
        sum += night_radiance(ray, mu, sin_theta, below, !marching, uncovered);
    }
    sum += moon.radiance;
    return sum;
}

// The cubic through what the air leaves of the Moon at four elevations: cheaper than a look-up in each pixel.
fn moon_dimming() -> array<vec4f, 4> {
    if !with_moon || with_horizon {
        return array<vec4f, 4>();
    }
    var at: array<vec4f, 4>;
    for (var i = 0u; i < 4u; i++) {
        let mu = sin(view.moon.lift_middle + view.moon.lift_reach * (f32(i) * 2.0 / 3.0 - 1.0));
        at[i] = log(max(transmittance_to_space(view.altitude_m, mu), vec4f(1e-30)));
    }
    // Lagrange at −1, −⅓, ⅓, 1.
    return array<vec4f, 4>(
        (9.0 * (at[1] + at[2]) - at[0] - at[3]) / 16.0, (27.0 * (at[2] - at[1]) + at[0] - at[3]) / 16.0,
        9.0 * (at[0] + at[3] - at[1] - at[2]) / 16.0, (27.0 * (at[1] - at[2]) + 9.0 * (at[3] - at[0])) / 16.0);
}

// What the air along a ray lets through of what lies behind it.
fn transmittance_behind(mu: f32, sin_theta: f32) -> vec4f {
    if marching {
        let start = enter(view.altitude_m, mu, sin_theta, 0.0, 0.0, 0.0);
        return select(transmittance_to_space(start.altitude_m, start.mu), vec4f(1.0), start.misses);
    }
    return transmittance_to_space(view.altitude_m, mu);
}

// The same of one light.
fn light_radiance(
    light: u32, from_table: f32, ray: vec3f, dx: vec3f, dy: vec3f, mu: f32, sin_theta: f32, below: bool) -> vec4f {
    var disc = vec4f(0.0);
    if with_disc && !below {
        disc = light_disc_radiance(light, ray, dx, dy);
        if far_airs {
            disc *= far_through;
        }
    }
    var radiance = vec4f(0.0);
    var through = vec4f(1.0);
    if marching {
        let sun = view.lights[light].direction;
        var start = enter(
            view.altitude_m, mu, sin_theta, view.lights[light].mu_s, clamp(dot(ray, sun), -1.0, 1.0),
            angle_between(ray, sun));
        start.direction = ray;
        start.eclipsed = light == 0u;
        let altitude = min(view.altitude_m, airs[body].top_altitude_m);
        let horizon = asin(horizon_cosine(airs[body].bottom_radius_m, altitude));
        let row = elevation_texel(asin(start.mu), horizon, below, cell_rows());
        radiance = max(march_air(start, row, frame.steps, 1e30).radiance, vec4f(0.0));
        // From the table: more exact than the product of the march's cells.
        through = transmittance_to_space(start.altitude_m, start.mu);
        through = select(through, vec4f(1.0), start.misses);
    } else {
        if with_aureole {
            radiance = from_table * sky_view_radiance(light, ray, mu, below);
        } else {
            radiance = from_table * sky_view_far(light, ray, mu, below);
        }
        if with_disc {
            through = transmittance_to_space(view.altitude_m, mu);
        }
    }
    return view.lights[light].irradiance * (radiance + through * disc);
}

// Linear Rec. 709 in cd/m² from radiance per unit irradiance.
fn rec709_of(four: vec4f) -> vec3f {
    return vec3f(
        dot(frame.rec709_from_four_r, four),
        dot(frame.rec709_from_four_g, four),
        dot(frame.rec709_from_four_b, four),
    );
}

// Luminance of a ray. The horizon is smoothed over a pixel: there the ground below and the sky above it are mixed.
// `dx`, `dy`: how the ray changes to the next pixel.
fn sky_luminance(from_table: vec4f, ray: vec3f, dx: vec3f, dy: vec3f) -> vec3f {
    let mu = dot(ray, view.up);
    let horizon = view.horizon_mu;
    if !with_horizon {
        return rec709_of(sky_radiance(from_table, ray, dx, dy, mu, length(cross(ray, view.up)), mu < horizon));
    }
    let pixel = 0.5 * (length(dx) + length(dy));
    // Height above the horizon in pixels; cosines near it differ as angles do, times the sine.
    let sine = max(sqrt(1.0 - horizon * horizon), 1e-3);
    let above = (mu - horizon) / (sine * max(pixel, 1e-9));
    let both = abs(above) < 0.5;
    // From within the air the horizon is told by the cosine, from above by the sine, R / r, which cancels nothing far
    // away.
    let sine_of_limb = airs[body].bottom_radius_m / (airs[body].bottom_radius_m + view.altitude_m);
    let own_sine = length(cross(ray, view.up));
    var four = vec4f(0.0);
    for (var i = 0u; i < select(1u, 2u, both); i++) {
        let side = select(sign(above), f32(i) * 2.0 - 1.0, both);
        // 1e-6 tells the two sides apart in f32.
        let sin_theta = select(own_sine, min(sine_of_limb * (1.0 + side * 1e-6), 1.0), both);
        let side_mu = select(mu, min(horizon + side * 1e-6, 0.0), both);
        let share = select(1.0, 0.5 + side * above, both);
        four += share * sky_radiance(from_table, ray, dx, dy, side_mu, sin_theta, side < 0.0);
    }
    if far_airs {
        four = near_light + near_through * four;
    }
    return rec709_of(four);
}

@fragment
fn sky_fragment(in: SkyVertex) -> @location(0) vec4f {
    let look = look_direction(in.ndc);
    // Derivatives are taken before anything branches. No pixel counts as wider than 0.2.
    var dx = dpdx(look);
    var dy = dpdy(look);
    dx *= min(1.0, 0.2 / max(length(dx), 1e-9));
    dy *= min(1.0, 0.2 / max(length(dy), 1e-9));
    let pixel = vec2f(abs(dpdx(in.ndc.x)), abs(dpdy(in.ndc.y)));
    let share = inside(in.ndc, pixel.y);
    if share <= select(0.0, 0.5, metering) {
        // Nothing: the corners of a fisheye.
        return vec4f(0.0);
    }
    moon_ln = array<vec4f, 4>(in.moon_ln_0, in.moon_ln_1, in.moon_ln_2, in.moon_ln_3);
    var luminance = sky_luminance(in.from_table, look, dx, dy);
    if night && night_grid {
        luminance += night_from_grid(in.night_uv, moon_cover);
    }
    if with_points {
        luminance += binned_light(in.ndc, pixel, dx, dy, in.exposure);
    }
    return pixel_colour(in, luminance, share);
}

// The glow at a place of the grid, cd/m². `cover`: how much of it the Moon covers.
fn night_from_grid(uv: vec2f, cover: f32) -> vec3f {
    let glow = textureSampleLevel(night_grid_table, linear_sampler, uv, view.night_layer, 0.0);
    return view.night_unit * (1.0 - cover * glow.a) * glow.rgb;
}

// A pixel's colour for the target. `share`: how much of the pixel lies within the picture.
fn pixel_colour(in: SkyVertex, seen: vec3f, share: f32) -> vec4f {
    var luminance = seen;
    if metering {
        return vec4f(luminance, 1.0);
    }
    luminance *= share * in.exposure;
    if finished == 0u {
        return vec4f(clamp(luminance, vec3f(-frame.largest), vec3f(frame.largest)), 1.0);
    }
    // 1e30 keeps the tone mappers finite; negative values are colours outside Rec. 709.
    var encoded = tonemap(frame.tonemap, clamp(luminance, vec3f(0.0), vec3f(1e30)), in.exposure);
    let noise = triangular_noise(vec2u(in.position.xy + view.pixel)) / max(frame.dither_levels, 1.0);
    encoded += select(vec3f(0.0), noise, frame.dither_levels > 0.0);
    encoded = clamp(encoded, vec3f(0.0), vec3f(1.0));
    if target_is_srgb {
        encoded = select(encoded, srgb_decode(encoded), frame.encoding == 2u);
    }
    return vec4f(encoded, 1.0);
}
