// Discs of planets over the sky: one square each. Bound as points are; what is behind is added to.

//#include "phenomena/stars/points.wgsl"
//#include "phenomena/planets/shade.wgsl"

struct PlanetUniform {
    // Unit vector to its centre without refraction, in view space; equatorial radius, rad.
    centre: vec3f,
    radius: f32,
    // Unit vectors in the sky: along the equator, along the pole.
    along_x: vec3f,
    flat_radius: f32,
    along_y: vec3f,
    // 1 with rings.
    rings: f32,
    // From the planet, in its own frame (shade.wgsl): to the Sun, the pole.
    sun: vec3f,
    // Half the square's side in radii.
    reach: f32,
    pole: vec3f,
    padding: f32,
    // Radiance of a surface that faces the Sun, above the air, relative to the preset's star at 1 au.
    four: vec4f,
}

@group(3) @binding(0) var<uniform> planet: PlanetUniform;

struct PlanetVertex {
    @builtin(position) position: vec4f,
    // From the centre in radii.
    @location(0) place: vec2f,
    // At its own corner, as all that follows.
    @location(1) light: vec3f,
    @location(2) sky: vec3f,
    @location(3) finished_sky: vec3f,
}

@vertex
fn planet_vertex(@builtin(vertex_index) vertex: u32) -> PlanetVertex {
    let right = vertex == 1u || vertex == 4u || vertex == 5u;
    let top = vertex == 2u || vertex == 3u || vertex == 5u;
    let place = vec2f(select(-1.0, 1.0, right), select(-1.0, 1.0, top)) * planet.reach;
    let direction = normalize(planet.centre + planet.radius * (place.x * planet.along_x + place.y * planet.along_y));
    let seen = lifted(direction);
    let corner = picture_place(seen);
    let exposure = exposure_now();
    let light = rec709_of(planet.four * air_transmittance(seen, dot(seen, view.up))) * exposure;
    var sky = vec3f(0.0);
    var finished_sky = vec3f(0.0);
    if finished != 0u {
        sky = sky_behind(seen) * exposure;
        finished_sky = finished_colour(sky);
    }
    let ndc = (corner.xy - view.tile.xy) / view.tile.zw;
    let hidden = corner.z < 0.5 || dot(lifted(planet.centre), view.up) < view.horizon_mu;
    return PlanetVertex(
        vec4f(select(ndc, vec2f(2.0), hidden), far_depth, 1.0), place, light, sky, finished_sky);
}

const SHADE_POINTS: u32 = 4u;

@fragment
fn planet_fragment(in: PlanetVertex) -> @location(0) vec4f {
    let dx = dpdx(in.place);
    let dy = dpdy(in.place);
    var sum = 0.0;
    for (var i = 0u; i < SHADE_POINTS * SHADE_POINTS; i++) {
        let p = (vec2f(f32(i % SHADE_POINTS), f32(i / SHADE_POINTS)) + 0.5) / f32(SHADE_POINTS) - 0.5;
        sum += planet_shade(in.place + p.x * dx + p.y * dy, planet.flat_radius, planet.sun, planet.pole, planet.rings);
    }
    let light = in.light * (sum / f32(SHADE_POINTS * SHADE_POINTS));
    if finished == 0u {
        return vec4f(min(light, vec3f(frame.largest)), 0.0);
    }
    return vec4f(finished_colour(in.sky + light) - in.finished_sky, 0.0);
}
