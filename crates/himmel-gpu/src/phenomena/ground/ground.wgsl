// The planet's surface, lit by the Sun and by the sky above it.

//#include "phenomena/air/tables.wgsl"

// Radiance that leaves the ground, per unit irradiance of the Sun, 1/sr.
fn ground_radiance(mu_s: f32) -> vec4f {
    let sun = select(vec4f(0.0), transmittance_to_space(0.0, mu_s) * mu_s, mu_s > 0.0);
    return frame.ground_albedo / PI * (sun + ground_sky_irradiance(mu_s));
}
