// The Sun's disc. Twin of himmel_air::sun.

//#include "frame/frame.wgsl"

// Brightness of the disc relative to its mean at a distance from its centre in radii, for four wavelengths.
fn relative_disc_brightness(radius_fraction: f32, c: array<vec4f, 6>) -> vec4f {
    if radius_fraction > 1.0 {
        return vec4f(0.0);
    }
    let mu = sqrt(1.0 - radius_fraction * radius_fraction);
    return c[0] + mu * (c[1] + mu * (c[2] + mu * (c[3] + mu * (c[4] + mu * c[5]))));
}

// Radiance of the disc per unit irradiance of the Sun, 1/sr. `ray`: unit vector in view space; `pixel`: angle that
// a pixel spans. The edge is smoothed over a pixel. A disc smaller than a pixel is spread over one, its flux kept.
fn sun_disc_radiance(ray: vec3f, pixel: f32) -> vec4f {
    // From the chord, not from a dot product: f32 cosines of small angles have no digits left.
    let angle = 2.0 * asin(clamp(0.5 * length(ray - view.sun_disc), 0.0, 1.0));
    let drawn = max(view.sun_radius, 0.75 * pixel);
    let cover = clamp((drawn - angle) / max(pixel, 1e-9) + 0.5, 0.0, 1.0);
    if cover <= 0.0 || view.sun_disc_visible == 0u {
        return vec4f(0.0);
    }
    let solid_angle = 2.0 * 3.14159265358979 * (1.0 - cos(min(drawn, 3.0)));
    // 1 − cos r loses its digits below 0.01 rad, where r² / 2 is exact to 1e-5.
    let safe = select(solid_angle, 3.14159265358979 * drawn * drawn, drawn < 0.05);
    return cover / safe * relative_disc_brightness(min(angle / drawn, 0.9999), frame.limb_darkening);
}
