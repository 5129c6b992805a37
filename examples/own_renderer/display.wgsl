// The host's last pass: from its HDR picture to the display. Himmel's tone mapper and dither noise stand before this text.

@group(0) @binding(0) var hdr: texture_2d<f32>;
// Left, top, right, bottom of the inset in pixels.
override inset_left: f32;
override inset_top: f32;
override inset_right: f32;
override inset_bottom: f32;

@vertex
fn display_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn display_fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    // Distance into the inset; a line of two pixels around it.
    let inside = min(position.xy - vec2f(inset_left, inset_top), vec2f(inset_right, inset_bottom) - position.xy);
    let depth = min(inside.x, inside.y);
    if depth > -2.0 && depth < 0.0 {
        return vec4f(0.9);
    }
    let colour = max(textureLoad(hdr, pixel, 0).rgb, vec3f(0.0));
    return vec4f(tonemap_neutral(colour) + triangular_noise(pixel) / 255.0, 1.0);
}
