// How much of the Sun passes a body that stands before it: twins of himmel_air::eclipse, same names, order and units.
// Separation d and occluder's radius b are in radii of the Sun. Everything comes as parameters: nothing here is bound.

// Nodes u and weights of Gauss and Legendre on 0..1, times 6u(1 − u): see visible_part.
const ECLIPSE_NODES: array<vec2f, 8> = array<vec2f, 8>(
    vec2f(0.019855072, 0.005909979),
    vec2f(0.101666761, 0.060930601),
    vec2f(0.237233795, 0.170299343),
    vec2f(0.408282679, 0.262860077),
    vec2f(0.591717321, 0.262860077),
    vec2f(0.762766205, 0.170299343),
    vec2f(0.898333239, 0.060930601),
    vec2f(0.980144928, 0.005909979),
);

// Texels of the eclipse table: inside (rings), then from contact to contact.
const ECLIPSE_INSIDE: f32 = 16.0;
const ECLIPSE_CROSSING: f32 = 96.0;

// Where an occluder stands relative to the camera; vectors in the frame that the caller works in.
struct ShadowUniform {
    // What of the vector to its centre is across the Sun's direction, m.
    across_m: vec3f,
    // What of it is along the Sun's direction, m.
    along_m: f32,
    // Unit vector to the Sun, without refraction.
    sun: vec3f,
    radius_m: f32,
    // Apparent radius of the Sun, rad.
    sun_radius: f32,
    // 1 − distance of the occluder over the Sun's.
    parallax: f32,
    padding: vec2f,
}

fn outer_flux(mu: f32, c: array<vec4f, 6>) -> vec4f {
    let sum = c[0] + mu * (c[1] / 1.5 + mu * (c[2] / 2.0 + mu * (c[3] / 2.5 + mu * (c[4] / 3.0 + mu * c[5] / 3.5))));
    return sum * mu * mu;
}

fn visible_part(d: f32, b: f32, c: array<vec4f, 6>) -> vec4f {
    if d >= 1.0 + b || b <= 0.0 {
        return vec4f(1.0);
    }
    if d <= b - 1.0 {
        return vec4f(0.0);
    }
    let r0 = abs(d - b);
    let r1 = min(d + b, 1.0);
    let width = r1 - r0;
    let beyond = d + b - r1;
    let gap = 1.0 - r1;
    var sum = outer_flux(sqrt(max(gap * (1.0 + r1), 0.0)), c);
    if d > b {
        sum += 1.0 - outer_flux(sqrt(max((1.0 - r0) * (1.0 + r0), 0.0)), c);
    }
    for (var i = 0u; i < 8u; i++) {
        let u = ECLIPSE_NODES[i].x;
        let from_inner = width * u * u * (3.0 - 2.0 * u);
        let to_outer = width * (1.0 - u) * (1.0 - u) * (1.0 + 2.0 * u);
        let r = r0 + from_inner;
        let mu = sqrt((gap + to_outer) * (1.0 + r));
        let covered = select(r0 + r, from_inner, d >= b);
        let bare = select(from_inner, r0 + r, d >= b);
        // 1 − φ/π; 2/π.
        let share = 0.63661977 * atan2(sqrt(bare * (d + r + b)), sqrt(covered * (beyond + to_outer)));
        let brightness = c[0] + mu * (c[1] + mu * (c[2] + mu * (c[3] + mu * (c[4] + mu * c[5]))));
        sum += ECLIPSE_NODES[i].y * width * 2.0 * r * share * brightness;
    }
    return clamp(sum, vec4f(0.0), vec4f(1.0));
}

// Separation of the centres and radius of the occluder, as seen from a point at an offset from the camera, m.
fn shadow_discs(shadow: ShadowUniform, offset_m: vec3f) -> vec2f {
    let forward_m = dot(offset_m, shadow.sun);
    let aside_m = length(shadow.across_m - (offset_m - shadow.sun * forward_m) * shadow.parallax);
    let along_m = shadow.along_m - forward_m;
    // In radii of the occluder: squares of metres to the Sun's distance would come near the end of f32.
    let aside = aside_m / shadow.radius_m;
    let along = along_m / shadow.radius_m;
    let sine = 1.0 / max(sqrt(aside * aside + along * along), 1.0);
    // WGSL lets atan2 and asin err by 4096 units in the last place. Their series are exact where eclipses happen.
    let tangent = aside / max(along, 1e-9);
    let near = along > 0.0 && tangent < 0.1;
    let separation = select(atan2(aside, along), tangent * (1.0 - tangent * tangent / 3.0), near);
    let radius = select(asin(sine), sine * (1.0 + sine * sine / 6.0), sine < 0.1);
    return vec2f(separation, radius) / shadow.sun_radius;
}

// What of the Sun's light passes the occluder on its way to a point.
fn eclipse_fraction_at(shadow: ShadowUniform, offset_m: vec3f, c: array<vec4f, 6>) -> vec4f {
    let discs = shadow_discs(shadow, offset_m);
    return visible_part(discs.x, discs.y, c);
}

// Where a separation stands in the eclipse table, in texels.
fn eclipse_table_coordinate(d: f32, b: f32) -> f32 {
    let d0 = abs(1.0 - b);
    let d1 = 1.0 + b;
    if d < d0 {
        return (ECLIPSE_INSIDE - 1.0) * select(1.0, d / d0, b < 1.0);
    }
    let u = clamp((d - d0) / max(d1 - d0, 1e-12), 0.0, 1.0);
    return ECLIPSE_INSIDE + 0.63661977 * atan2(sqrt(u), sqrt(1.0 - u)) * (ECLIPSE_CROSSING - 1.0);
}

// The same as eclipse_fraction_at from the frame's table (one row of 112 texels). `table_b`: the radius it is made for.
fn eclipse_fraction_from(table: texture_2d<f32>, table_b: f32, shadow: ShadowUniform, offset_m: vec3f) -> vec4f {
    let discs = shadow_discs(shadow, offset_m);
    let x = eclipse_table_coordinate(discs.x, discs.y);
    let i = min(u32(x), u32(ECLIPSE_INSIDE + ECLIPSE_CROSSING) - 2u);
    let visible = mix(textureLoad(table, vec2u(i, 0u), 0), textureLoad(table, vec2u(i + 1u, 0u), 0), x - f32(i));
    let ring = min(discs.y, 1.0) / min(table_b, 1.0);
    return 1.0 - ring * ring * (1.0 - visible);
}

// Mean of the fraction over a level disc around a point: for light that is scattered more than once. `up`: the zenith.
fn eclipse_fraction_blurred(
    table: texture_2d<f32>,
    table_b: f32,
    shadow: ShadowUniform,
    offset_m: vec3f,
    up: vec3f,
    radius_m: f32,
) -> vec4f {
    // Any level direction; the one that is not nearly the zenith.
    let x = normalize(cross(up, select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(up.x) > 0.5)));
    let y = cross(up, x);
    var sum = 0.25 * eclipse_fraction_from(table, table_b, shadow, offset_m);
    for (var i = 0u; i < 6u; i++) {
        let angle = 1.04719755 * f32(i);
        // √⅔ of the radius.
        let aside = 0.81649658 * radius_m * (x * cos(angle) + y * sin(angle));
        sum += 0.125 * eclipse_fraction_from(table, table_b, shadow, offset_m + aside);
    }
    return sum;
}

// Radiance of the corona relative to the mean of the Sun's disc, at distances from its centre in radii (one for each
// wavelength: the air bends them apart).
fn corona_brightness(rho: vec4f) -> vec4f {
    let q = 1.0 / max(rho, vec4f(1.0));
    let sum = 3.670 * pow(q, vec4f(18.0)) + 1.939 * pow(q, vec4f(7.8)) + 0.0551 * pow(q, vec4f(2.5));
    return select(1e-6 * sum, vec4f(0.0), rho < vec4f(1.0));
}
