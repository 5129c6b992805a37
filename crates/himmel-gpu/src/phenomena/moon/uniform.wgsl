// The Moon as a view sees it. Field order and sizes are mirrored in phenomena/moon/pass.rs; a test compares the offsets.

struct MoonUniform {
    // Unit vector to its centre without refraction, in view space as all of these.
    centre: vec3f,
    // Sine of its apparent radius.
    sine: f32,
    // Unit vector from it to the Sun.
    to_sun: vec3f,
    // Factor on the slopes of the map of normals; radii of the Moon for a km of the map of heights.
    relief: f32,
    // Unit vector from it to the Earth.
    to_earth: vec3f,
    // Relative albedo of a texel of 1.
    albedo_scale: f32,
    // Unit vector along the axis of the Earth's shadow, away from the Sun.
    axis: vec3f,
    // Texels of the shadow's table for a radius of the Moon; 0: no eclipse.
    texels_per_radius: f32,
    // From the axis to the Moon's centre, in its radii.
    offset: vec3f,
    // Texels of the shadow's table.
    shadow_texels: f32,
    // Rows of the Moon's own frame (x to the middle of the near side, z north) from view space.
    body_x: vec4f,
    body_y: vec4f,
    body_z: vec4f,
    // How the air lifts what is seen around it: deviation = Σ c_k x^k, rad, x = elevation − middle over reach, within −1..1.
    lift: vec4f,
    // Middle and reach, rad.
    lift_middle: f32,
    lift_reach: f32,
    // Height of the highest ground, radii.
    highest: f32,
    // Tangent of the elevation of a Sun that lights not even that.
    darkest_tan: f32,
    // Radiance of ground with relative albedo 1 for µ₀/(µ₀ + µ) = 1: in sunlight, in the Earth's light.
    sunlit: vec4f,
    earthlit: vec4f,
}
