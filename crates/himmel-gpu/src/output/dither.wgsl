// Noise that hides the steps of an 8-bit target. Twin in output/dither.rs.

// A number 0..1 from a pixel and a channel (PCG hash in three dimensions [jarzynski2020]).
fn hash_unit(pixel: vec3u) -> vec3f {
    var v = pixel * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    // 24 bits: every value is exact in f32.
    return vec3f(v >> vec3u(8u)) / 16777216.0;
}

// Triangular noise of ±1 step: its mean and variance do not depend on the signal. Fixed in the picture, not in time.
fn triangular_noise(pixel: vec2u) -> vec3f {
    return hash_unit(vec3u(pixel, 0u)) - hash_unit(vec3u(pixel, 1u));
}
