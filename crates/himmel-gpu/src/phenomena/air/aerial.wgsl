// The air between a camera and a scene: light scattered into each line of sight up to a distance, and what the air leaves
// of what is there. From all lights, as linear Rec. 709.

//#include "frame/frame.wgsl"
//#include "phenomena/air/march.wgsl"

struct ApplyUniform {
    view_from_clip: mat4x4f,
    // From view space into the host's shadow map of the first light.
    shadow_from_view: mat4x4f,
    // Of a ray in the froxels: the longest way through the air, m.
    longest_m: f32,
    // Depth where nothing was drawn.
    far_depth: f32,
    orthographic: u32,
    // Factor on in-scattered light; 0: the frame's exposure.
    exposure: f32,
}

@group(2) @binding(0) var<uniform> apply: ApplyUniform;
@group(2) @binding(3) var shadow_map: texture_depth_2d;

// Whether the first light's shafts come from the host's shadow map.
override shafts: bool = false;

// A line of sight in view space.
struct Sight {
    origin: vec3f,
    direction: vec3f,
    distance_m: f32,
}

// The line to a point of the picture at a depth of the depth buffer.
fn sight_of(ndc: vec2f, depth: f32) -> Sight {
    let homogeneous = apply.view_from_clip * vec4f(ndc, depth, 1.0);
    let place = homogeneous.xyz / homogeneous.w;
    if apply.orthographic == 0u {
        let distance_m = length(place);
        return Sight(vec3f(0.0), place / max(distance_m, 1e-6), distance_m);
    }
    // Rays are parallel; they begin in the camera's plane.
    let other = apply.view_from_clip * vec4f(ndc, select(depth + 0.25, depth - 0.25, depth > 0.5), 1.0);
    var direction = normalize(other.xyz / other.w - place);
    direction = select(direction, -direction, direction.z > 0.0);
    let distance_m = max(place.z / direction.z, 0.0);
    return Sight(place - direction * distance_m, direction, distance_m);
}

// Direction of a froxel's column, whatever the depth.
fn column_sight(ndc: vec2f) -> Sight {
    var sight = sight_of(ndc, 0.5);
    sight.distance_m = 0.0;
    return sight;
}

// Where a line of sight enters the air, under a light.
fn sight_ray(sight: Sight, light: u32) -> AirRay {
    let radius = airs[body].bottom_radius_m;
    let r = radius + view.altitude_m;
    let q = excess(radius, view.altitude_m) + 2.0 * r * dot(sight.origin, view.up) + dot(sight.origin, sight.origin);
    let altitude = max(q / (radius + sqrt(max(radius * radius + q, 0.0))), 0.0);
    let up = normalize(view.up + sight.origin / r);
    let sun = view.lights[light].direction;
    let mu = dot(sight.direction, up);
    let sine = length(cross(sight.direction, up));
    let nu = clamp(dot(sight.direction, sun), -1.0, 1.0);
    var ray = enter(altitude, mu, sine, dot(sun, up), nu, angle_between(sight.direction, sun));
    ray.direction = sight.direction;
    ray.eclipsed = light == 0u;
    return ray;
}

// Share of the first light that the host's geometry lets through at a point.
fn shadowed(light: u32, sight: Sight, t: f32) -> f32 {
    if !shafts || light != 0u {
        return 1.0;
    }
    let clip = apply.shadow_from_view * vec4f(sight.origin + sight.direction * t, 1.0);
    let place = clip.xyz / clip.w;
    let uv = vec2f(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y);
    if any(uv < vec2f(0.0)) || any(uv >= vec2f(1.0)) || place.z < 0.0 || place.z > 1.0 {
        return 1.0;
    }
    let texel = vec2i(uv * vec2f(textureDimensions(shadow_map)));
    return select(0.0, 1.0, place.z <= textureLoad(shadow_map, texel, 0) + 1e-4);
}

struct Aerial {
    // Radiance, per unit irradiance of the light; what extended things keep.
    light: vec4f,
    through: vec4f,
}

// The part of a cell that is not in the planet's shadow.
fn lit_part(dark: vec2f, from_t: f32, to_t: f32) -> f32 {
    let overlap = max(min(dark.y, to_t) - max(dark.x, from_t), 0.0);
    return 1.0 - overlap / max(to_t - from_t, 1e-9);
}

fn dark_of(ray: AirRay) -> vec2f {
    return shadow_interval(airs[body].bottom_radius_m, ray.altitude_m, ray.mu, ray.mu_s, ray.nu);
}

// How far a ray can run through the air, the ground not counted.
fn air_ends(ray: AirRay) -> f32 {
    return top_distance(airs[body].bottom_radius_m, airs[body].top_altitude_m, ray.altitude_m, ray.mu);
}

// Marches a line of sight to its distance.
fn march_sight(sight: Sight, light: u32, cells: u32, jitter: f32) -> Aerial {
    let ray = sight_ray(sight, light);
    let limit = min(sight.distance_m - ray.before_m, air_ends(ray));
    if ray.misses || limit <= 0.0 {
        return Aerial(vec4f(0.0), vec4f(1.0));
    }
    var m = begin_march(ray);
    let dark = dark_of(ray);
    var t = 0.0;
    for (var i = 0u; i < cells; i++) {
        let x = f32(i + 1u) / f32(cells);
        let next = limit * x * x;
        // Shafts are sampled within the cell, elsewhere for each pixel.
        let lit = lit_part(dark, t, next) * shadowed(light, sight, ray.before_m + mix(t, next, jitter));
        add_cell(&m, 0.5 * (t + next), next - t, lit);
        t = next;
    }
    let air = end_march(&m, vec4f(0.0));
    return Aerial(max(air.radiance, vec4f(0.0)), air.through_extended);
}

// Share of a froxel's slice along a ray, and back: crowded at the viewer.
fn slice_distance(share: f32) -> f32 {
    return apply.longest_m * share * share * share;
}

fn slice_share(t: f32) -> f32 {
    return pow(clamp(t / apply.longest_m, 0.0, 1.0), 1.0 / 3.0);
}

// Linear Rec. 709 in cd/m² from radiance per unit irradiance.
fn rec709_of(four: vec4f) -> vec3f {
    return vec3f(
        dot(frame.rec709_from_four_r, four),
        dot(frame.rec709_from_four_g, four),
        dot(frame.rec709_from_four_b, four),
    );
}

// What the air leaves of a colour: that of an even reflector in the light of the first sun.
fn rec709_through(through: vec4f) -> vec3f {
    let white = view.lights[0].irradiance;
    return clamp(rec709_of(through * white) / max(rec709_of(white), vec3f(1e-12)), vec3f(0.0), vec3f(1.0));
}
