// The host's own geometry: matt blocks under the Sun and the sky that Himmel tells of, in cd/m² times exposure.

struct Scene {
    clip_from_world: mat4x4f,
    // Unit vector towards the Sun, y up.
    sun_direction: vec4f,
    // Linear Rec. 709, lx: on a surface that faces the Sun, on a level one from the sky, on a downward one from the ground.
    sun_lx: vec4f,
    sky_lx: vec4f,
    ground_lx: vec4f,
}

@group(0) @binding(0) var<uniform> scene: Scene;
// Red is the factor that the sky is exposed with.
@group(0) @binding(1) var exposure: texture_2d<f32>;

struct Block {
    @location(0) centre: vec3f,
    @location(1) half_size: vec3f,
    @location(2) heading_rad: f32,
    @location(3) albedo: vec3f,
}

struct Vertex {
    @builtin(position) position: vec4f,
    @location(0) normal: vec3f,
    @location(1) albedo: vec3f,
}

// Clockwise as seen from above, as compasses count: north is −z, east +x.
fn turn(v: vec3f, heading_rad: f32) -> vec3f {
    let c = cos(heading_rad);
    let s = sin(heading_rad);
    return vec3f(c * v.x - s * v.z, v.y, s * v.x + c * v.z);
}

// A cube from nothing but the index: six faces of two triangles, counter-clockwise from outside.
@vertex
fn block_vertex(@builtin(vertex_index) index: u32, block: Block) -> Vertex {
    let face = index / 6u;
    let corner = index % 6u;
    let side = select(-1.0, 1.0, face >= 3u);
    let u = side * select(-1.0, 1.0, corner == 1u || corner >= 4u);
    let v = select(-1.0, 1.0, corner == 2u || corner == 3u || corner == 5u);
    var point = vec3f(side, u, v);
    var normal = vec3f(side, 0.0, 0.0);
    for (var axis = face % 3u; axis > 0u; axis--) {
        point = point.zxy;
        normal = normal.zxy;
    }
    let world = block.centre + turn(point * block.half_size, block.heading_rad);
    return Vertex(scene.clip_from_world * vec4f(world, 1.0), turn(normal, block.heading_rad), block.albedo);
}

@fragment
fn block_fragment(in: Vertex) -> @location(0) vec4f {
    let normal = normalize(in.normal);
    let from_sun = scene.sun_lx.rgb * max(dot(normal, scene.sun_direction.xyz), 0.0);
    // Half of what a wall sees is sky, the other half ground.
    let from_around = mix(scene.ground_lx.rgb, scene.sky_lx.rgb, 0.5 + 0.5 * normal.y);
    let luminance = in.albedo / 3.14159265 * (from_sun + from_around);
    return vec4f(luminance * textureLoad(exposure, vec2u(0), 0).r, 1.0);
}
