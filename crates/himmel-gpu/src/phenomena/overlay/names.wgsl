// Names over the sky: each letter a rectangle beside what is named, drawn from distances to its outline. It covers what is
// there: letters over a thin dark halo.

//#include "phenomena/stars/points.wgsl"

const MOST_NAMED_BODIES: u32 = 16u;
// Those of typeface.rs.
const SPREAD_EM: f32 = 0.18;
const TEXELS_PER_EM: f32 = 48.0;
// The halo: how wide, how dark on the outline.
const HALO_EM: f32 = 0.16;
const HALO: f32 = 0.85;
// Strokes of a light face are drawn wider on each side, em.
const BOLDER_EM: f32 = 0.012;
// Half of a line's height with what is free above it, em; the same in names.rs.
const HALF_LINE_EM: f32 = 0.65;

struct NameLabel {
    // Unit vector: ICRS at J2000.0, or east-north-up.
    place: vec3f,
    // Annual parallax, rad.
    parallax: f32,
    // Change of the place per Julian year.
    velocity: vec3f,
    // Magnitude; −1e9 of what is no star.
    magnitude: f32,
    // What it stands beside: 0 what turns with the stars, 1 a direction as it is seen, 2 the horizon, 3 a body.
    anchor: u32,
    // Of a body: which one; else MOST_NAMED_BODIES.
    number: u32,
    // It is shown where a radian has so many em.
    from_scale: f32,
    // Its colour among the kinds'.
    kind: u32,
    // Farthest left and right of what it names, em.
    reach: vec2f,
    padding_0: u32,
    padding_1: u32,
}

struct NameLetter {
    // Left, bottom, right, top from what is named, em.
    box_em: vec4f,
    // The same in the atlas.
    uv: vec4f,
    label: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

struct NamesUniform {
    // Columns of view-from-(east-north-up).
    view_from_enu_x: vec3f,
    // Pixels of an em.
    em_px: f32,
    view_from_enu_y: vec3f,
    // Em of a radian in the middle of the picture.
    scale: f32,
    view_from_enu_z: vec3f,
    // Faintest star with a name.
    faintest: f32,
    // Bodies in view space without refraction, apparent radius; −1: none.
    bodies: array<vec4f, 16>,
    // Ends of their discs with their names, em; how far the name is moved from the right side; 1: there is room for it.
    beside: array<vec4f, 16>,
    // By kind.
    colours: array<vec4f, 6>,
}

@group(2) @binding(8) var<storage, read> name_labels: array<NameLabel>;
@group(2) @binding(9) var<storage, read> name_letters: array<NameLetter>;
@group(2) @binding(10) var<uniform> names: NamesUniform;
@group(2) @binding(11) var name_atlas: texture_2d<f32>;
@group(2) @binding(12) var name_sampler: sampler;

struct NameVertex {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
    @location(1) @interpolate(flat) colour: vec3f,
}

@vertex
fn name_vertex(@builtin(vertex_index) vertex: u32) -> NameVertex {
    let letter = name_letters[vertex / 6u];
    let label = name_labels[letter.label];
    let star = airless_direction(label.place, label.velocity, label.parallax);
    let number = min(label.number, MOST_NAMED_BODIES - 1u);
    let body = names.bodies[number];
    let beside = names.beside[number];
    let is_body = label.anchor == 3u;
    let airless = select(star, body.xyz, is_body);
    let seen = label.place.x * names.view_from_enu_x + label.place.y * names.view_from_enu_y
        + label.place.z * names.view_from_enu_z;
    let level = normalize(seen - dot(seen, view.up) * view.up + vec3f(1e-12, 0.0, 0.0));
    let low = level * sqrt(1.0 - view.horizon_mu * view.horizon_mu) + view.horizon_mu * view.up;
    let local = select(seen, low, label.anchor == 2u);
    let is_local = label.anchor == 1u || label.anchor == 2u;
    let direction = select(lifted(airless), local, is_local);
    var place = picture_place(direction);
    // A fisheye may end where the horizon is: letters stand within its edge then.
    let on_edge = label.anchor == 2u && !linear && view.projection == 1u;
    let from_middle = length(place.xy * vec2f(view.aspect, 1.0));
    let edge = (1.0 - 1.1 * names.em_px * points.pixel.y) / max(from_middle, 1e-6);
    place = select(place, vec3f(place.xy * min(edge, 1.0), f32(from_middle < 1.1)), on_edge);

    var hidden = place.z < 0.5 || label.magnitude > names.faintest || label.from_scale > names.scale;
    hidden = hidden || (label.anchor != 2u && dot(direction, view.up) < view.horizon_mu);
    hidden = hidden || (is_body && (body.w < 0.0 || beside.w < 0.5));
    // Bodies wander: what is in the way of their discs and names gives way.
    let among = select(airless, local, is_local);
    let right_way = select(vec3f(1.0, 0.0, 0.0), normalize(cross(among, view.up) + vec3f(1e-12, 0.0, 0.0)), view.projection == 2u);
    let up_way = cross(right_way, among);
    for (var i = 0u; i < MOST_NAMED_BODIES; i++) {
        let other = names.bodies[i];
        let ends = names.beside[i];
        let away = (other.xyz - among) * names.scale;
        let across = dot(away, right_way);
        let high = HALF_LINE_EM + max(HALF_LINE_EM, other.w * names.scale);
        let meets = across + ends.x < label.reach.y && across + ends.y > -label.reach.x && abs(dot(away, up_way)) < high;
        hidden = hidden || (meets && dot(other.xyz, among) > 0.0 && other.w >= 0.0 && ends.w > 0.5 && !is_body && label.anchor != 2u);
    }

    // Beside a body's disc. A perspective draws it larger away from the middle.
    let middle = dot(direction, normalize(view.ray_origin));
    let enlarged = select(1.0, 1.0 / max(middle * middle, 0.01), linear);
    let disc = min(body.w * names.scale * names.em_px * enlarged, 0.7 / points.pixel.y);
    let corner = vertex % 6u;
    let right = corner == 1u || corner == 4u || corner == 5u;
    let top = corner == 2u || corner == 3u || corner == 5u;
    let em = vec2f(select(letter.box_em.x, letter.box_em.z, right), select(letter.box_em.y, letter.box_em.w, top));
    let uv = vec2f(select(letter.uv.x, letter.uv.z, right), select(letter.uv.y, letter.uv.w, top));
    let moved_px = vec2f(select(disc, beside.z * names.em_px - disc, beside.z < 0.0), 0.0);
    // On a fisheye's edge letters stand in the middle of their place, else below.
    let raised_px = select(vec2f(0.0), vec2f(0.0, 0.9 * names.em_px), on_edge);
    let offset = em * names.em_px + select(raised_px, moved_px, is_body);
    let ndc = (place.xy + offset * points.pixel - view.tile.xy) / view.tile.zw;
    return NameVertex(
        vec4f(select(ndc, vec2f(2.0), hidden), far_depth, 1.0), uv, names.colours[min(label.kind, 5u)].rgb);
}

@fragment
fn name_fragment(in: NameVertex) -> @location(0) vec4f {
    let texel = in.uv * vec2f(textureDimensions(name_atlas));
    // Pixels of an em, from the picture itself.
    let em_px = TEXELS_PER_EM / max(length(dpdx(texel)), 1e-6);
    let code = textureSample(name_atlas, name_sampler, in.uv).r;
    let inside = (code - 0.5) * 2.0 * SPREAD_EM + BOLDER_EM;
    let covered = clamp(inside * em_px + 0.5, 0.0, 1.0);
    let near = clamp(1.0 + inside / HALO_EM, 0.0, 1.0);
    return vec4f(in.colour * covered, max(covered, HALO * near * near));
}
