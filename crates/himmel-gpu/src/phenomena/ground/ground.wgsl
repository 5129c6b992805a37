// The planet's surface, lit by the Sun and by the sky above it. The march adds it where a ray ends on the ground.

//#include "phenomena/air/medium.wgsl"

// Albedo where a ray meets another body.
var<private> far_albedo: vec4f;

// Radiance that leaves the ground, per unit irradiance of the Sun, 1/sr. sun, sky: what an eclipse leaves of either.
fn ground_radiance(mu_s: f32, sun: vec4f, sky: vec4f) -> vec4f {
    let direct = select(vec4f(0.0), scaled_to_space(0.0, mu_s) * mu_s, mu_s > 0.0);
    let albedo = select(airs[body].ground_albedo, far_albedo, far_airs && body != 0u);
    return albedo / PI * (sun * direct + sky * ground_sky_irradiance(mu_s));
}
