// The Moon's disc. Twin of phenomena/moon/model.rs: same names, same order, same units.

//#include "frame/frame.wgsl"
//#include "frame/sphere.wgsl"

// Relative albedo over selenographic longitude (−π..π) and latitude (from the north); with a map of normals slopes to east and north
// as 0..1 in g and b, with heights km in g.
@group(1) @binding(7) var moon_ground: texture_2d<f32>;
@group(1) @binding(8) var moon_sampler: sampler;
// Logarithm of what is left of sunlight in the Earth's shadow, over the distance from its axis.
@group(1) @binding(9) var moon_shadow: texture_2d<f32>;

// Points along a pixel's side: small discs need more for their terminator. Relief of the ground: 0 none, 1 by normals, 2 by heights.
// Whether the Earth's shadow may be on it.
override moon_side: u32 = 4u;
override moon_relief: u32 = 0u;
override moon_eclipsed: bool = true;

// As in heights.rs: steps of the way to the horizon grow by a factor and see the mean of ground as wide as a share of the way.
const STEP: f32 = 1.2;
const WIDTH_OF_STEP: f32 = 0.1;
// Under a higher Sun (its tangent) the craters' walls cast no shadow.
const STEEPEST: f32 = 0.6;
const RADIUS_KM: f32 = 1737.4;
// Tangent of the Sun's apparent radius.
const SUN_TAN: f32 = 0.00465;

// What the Moon sends along a ray, and how much of the pixel it covers.
struct MoonLight {
    radiance: vec4f,
    cover: f32,
}

// µ₀/(µ₀ + µ), 0 where the source is below the horizon   [seeliger1887]
fn lommel_seeliger(mu_0: f32, mu: f32) -> f32 {
    let lit = max(mu_0, 0.0);
    return lit / max(lit + mu, 1e-6);
}

// The normal of the sphere where a ray meets it. `aside`: what of the ray is across the direction of the centre; `sine` of
// the sphere's apparent radius. Rays that miss get the nearest point of the limb.
fn sphere_normal(aside: vec3f, centre: vec3f, sine: f32) -> vec3f {
    let sin_2 = min(dot(aside, aside), sine * sine);
    let near = sqrt(1.0 - sin_2) - sqrt(max(sine * sine - sin_2, 0.0));
    var across = aside * (near / sine);
    across *= min(1.0, 0.99999 / max(length(across), 1e-9));
    return across - centre * sqrt(max(1.0 - dot(across, across), 0.0));
}

// Elevation of a ray (by its sine) in the span of the disc, −1..1.
fn moon_elevation(sine: f32) -> f32 {
    return clamp((asin(clamp(sine, -1.0, 1.0)) - view.moon.lift_middle) / view.moon.lift_reach, -1.0, 1.0);
}

fn moon_light(ray: vec3f, dx: vec3f, dy: vec3f) -> MoonLight {
    let centre = view.moon.centre;
    let pixel = max(length(dx), length(dy));
    let sine = max(view.moon.sine, 0.75 * pixel);
    // A disc smaller than a pixel is widened, its flux kept.
    let thin = view.moon.sine * view.moon.sine / (sine * sine);
    let height = clamp(dot(ray, view.up), -1.0, 1.0);
    let level = view.up - ray * height;
    let tangent = level / max(length(level), 1e-6);
    let at = moon_elevation(height);
    let lift = view.moon.lift;
    // Deviation, and how it changes with elevation.
    let bend = vec2f(
        lift.x + at * (lift.y + at * (lift.z + at * lift.w)),
        (lift.y + at * (2.0 * lift.z + at * 3.0 * lift.w)) / view.moon.lift_reach);
    // From chords, not from dot products: f32 cosines of small angles have no digits left.
    let base = ray - tangent * bend.x - centre;
    let across = base - centre * dot(base, centre);
    let touched = dot(across, across) < (sine + pixel) * (sine + pixel) && dot(base, base) < 2.0;
    if moon_side == 1u {
        return moon_sample(base, centre, vec3f(0.0), tangent, bend.y, sine, pixel, thin, touched);
    }
    // A loop that ends at once, not a branch: rasterisers on CPUs skip only loops.
    var sum = MoonLight(vec4f(0.0), 0.0);
    for (var i = 0u; i < select(0u, moon_side * moon_side, touched); i++) {
        let p = (vec2f(f32(i % moon_side), f32(i / moon_side)) + 0.5) / f32(moon_side) - 0.5;
        let light = moon_sample(base, centre, p.x * dx + p.y * dy, tangent, bend.y, sine, pixel, thin, true);
        sum.radiance += light.radiance;
        sum.cover += light.cover;
    }
    return sum;
}

// One point's share of a pixel: `shift` off its middle.
fn moon_sample(
    base: vec3f, centre: vec3f, shift: vec3f, tangent: vec3f, bend: f32, sine: f32, pixel: f32, thin: f32, touched: bool,
) -> MoonLight {
    let here = base + shift - tangent * (bend * dot(shift, tangent));
    let aside = here - centre * dot(here, centre);
    let off = length(aside);
    let half = 0.5 * pixel / f32(moon_side);
    let cover = select(0.0, clamp(0.5 + 0.5 * (sine - off) / half, 0.0, 1.0), touched);
    // On the limb the middle of the part that is covered shines for all of it.
    let seen = select(off, clamp(0.5 * (off - half + sine), 0.0, sine), off + half > sine);
    let normal = sphere_normal(aside * (seen / max(off, 1e-9)), centre, sine);
    let mu = sqrt(max(1.0 - seen * seen / (sine * sine), 0.0));
    let share = cover * thin / f32(moon_side * moon_side);
    let eye = -normalize(centre + aside * (seen / max(off, 1e-9)));
    return MoonLight(share * moon_radiance(normal, eye, mu, pixel / (sine * f32(moon_side))), share);
}

fn moon_ground_at(uv: vec2f, level: f32) -> vec4f {
    return textureSampleLevel(moon_ground, moon_sampler, uv, level);
}

// Slopes to east and north. `arc`: width of a texel of the level, in radii; `here`: the map at the place.
fn moon_slopes(uv: vec2f, cos_lat: f32, level: f32, arc: f32, here: f32) -> vec2f {
    let east = vec2f(arc * 0.15915494 / cos_lat, 0.0);
    let north = vec2f(0.0, -arc * 0.31830989);
    let there = vec2f(moon_ground_at(uv + east, level).y, moon_ground_at(uv + north, level).y);
    return (there - here) * (view.moon.relief / arc);
}

// Where a pixel's ground lies, for the way to its horizon.
struct MoonPlace {
    uv: vec2f,
    // Of the latitude.
    cosine: f32,
    tangent: f32,
    // Height in radii; level of the map, and the width of its finest texel in radii.
    height: f32,
    level: f32,
    texel: f32,
}

// Tangent of the elevation of the horizon. `towards`: unit vector to the light in east and north; `tan_light`: of its elevation,
// beyond which nothing is looked for; `near`: slope towards it.
fn moon_horizon(place: MoonPlace, arc: f32, towards: vec2f, tan_light: f32, near: f32) -> f32 {
    let k = view.moon.relief;
    let rise = max(view.moon.highest - place.height, 0.0);
    let looked_for = tan_light < STEEPEST * RADIUS_KM * k && tan_light > view.moon.darkest_tan;
    let furthest = select(0.0, sqrt(tan_light * tan_light + 2.0 * rise) - tan_light, looked_for);
    var horizon = near;
    for (var way = arc; way < furthest; way *= STEP) {
        // The great circle to second order.
        let east = towards.x * (1.0 + way * towards.y * place.tangent) / place.cosine;
        let north = towards.y - 0.5 * way * towards.x * towards.x * place.tangent;
        let there = place.uv + way * vec2f(east * 0.15915494, -north * 0.31830989);
        // One level of the map alone: half the work.
        let level = round(max(place.level, log2(WIDTH_OF_STEP * way / place.texel)));
        horizon = max(horizon, (moon_ground_at(there, level).y * k - place.height) / way - 0.5 * way);
    }
    return horizon;
}

// What of the Sun's disc stands above a horizon; tangents of elevations.
fn sun_above(tan_light: f32, horizon: f32) -> f32 {
    return smoothstep(0.0, 1.0, (tan_light - horizon) / SUN_TAN * 0.5 + 0.5);
}

// A vector of view space in the Moon's frame.
fn moon_own(v: vec3f) -> vec3f {
    return vec3f(dot(view.moon.body_x.xyz, v), dot(view.moon.body_y.xyz, v), dot(view.moon.body_z.xyz, v));
}

// Radiance of the ground. `normal`: of the sphere; `eye`: unit vector to the observer, `mu` its cosine; `footprint`: of the pixel, in
// radii.
fn moon_radiance(normal: vec3f, eye: vec3f, mu: f32, footprint: f32) -> vec4f {
    let own = moon_own(normal);
    let width = textureDimensions(moon_ground).x;
    let level = map_level(width, footprint, mu);
    let uv = map_uv(own);
    let ground = moon_ground_at(uv, level);
    let albedo = ground.x * view.moon.albedo_scale;
    let smooth_mu_0 = dot(normal, view.moon.to_sun);
    var mu_0 = smooth_mu_0;
    var mu_seen = mu;
    if moon_relief == 2u {
        // In the Moon's frame: parts to east and north of a vector v are v.y x − v.x y and v.z − z (v · own), over the cosine of the
        // latitude.
        let cos_lat = max(sqrt(max(1.0 - own.z * own.z, 0.0)), 0.035);
        let sun = moon_own(view.moon.to_sun);
        let sun_level = sqrt(max(1.0 - smooth_mu_0 * smooth_mu_0, 1e-8));
        let tan_sun = smooth_mu_0 / sun_level;
        let aside = vec2f(sun.y * own.x - sun.x * own.y, sun.z - own.z * smooth_mu_0) / cos_lat;
        let towards = aside / sun_level;
        let texel = 6.2831853 / f32(width);
        let arc = texel * exp2(level);
        let slopes = moon_slopes(uv, cos_lat, level, arc, ground.y);
        let place = MoonPlace(uv, cos_lat, own.z / cos_lat, ground.y * view.moon.relief, level, texel);
        let horizon = moon_horizon(place, arc, towards, tan_sun, dot(slopes, towards));
        let eye_own = moon_own(eye);
        let eye_aside = vec2f(eye_own.y * own.x - eye_own.x * own.y, eye_own.z - own.z * mu) / cos_lat;
        // Cosines to the Sun and to the eye on the slope.
        let steep = inverseSqrt(1.0 + dot(slopes, slopes));
        let tilted = vec2f(smooth_mu_0 - dot(slopes, aside), mu - dot(slopes, eye_aside)) * steep;
        // A slope that turns from the eye hides behind others: those that are seen have at least half the sphere's cosine.
        let turn = max(0.5 * mu - tilted.y, 0.0);
        let seen = (tilted + turn * vec2f(dot(eye, view.moon.to_sun), 1.0))
            * inverseSqrt(1.0 + turn * (2.0 * tilted.y + turn));
        // Where the Sun's horizon hides the ground from the eye too, what is seen is lit.
        let eye_level = sqrt(max(1.0 - mu * mu, 1e-8));
        let hidden = max(dot(eye_aside, towards), 0.0) / eye_level * (1.0 - sun_above(mu / eye_level, horizon));
        let lit = max(sun_above(tan_sun, horizon), hidden);
        mu_0 = select(0.0, max(seen.x, 0.0) * lit, tan_sun > view.moon.darkest_tan);
        mu_seen = seen.y;
    }
    if moon_relief == 1u {
        let slopes = (ground.yz * 255.0 - 128.0) / 127.0;
        let north = normalize(view.moon.body_z.xyz - normal * own.z + vec3f(1e-9));
        let east = cross(north, normal);
        let tilted = normalize(normal + view.moon.relief * (slopes.x * east + slopes.y * north));
        // Mountains are lit up to 4° beyond the terminator of the sphere.
        mu_0 = max(dot(tilted, view.moon.to_sun), 0.0) * smoothstep(-0.07, 0.02, smooth_mu_0);
    }
    var shade = vec4f(1.0);
    if moon_eclipsed {
        let from_axis = view.moon.offset + normal - view.moon.axis * dot(normal, view.moon.axis);
        let x = min(length(from_axis) * view.moon.texels_per_radius, view.moon.shadow_texels - 1.001);
        let texel = u32(x);
        let ln = mix(
            textureLoad(moon_shadow, vec2u(texel, 0u), 0), textureLoad(moon_shadow, vec2u(texel + 1u, 0u), 0),
            x - f32(texel));
        shade = exp(ln);
    }
    let mu_e = dot(normal, view.moon.to_earth);
    return albedo * (view.moon.sunlit * shade * lommel_seeliger(mu_0, mu_seen)
        + view.moon.earthlit * lommel_seeliger(mu_e, mu));
}
