// Lines over the sky: each piece a square along it, its edges smoothed over a pixel. Added to the picture.

//#include "phenomena/stars/points.wgsl"

struct LineSegment {
    // Ends: unit vectors; colour, linear Rec. 709 of white.
    start: vec3f,
    red: f32,
    end: vec3f,
    green: f32,
    blue: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

// Whether the pieces are lifted by refraction: those that turn with the stars.
override refracted: bool = true;

@group(2) @binding(4) var<storage, read> line_segments: array<LineSegment>;

struct LineVertex {
    @builtin(position) position: vec4f,
    // Across the line in pixels.
    @location(0) across: f32,
    @location(1) @interpolate(flat) colour: vec3f,
    @location(2) @interpolate(flat) half_width: f32,
}

fn line_direction(place: vec3f) -> vec3f {
    let direction = place.x * points.view_from_list_x + place.y * points.view_from_list_y + place.z * points.view_from_list_z;
    if refracted {
        return lifted(direction);
    }
    return direction;
}

@vertex
fn line_vertex(@builtin(vertex_index) vertex: u32) -> LineVertex {
    let piece = line_segments[vertex / 6u];
    let from_direction = line_direction(piece.start);
    let to_direction = line_direction(piece.end);
    let a = picture_place(from_direction);
    let b = picture_place(to_direction);
    let corner = vertex % 6u;
    let far = corner == 1u || corner == 4u || corner == 5u;
    let side = select(-1.0, 1.0, corner == 2u || corner == 3u || corner == 5u);
    // In pixels, so that the line is equally wide in every direction.
    let along = normalize((b.xy - a.xy) / points.pixel + vec2f(1e-12, 0.0));
    // `glare_floor` holds the width, `seeing` the strength: see overlay/pass.rs.
    let half_width = 0.5 * points.glare_floor;
    let reach = half_width + 1.0;
    let offset = vec2f(-along.y, along.x) * side * reach * points.pixel;
    let place = select(a.xy, b.xy, far) + offset;
    let torn = a.z < 0.5 || b.z < 0.5 || length(b.xy - a.xy) > 0.7;
    let below = dot(from_direction, view.up) < view.horizon_mu && dot(to_direction, view.up) < view.horizon_mu;
    let ndc = (place - view.tile.xy) / view.tile.zw;
    return LineVertex(
        vec4f(select(ndc, vec2f(2.0), torn || below), far_depth, 1.0), side * reach,
        vec3f(piece.red, piece.green, piece.blue) * points.seeing, half_width);
}

@fragment
fn line_fragment(in: LineVertex) -> @location(0) vec4f {
    let covered = clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    return vec4f(in.colour * covered, 0.0);
}
