// The host's last pass: from its HDR picture to the display. Himmel's tone mapper and dither noise stand before this text.

@group(0) @binding(0) var hdr: texture_2d<f32>;

@vertex
fn display_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// Two by two pixels become one. After tone mapping: a bright one beside a dark ridge would outshine it before.
@fragment
fn display_fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    var colour = vec3f(0.0);
    for (var i = 0u; i < 4u; i++) {
        colour += 0.25 * tonemap_neutral(max(textureLoad(hdr, 2u * pixel + vec2u(i & 1u, i >> 1u), 0).rgb, vec3f(0.0)));
    }
    return vec4f(colour + triangular_noise(pixel) / 255.0, 1.0);
}
