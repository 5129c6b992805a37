// Other bodies than the one that the camera stands on or above: rectangles over the sky, in which every pixel is drawn anew with
// all bodies along its ray. Each is a lit sphere, with its own air before it if it has some.

//#include "sky.wgsl"

struct FarLightUniform {
    // From the body to a sun, in view space.
    direction: vec3f,
    padding: f32,
    // Irradiance there relative to the preset's star at 1 au.
    irradiance: vec4f,
}

struct FarBodyUniform {
    // Unit vector to the centre without refraction, in view space; its distance, m.
    centre: vec3f,
    distance_m: f32,
    // Rows of the body's frame from view space: z to its north pole, x to longitude 0.
    body_x: vec4f,
    body_y: vec4f,
    body_z: vec4f,
    // Of ground where the map is white.
    albedo: vec4f,
    radius_m: f32,
    // Of the top of its air; 0 without.
    top_m: f32,
    // Of the camera above its ground.
    altitude_m: f32,
    // From the camera to its limb.
    limb_m: f32,
    // Sine of the apparent radius of the top of its air; 1 within.
    sine: f32,
    // Which air; 0: none.
    air: u32,
    station: u32,
    // Which map.
    map: u32,
    light_count: u32,
    // Whether it stands before the air and the ground that the camera is above.
    is_near: u32,
    // Whether the camera is in its air.
    within: u32,
    padding: u32,
    lights: array<FarLightUniform, 4>,
    // Low and high corner of what it touches, ndc of the target.
    rectangle: vec4f,
}

struct BodiesUniform {
    // The nearest first.
    bodies: array<FarBodyUniform, 3>,
    // Reflectance at the four wavelengths of red, green and blue ground.
    four_from_red: vec4f,
    four_from_green: vec4f,
    four_from_blue: vec4f,
    count: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(2) @binding(0) var<uniform> far: BodiesUniform;
// Albedo over longitude (−π..π) and latitude (from the north).
@group(2) @binding(1) var far_map_0: texture_2d<f32>;
@group(2) @binding(2) var far_map_1: texture_2d<f32>;
@group(2) @binding(3) var far_map_2: texture_2d<f32>;
@group(2) @binding(4) var far_sampler: sampler;

@vertex
fn bodies_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> SkyVertex {
    let rectangle = far.bodies[instance].rectangle;
    // Two triangles: (0,0) (1,0) (0,1), (0,1) (1,0) (1,1).
    let high = vec2<bool>(index == 1u || index == 4u || index == 5u, index == 2u || index == 3u || index == 5u);
    return sky_vertex_at(select(rectangle.xy, rectangle.zw, high));
}

@fragment
fn bodies_fragment(in: SkyVertex) -> @location(0) vec4f {
    let look = look_direction(in.ndc);
    var dx = dpdx(look);
    var dy = dpdy(look);
    dx *= min(1.0, 0.2 / max(length(dx), 1e-9));
    dy *= min(1.0, 0.2 / max(length(dy), 1e-9));
    if !follow_bodies(look, dx, dy) {
        discard;
    }
    let share = inside(in.ndc, abs(dpdy(in.ndc.y)));
    if share <= select(0.0, 0.5, metering) {
        return vec4f(0.0);
    }
    return pixel_colour(in, sky_luminance(in.from_table, look, dx, dy), share);
}

// Fills what sky.wgsl asks of a pixel's other bodies; false where there is none.
fn follow_bodies(look: vec3f, dx: vec3f, dy: vec3f) -> bool {
    far_light = vec4f(0.0);
    far_through = vec4f(1.0);
    near_light = vec4f(0.0);
    near_through = vec4f(1.0);
    var any = false;
    // A bound of uniforms alone would cost lavapipe a compilation a frame: no unit vector is as long as 2.
    for (var i = 0u; i < select(far.count, 0u, look.z > 2.0); i++) {
        let seen = pixel_of_body(i, look, dx, dy);
        any = any || seen.touched;
        if far.bodies[i].is_near != 0u {
            near_light += near_through * seen.radiance;
            near_through *= seen.through;
        } else {
            far_light += far_through * seen.radiance;
            far_through *= seen.through;
        }
    }
    return any;
}

// What a body sends along a ray, and what it lets through of what is behind it.
struct Seen {
    radiance: vec4f,
    through: vec4f,
    touched: bool,
}

// The mean over a pixel.
fn pixel_of_body(i: u32, look: vec3f, dx: vec3f, dy: vec3f) -> Seen {
    let centre = far.bodies[i].centre;
    let sine = far.bodies[i].sine;
    let within = far.bodies[i].within != 0u;
    let pixel = max(length(dx), length(dy));
    // A disc smaller than a pixel is widened, its flux kept.
    let wide = max(1.0, 0.75 * pixel / sine);
    // The air that the camera is in lifts what is behind it.
    let height = clamp(dot(look, view.up), -1.0, 1.0);
    let level = view.up - look * height;
    let tangent = level / max(length(level), 1e-6);
    let is_near = far.bodies[i].is_near != 0u;
    var bend = bent_deviation(frame.bending, asin(height));
    bend = select(bend, vec2f(0.0), is_near || within);
    // From chords, not from dot products: f32 cosines of small angles have no digits left.
    let base = look - tangent * bend.x - centre;
    let across = base - centre * dot(base, centre);
    let cosine = 1.0 + dot(base, centre);
    let reach = sine * wide + pixel;
    let touched = within || (dot(across, across) < reach * reach && cosine > 0.0);

    // Points in a pixel: many for small discs with their terminator, some at the limb, one elsewhere.
    let footprint_m = pixel * far.bodies[i].limb_m;
    let radius_m = far.bodies[i].radius_m;
    let top_m = far.bodies[i].top_m;
    let beside_m = far.bodies[i].distance_m * length(across) - radius_m;
    let at_limb = abs(beside_m) < 1.5 * footprint_m || (beside_m > 0.0 && footprint_m > top_m / 64.0);
    // Fibonacci's lattices: along an edge of any direction no two of their points come at once.
    var count = select(vec2u(1u, 0u), vec2u(34u, 21u), at_limb);
    count = select(count, vec2u(55u, 34u), radius_m < 8.0 * footprint_m);
    var sum = Seen(vec4f(0.0), vec4f(0.0), touched);
    let points = select(0u, count.x, touched);
    let point_m = footprint_m * inverseSqrt(f32(count.x));
    for (var p = 0u; p < points; p++) {
        let place = (vec2f(f32(p), f32(p * count.y % count.x)) + 0.5) / f32(count.x) - 0.5;
        let shift = place.x * dx + place.y * dy;
        let here = base + shift - tangent * (bend.y * dot(shift, tangent));
        let aside = (here - centre * dot(here, centre)) / wide;
        let seen = ray_of_body(i, aside, 1.0 + dot(here, centre), point_m);
        sum.radiance += seen.radiance;
        sum.through += seen.through;
    }
    if points == 0u {
        sum.through = vec4f(1.0);
        return sum;
    }
    let share = 1.0 / f32(points);
    let thin = 1.0 / (wide * wide);
    sum.radiance *= share * thin;
    sum.through = vec4f(1.0) - thin * (vec4f(1.0) - sum.through * share);
    return sum;
}

// One ray. `aside`: what of it is across the direction of the centre; `cosine` of its angle to it.
fn ray_of_body(i: u32, aside: vec3f, cosine: f32, footprint_m: f32) -> Seen {
    let centre = far.bodies[i].centre;
    let distance_m = far.bodies[i].distance_m;
    let radius_m = far.bodies[i].radius_m;
    let top_m = far.bodies[i].top_m;
    let within = far.bodies[i].within != 0u;
    let sine_2 = min(dot(aside, aside), 1.0);
    let along = sqrt(1.0 - sine_2) * select(-1.0, 1.0, cosine > 0.0);
    let impact_m = distance_m * sqrt(sine_2);
    let r_top = radius_m + top_m;
    if !within && (impact_m >= r_top || cosine <= 0.0) {
        return Seen(vec4f(0.0), vec4f(1.0), false);
    }
    // From the body's centre: the point of the ray that is nearest to it, the start of its way through the air.
    let direction = normalize(centre * along + aside);
    let nearest = distance_m * (aside * along - centre * sine_2);
    let root_top = sqrt(max((r_top - impact_m) * (r_top + impact_m), 0.0));
    let start_m = select(top_m, far.bodies[i].altitude_m, within);
    let r = radius_m + start_m;
    let mu = select(-root_top / r, -along, within);
    let start = select(nearest - direction * root_top, -centre * distance_m, within);
    let meets_ground = impact_m < radius_m && cosine > 0.0;
    let root = sqrt(max((radius_m - impact_m) * (radius_m + impact_m), 0.0));
    let normal = normalize(nearest - direction * root);
    far_albedo = vec4f(0.0);
    if meets_ground {
        far_albedo = albedo_of_body(i, normal, footprint_m / radius_m, root / radius_m);
    }
    var seen = Seen(vec4f(0.0), vec4f(1.0), true);
    if far.bodies[i].air == 0u {
        for (var l = 0u; l < far.bodies[i].light_count; l++) {
            let mu_s = max(dot(normal, far.bodies[i].lights[l].direction), 0.0);
            seen.radiance += far.bodies[i].lights[l].irradiance * far_albedo * (mu_s / PI);
        }
        seen.through = vec4f(select(1.0, 0.0, meets_ground));
        return seen;
    }
    body = far.bodies[i].air;
    far_station = far.bodies[i].station;
    let horizon = asin(horizon_cosine(radius_m, start_m));
    let row = elevation_texel(asin(clamp(mu, -1.0, 1.0)), horizon, meets_ground, cell_rows());
    for (var l = 0u; l < far.bodies[i].light_count; l++) {
        let sun = far.bodies[i].lights[l].direction;
        let ray = AirRay(
            start_m, mu, clamp(dot(start, sun) / r, -1.0, 1.0), clamp(dot(direction, sun), -1.0, 1.0),
            angle_between(direction, sun), 0.0, false, direction, false);
        let march = march_air(ray, row, frame.steps, 1e30);
        seen.radiance += far.bodies[i].lights[l].irradiance * max(march.radiance, vec4f(0.0));
    }
    let behind = transmittance_to_space(start_m, mu);
    seen.through = select(behind, vec4f(0.0), meets_ground);
    body = 0u;
    return seen;
}

// Of its ground. `footprint`: of the pixel, in radii; `mu`: cosine to the observer.
fn albedo_of_body(i: u32, normal: vec3f, footprint: f32, mu: f32) -> vec4f {
    let own = vec3f(
        dot(far.bodies[i].body_x.xyz, normal), dot(far.bodies[i].body_y.xyz, normal),
        dot(far.bodies[i].body_z.xyz, normal));
    let uv = map_uv(own);
    var rgb = vec3f(0.0);
    switch far.bodies[i].map {
        case 0u: {
            rgb = textureSampleLevel(far_map_0, far_sampler, uv, map_level(textureDimensions(far_map_0).x, footprint, mu)).rgb;
        }
        case 1u: {
            rgb = textureSampleLevel(far_map_1, far_sampler, uv, map_level(textureDimensions(far_map_1).x, footprint, mu)).rgb;
        }
        default: {
            rgb = textureSampleLevel(far_map_2, far_sampler, uv, map_level(textureDimensions(far_map_2).x, footprint, mu)).rgb;
        }
    }
    let four = rgb.r * far.four_from_red + rgb.g * far.four_from_green + rgb.b * far.four_from_blue;
    return clamp(far.bodies[i].albedo * four, vec4f(0.0), vec4f(1.0));
}
