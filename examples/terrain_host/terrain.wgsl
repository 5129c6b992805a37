// The host's own ground: relief under the Sun and the sky that Himmel tells of, in cd/m² times exposure, without any air in front.

struct Scene {
    // From metres east, north, up of the camera.
    clip_from_enu: mat4x4f,
    shadow_from_enu: mat4x4f,
    // Towards the Sun; w: size of a texel of the shadow map, m.
    sun: vec4f,
    // Centre of the planet.
    centre: vec4f,
    // Albedos, linear Rec. 709. w, in this order: height of the water (m); where meadows end; where snow begins; tangent of
    // the steepest slope that holds soil or snow.
    water: vec4f,
    low: vec4f,
    high: vec4f,
    rock: vec4f,
    snow: vec4f,
    // Linear Rec. 709, lx, by the Sun's altitude: on a surface that faces it, then on a level one from the sky.
    sun_lx: array<vec4f, LIGHTS>,
    sky_lx: array<vec4f, LIGHTS>,
}

@group(0) @binding(0) var<uniform> scene: Scene;
// Red is the factor that the sky is exposed with.
@group(0) @binding(1) var exposure: texture_2d<f32>;
@group(0) @binding(2) var shadow_map: texture_depth_2d;
@group(0) @binding(3) var shadow_sampler: sampler_comparison;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) height_m: f32,
}

@vertex
fn shadow_vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return scene.shadow_from_enu * vec4f(position, 1.0);
}

@vertex
fn terrain_vertex(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) height_m: f32) -> Surface {
    return Surface(scene.clip_from_enu * vec4f(position, 1.0), position, normal, height_m);
}

fn ground_albedo(height_m: f32, steepness: f32) -> vec3f {
    if height_m <= scene.water.w {
        return scene.water.rgb;
    }
    let bare = smoothstep(0.7 * scene.snow.w, 1.1 * scene.snow.w, steepness);
    var soil = mix(scene.low.rgb, scene.high.rgb, smoothstep(-300.0, 300.0, height_m - scene.low.w));
    soil = mix(soil, scene.snow.rgb, smoothstep(-200.0, 200.0, height_m - scene.high.w));
    return mix(soil, scene.rock.rgb, bare);
}

// Share of the Sun that the relief leaves, over nine texels; 1 beyond the map.
fn sunlit(position: vec3f, normal: vec3f) -> f32 {
    // Lifted off the surface, so that it does not shade itself.
    let at = scene.shadow_from_enu * vec4f(position + 1.5 * scene.sun.w * normal, 1.0);
    if any(abs(at.xy) > vec2f(1.0)) || at.z < 0.0 || at.z > 1.0 {
        return 1.0;
    }
    let uv = vec2f(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.y);
    let texel = 1.0 / f32(textureDimensions(shadow_map).x);
    var sum = 0.0;
    for (var y = -1.0; y <= 1.0; y += 1.0) {
        for (var x = -1.0; x <= 1.0; x += 1.0) {
            sum += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + texel * vec2f(x, y), at.z);
        }
    }
    return sum / 9.0;
}

// Entries lie evenly in √|altitude|, closest at the horizon; `light_altitude_deg` in main.rs is the inverse.
fn light_entry(sine: f32) -> f32 {
    let altitude = degrees(asin(clamp(sine, -1.0, 1.0))) / 90.0;
    let at = (sign(altitude) * sqrt(abs(altitude)) - LIGHT_LOW) / (1.0 - LIGHT_LOW);
    return clamp(at, 0.0, 1.0) * f32(LIGHTS - 1);
}

@fragment
fn terrain_fragment(in: Surface) -> @location(0) vec4f {
    let up = normalize(in.position - scene.centre.xyz);
    let normal = normalize(in.normal);
    let upwards = clamp(dot(normal, up), -1.0, 1.0);
    let steepness = sqrt(1.0 - upwards * upwards) / max(upwards, 1e-3);
    let albedo = ground_albedo(in.height_m, steepness);

    // Far around the planet the Sun stands elsewhere in the sky.
    let sine = dot(up, scene.sun.xyz);
    let entry = light_entry(sine);
    let below = min(u32(entry), LIGHTS - 2u);
    let sun_lx = mix(scene.sun_lx[below].rgb, scene.sun_lx[below + 1u].rgb, entry - f32(below));
    let sky_lx = mix(scene.sky_lx[below].rgb, scene.sky_lx[below + 1u].rgb, entry - f32(below));

    let from_sun = sun_lx * max(dot(normal, scene.sun.xyz), 0.0) * sunlit(in.position, normal);
    // What a slope sees is sky above and ground of its own kind below.
    let ground_lx = albedo * (sun_lx * max(sine, 0.0) + sky_lx);
    let from_around = mix(ground_lx, sky_lx, 0.5 + 0.5 * upwards);
    let luminance = albedo / 3.14159265 * (from_sun + from_around);
    // 60,000 keeps rgba16float finite; only snow that someone overexposes on purpose comes near.
    return vec4f(min(luminance * textureLoad(exposure, vec2u(0), 0).r, vec3f(60000.0)), 1.0);
}
