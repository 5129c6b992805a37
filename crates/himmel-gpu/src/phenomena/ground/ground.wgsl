// The planet's surface, lit by the Sun and by the sky above it. The march adds it where a ray ends on the ground.

//#include "phenomena/air/medium.wgsl"

// Radiance that leaves the ground, per unit irradiance of the Sun, 1/sr.
fn ground_radiance(mu_s: f32) -> vec4f {
    return airs[body].ground_albedo / PI * ground_irradiance(mu_s);
}
