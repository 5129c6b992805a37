// The Sun's disc. Twin of himmel_air::sun.

//#include "frame/frame.wgsl"
//#include "phenomena/sun/disc.wgsl"

// Brightness of the disc relative to its mean at a distance from its centre in radii, for four wavelengths.
fn relative_disc_brightness(radius_fraction: f32, c: array<vec4f, 6>) -> vec4f {
    if radius_fraction > 1.0 {
        return vec4f(0.0);
    }
    let mu = sqrt(1.0 - radius_fraction * radius_fraction);
    return c[0] + mu * (c[1] + mu * (c[2] + mu * (c[3] + mu * (c[4] + mu * c[5]))));
}

// Samples along each side of a pixel that the disc touches.
const DISC_SAMPLES: u32 = 4u;

// Radiance of the disc per unit irradiance of the Sun, 1/sr, averaged over a pixel. `ray`: unit vector in view space;
// `dx`, `dy`: how it changes to the next pixel. A disc smaller than a pixel is widened to three quarters of one, its flux
// kept; 4 × 4 points smooth the edge and hold the flux of a picture within some per cent.
fn sun_disc_radiance(ray: vec3f, dx: vec3f, dy: vec3f) -> vec4f {
    let pixel = max(length(dx), length(dy));
    let drawn = max(view.sun_radius, 0.75 * pixel);
    // From chords, not from dot products: f32 cosines of small angles have no digits left.
    let offset = ray - view.sun_disc;
    if view.sun_disc_visible == 0u || length(offset) > drawn + pixel {
        return vec4f(0.0);
    }
    var sum = vec4f(0.0);
    for (var i = 0u; i < DISC_SAMPLES * DISC_SAMPLES; i++) {
        let p = (vec2f(f32(i % DISC_SAMPLES), f32(i / DISC_SAMPLES)) + 0.5) / f32(DISC_SAMPLES) - 0.5;
        let chord = length(offset + p.x * dx + p.y * dy);
        let angle = 2.0 * asin(clamp(0.5 * chord, 0.0, 1.0));
        sum += relative_disc_brightness(angle / drawn, frame.limb_darkening);
    }
    let solid_angle = 2.0 * 3.14159265358979 * (1.0 - cos(min(drawn, 3.0)));
    // 1 − cos r loses its digits below 0.01 rad, where r² π is exact to 1e-5.
    let safe = select(solid_angle, 3.14159265358979 * drawn * drawn, drawn < 0.05);
    return sum / (f32(DISC_SAMPLES * DISC_SAMPLES) * safe);
}
