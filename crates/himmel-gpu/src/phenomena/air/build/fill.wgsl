// Sums a radiance over the sphere for one Sun of one row: a workgroup for each texel of the moment table.

//#include "phenomena/air/build/build.wgsl"

// Suns lower than this (8° under the level) get the finer set of directions.
const DEEP_SINE: f32 = -0.13917310096;
const WIDTH: u32 = 64u;

@group(2) @binding(0) var<storage, read_write> rays: array<vec4f>;
// The order that is computed, the one before, the sum of all, each a texel of SEVEN vectors.
@group(2) @binding(1) var<storage, read_write> moments: array<vec4f>;
// ln G, ratios, ln of the irradiance from above: the order before, as it is looked up.
@group(2) @binding(2) var<storage, read_write> stored: array<vec4f>;
// Largest change by each order, as the bits of a float.
@group(2) @binding(3) var<storage, read_write> changes: array<atomic<u32>, 256>;

var<workgroup> partial: array<vec4f, 448>;
var<private> seven: array<vec4f, 7>;

// Whether an earlier order has changed so little that this one is not needed.
fn converged() -> bool {
    if build.order < 2u {
        return false;
    }
    return bitcast<f32>(atomicLoad(&changes[build.order - 1u])) < build.tolerance;
}

fn add_light(light: vec4f, weight: f32, x: f32, z: f32) {
    // Light travels against the look direction: F changes its sign.
    let w = weight * light;
    seven[0] += w;
    seven[1] -= w * x;
    seven[2] -= w * z;
    seven[3] += w * (x * x - 1.0 / 3.0);
    seven[4] += w * (z * z - 1.0 / 3.0);
    seven[5] += w * (x * z);
    seven[6] += w * max(z, 0.0);
}

// Adds up what the invocations have, and writes the texel.
fn write_texel(lane: u32, row: u32, column: u32) {
    for (var m = 0u; m < SEVEN; m++) {
        partial[m * WIDTH + lane] = seven[m];
    }
    workgroupBarrier();
    if lane < SEVEN {
        var sum = vec4f(0.0);
        for (var i = 0u; i < WIDTH; i++) {
            sum += partial[lane * WIDTH + i];
        }
        moments[(row * build.columns + column) * SEVEN + lane] = sum;
    }
}

// The directions of a Sun: first ray, rays, azimuths.
fn directions_of(mu_s: f32) -> vec3u {
    if mu_s < DEEP_SINE {
        return vec3u(build.up + build.down, build.deep_up + build.deep_down, build.deep_azimuths);
    }
    return vec3u(0u, build.up + build.down, build.azimuths);
}

// A ray with an azimuth, under a Sun.
struct Look {
    base: u32,
    ray: u32,
    mu: f32,
    x: f32,
    weight: f32,
    end: f32,
    nu: f32,
    through: vec4f,
    hits_ground: bool,
    ground_mu_s: f32,
}

fn look_of(row: u32, directions: vec3u, index: u32, h0: f32, mu_s: f32) -> Look {
    var look: Look;
    look.ray = directions.x + index / directions.z;
    let azimuth = index % directions.z;
    look.base = ray_base(row, look.ray);
    let head = rays[look.base];
    look.mu = head.x;
    look.x = head.y * cos(PI * (f32(azimuth) + 0.5) / f32(directions.z));
    look.weight = head.z * 2.0 * PI / f32(directions.z);
    look.end = head.w;
    look.nu = clamp(look.mu * mu_s + look.x * sqrt(max(1.0 - mu_s * mu_s, 0.0)), -1.0, 1.0);
    look.through = rays[look.base + 1u];
    look.hits_ground = rays[look.base + 2u].x > 0.5;
    let radius = airs[body].bottom_radius_m;
    look.ground_mu_s = clamp(((radius + h0) * mu_s + look.end * look.nu) / radius, -1.0, 1.0);
    return look;
}
