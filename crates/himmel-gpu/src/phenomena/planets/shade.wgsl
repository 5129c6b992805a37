// A planet's disc: twins of planets/model.rs, same names, order and units. Nothing here is bound.
//
// Lengths are in equatorial radii; x along the equator's major axis in the sky, y along the projected pole, z to the
// observer. `pole` = (0, cos B, sin B).

// Optical depth and brightness of the rings by distance from the planet's axis: C, B, Cassini's division, A.
fn ring_at(rho: f32) -> vec2f {
    if rho < 1.2388 || rho > 2.2694 {
        return vec2f(0.0);
    }
    if rho < 1.5265 {
        return vec2f(0.10, 0.45);
    }
    if rho < 1.9510 {
        return vec2f(1.8, 1.0);
    }
    if rho < 2.0271 {
        return vec2f(0.12, 0.5);
    }
    return vec2f(0.50, 0.8);
}

// Brightness of globe and rings relative to a surface that faces the Sun. `flat_radius`: apparent polar radius.
// `rings`: 1 with rings, else 0.
fn planet_shade(place: vec2f, flat_radius: f32, sun: vec3f, pole: vec3f, rings: f32) -> f32 {
    var light = 0.0;
    var globe_z = -1e3;
    let squeezed = vec2f(place.x, place.y / flat_radius);
    let inside = dot(squeezed, squeezed);
    if inside < 1.0 {
        let normal = vec3f(squeezed, sqrt(1.0 - inside));
        globe_z = normal.z;
        light = max(dot(normal, sun), 0.0);
        // The rings' shadow.
        let height = dot(normal, pole);
        let slope = dot(sun, pole);
        if rings > 0.0 && height * slope < 0.0 {
            let met = normal - sun * (height / slope);
            light *= exp(-ring_at(length(met)).x / max(abs(slope), 0.01));
        }
    }
    let tilt = pole.z;
    if rings > 0.0 && abs(tilt) > 1e-3 {
        let at = vec3f(place, -place.y * pole.y / tilt);
        let ring = ring_at(length(at));
        if ring.x > 0.0 && at.z > globe_z {
            let mu = abs(tilt);
            let mu_s = abs(dot(sun, pole));
            let along = dot(at, sun);
            let dark = along < 0.0 && length(at - along * sun) < 1.0;
            // Light scattered once by the lit side; the other side is nearly dark.
            let lit = select(0.08, 1.0, tilt * dot(sun, pole) > 0.0);
            let depth = ring.x * (1.0 / mu + 1.0 / max(mu_s, 0.01));
            let bright = 1.9 * ring.y * lit * mu_s / (mu_s + mu) * (1.0 - exp(-depth));
            light = light * exp(-ring.x / mu) + select(bright, 0.0, dark);
        }
    }
    return light;
}
