// The discs of the lights of a view.

//#include "frame/frame.wgsl"
//#include "phenomena/sun/disc.wgsl"

// Whether something stands before the first light's disc.
override occluded: bool = true;

// Radiance of a light's disc per unit irradiance of the light, 1/sr, averaged over a pixel; with the first light's corona
// and what stands before it. `ray`: unit vector in view space; `dx`, `dy`: how it changes to the next pixel.
fn light_disc_radiance(light: u32, ray: vec3f, dx: vec3f, dy: vec3f) -> vec4f {
    var disc = DiscUniform(
        view.lights[light].direction, view.lights[light].radius, view.up, 0.0, vec3f(0.0), 0.0);
    if light == 0u && occluded {
        disc = view.disc;
    }
    let visible = f32(view.lights[light].disc_visible);
    return visible * bent_disc_radiance(ray, dx, dy, disc, frame.bending, frame.limb_darkening);
}
