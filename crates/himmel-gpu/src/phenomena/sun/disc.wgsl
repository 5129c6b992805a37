// A star's disc as the air shows it: limb-darkened, flattened, with coloured rims, behind an eclipse's occluder; and the
// corona around it. Twin of himmel_air::disc. Everything comes as parameters: nothing here is bound.

//#include "phenomena/sun/bending.wgsl"
//#include "phenomena/sun/eclipse.wgsl"

struct DiscUniform {
    // Unit vector to its centre, without refraction.
    centre: vec3f,
    // Apparent radius, rad.
    radius: f32,
    // Unit vector to the zenith.
    up: vec3f,
    // Apparent radius of the occluder, rad; 0: there is none.
    occluder_radius: f32,
    // From the occluder's centre to the disc's, as a difference of unit vectors.
    from_occluder: vec3f,
    // 1: the corona is drawn.
    corona: f32,
}

const DISC_POINTS: u32 = 4u;

// Length of a vector on the sky for each wavelength: base − tangent · deviation.
fn bent_lengths(base: vec3f, along: f32, deviation: vec4f) -> vec4f {
    return sqrt(max(dot(base, base) - 2.0 * along * deviation + deviation * deviation, vec4f(0.0)));
}

// Brightness relative to the disc's mean at a distance in radii, by wavelength.
fn disc_brightness(fraction: vec4f, c: array<vec4f, 6>) -> vec4f {
    let mu = sqrt(max(1.0 - fraction * fraction, vec4f(0.0)));
    let brightness = c[0] + mu * (c[1] + mu * (c[2] + mu * (c[3] + mu * (c[4] + mu * c[5]))));
    return select(brightness, vec4f(0.0), fraction > vec4f(1.0));
}

// Radiance of disc and corona per unit irradiance of the star, 1/sr, averaged over a pixel. `ray`: unit vector of the
// pixel, as it is seen; `dx`, `dy`: how it changes to the next pixel. A disc smaller than a pixel is widened to three
// quarters of one, corona and occluder with it; their flux is kept.
fn bent_disc_radiance(ray: vec3f, dx: vec3f, dy: vec3f, disc: DiscUniform, bending: BendingUniform, c: array<vec4f, 6>) -> vec4f {
    let pixel = max(length(dx), length(dy));
    let drawn = max(disc.radius, 0.75 * pixel);
    let widened = drawn > disc.radius;
    let scale = drawn / disc.radius;
    let height = clamp(dot(ray, disc.up), -1.0, 1.0);
    let level = disc.up - ray * height;
    // In the zenith nothing is bent, in no direction.
    let tangent = level / max(length(level), 1e-6);
    let bend = bent_deviation(bending, asin(height));
    // From chords, not from dot products: f32 cosines of small angles have no digits left.
    let base = ray - disc.centre;
    let away = bent_lengths(base, dot(base, tangent), bend.xxxx).y;
    // Other colours stand up to 2 % of the deviation elsewhere.
    let reach = drawn + 2.0 * pixel + 0.05 * abs(bend.x);
    let with_corona = disc.corona > 0.0 && away < 40.0 * disc.radius;
    // A loop that ends at once, not a branch: rasterisers on CPUs skip only loops.
    let points = select(DISC_POINTS * DISC_POINTS, 0u, away > reach && !with_corona);
    var visible = vec4f(1.0);
    if widened && disc.occluder_radius > 0.0 {
        visible = visible_part(length(disc.from_occluder) / disc.radius, disc.occluder_radius / disc.radius, c);
    }
    var sum = vec4f(0.0);
    for (var i = 0u; i < points; i++) {
        let p = (vec2f(f32(i % DISC_POINTS), f32(i / DISC_POINTS)) + 0.5) / f32(DISC_POINTS) - 0.5;
        let aside = p.x * dx + p.y * dy;
        let here = base + aside;
        let deviation = (bend.x + bend.y * dot(aside, tangent)) * bending.ratio;
        let chord = bent_lengths(here, dot(here, tangent), deviation);
        let fraction = chord * (1.0 + chord * chord / 24.0) / drawn;
        var light = visible * disc_brightness(fraction, c);
        if with_corona {
            light += corona_brightness(fraction);
        }
        if disc.occluder_radius > 0.0 {
            let beside = here + scale * disc.from_occluder;
            let from_occluder = bent_lengths(beside, dot(beside, tangent), deviation);
            let hidden = from_occluder < vec4f(scale * disc.occluder_radius);
            // Of a widened disc the part that is seen is known; the corona is hidden where the occluder stands.
            light = select(light, select(vec4f(0.0), visible * disc_brightness(fraction, c), widened), hidden);
        }
        sum += light;
    }
    // 2π (1 − cos r) by its series: exact to 1e-5 up to 0.4 rad.
    let solid_angle = 3.14159265 * drawn * drawn * (1.0 - drawn * drawn / 12.0);
    return sum / (f32(DISC_POINTS * DISC_POINTS) * solid_angle);
}
