// The least that a frame can be: one colour on every pixel.

@vertex
fn empty_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn empty_fragment() -> @location(0) vec4f {
    return vec4f(0.25, 0.5, 0.75, 1.0);
}
