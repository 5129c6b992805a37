// The planet's surface, lit by the Sun and by the sky above it. The march adds it where a ray ends on the ground.

//#include "phenomena/air/medium.wgsl"

// Radiance that leaves the ground, per unit irradiance of the Sun, 1/sr. sun, sky: what an eclipse leaves of either.
fn ground_radiance(mu_s: f32, sun: vec4f, sky: vec4f) -> vec4f {
    let direct = select(vec4f(0.0), scaled_to_space(0.0, mu_s) * mu_s, mu_s > 0.0);
    return airs[body].ground_albedo / PI * (sun * direct + sky * ground_sky_irradiance(mu_s));
}
