// How the light of a point spreads: twins of stars/model.rs, same names, order and units. Nothing here is bound.

// The core: a cubic B-spline. Its samples on any grid of step 1 sum to 1 and have the point itself as their centroid.
fn core_weight(x: f32) -> f32 {
    let a = abs(x);
    let outer = max(2.0 - a, 0.0);
    return select(outer * outer * outer / 6.0, 2.0 / 3.0 - a * a * (1.0 - 0.5 * a), a < 1.0);
}

// Glare per steradian at an angle (rad) from the point: inverse cube and inverse square, softened within `soft`.
fn glare_per_sr(glare: vec2f, theta: f32, soft: f32) -> f32 {
    let u = 1.0 / (theta + soft);
    return u * u * (glare.x * u + glare.y);
}

// The angle at which glare has fallen to a value; three steps of a fixed point are exact to a few per cent.
fn glare_reach(glare: vec2f, value: f32, soft: f32) -> f32 {
    var u = sqrt(glare.y / value);
    for (var i = 0; i < 3; i++) {
        u = sqrt((glare.y + glare.x / max(u, soft)) / value);
    }
    return max(u - soft, 0.0);
}

// Share of the light in the glare within a radius, its value at the rim taken off.
fn glare_share(glare: vec2f, radius: f32, soft: f32) -> f32 {
    let end = radius + soft;
    let cube = glare.x * (0.5 / soft - (radius + 0.5 * soft) / (end * end));
    let square = glare.y * (log(end / soft) + soft / end - 1.0);
    return 6.28318531 * (cube + square) - 3.14159265 * radius * radius * glare_per_sr(glare, radius, soft);
}

// Fine rays of the eye's lens around a bright point: mean 1 over the circle, never below 0.
fn ciliary_corona(direction: vec2f, seed: f32) -> f32 {
    let phi = atan2(direction.y, direction.x);
    var sum = 1.0;
    let waves = array<f32, 6>(7.0, 11.0, 19.0, 29.0, 41.0, 53.0);
    for (var i = 0u; i < 6u; i++) {
        sum += cos(waves[i] * phi + 6.28318531 * fract(seed * (f32(i) + 1.61803399))) / 6.0;
    }
    return sum;
}

// Air mass to a direction by the sine of its elevation [rozenberg1966].
fn air_mass(sine: f32) -> f32 {
    let s = max(sine, 0.0);
    return 1.0 / (s + 0.025 * exp(-11.0 * s));
}

// Four waves of scintillation for each wavelength. `phases`: now, in turns; `own`: the point's; `growth`: of the waves with
// the way that lies apart.
fn four_waves(phases: vec4f, own: vec4f, growth: vec4f, apart: vec4f) -> vec4f {
    let at = 6.28318531 * (phases + own);
    let turned = 6.28318531 * apart;
    return cos(at.x + growth.x * turned) + cos(at.y + growth.y * turned) + cos(at.z + growth.z * turned)
        + cos(at.w + growth.w * turned);
}

// What scintillation makes of each wavelength's light. `sigma`: its standard deviation at the zenith at 550 nm; `low`, `high`:
// phases of its eight waves now; `shift`: how far the wavelengths' ways lie apart, in sizes of the pattern, over tan z sec z.
fn twinkle(seed: f32, sine: f32, sigma: f32, low: vec4f, high: vec4f, shift: vec4f, strength: vec4f) -> vec4f {
    let mass = air_mass(sine);
    let apart = shift * mass * mass * sqrt(max(1.0 - sine * sine, 0.0));
    let index = vec4f(0.0, 1.0, 2.0, 3.0);
    let own_low = fract(seed * (0.7548776662 + 0.5698402910 * index));
    let own_high = fract(seed * (0.7548776662 + 0.5698402910 * (index + 4.0)));
    // Waves of 0.5 to 1.4 times the pattern's size. Eight waves of ½ each: variance 4.
    let wave = four_waves(low, own_low, 0.5 + 0.125 * index, apart)
        + four_waves(high, own_high, 1.0 + 0.125 * index, apart);
    let deviation = min(sigma * pow(mass, 1.75), 1.0) * strength;
    let log_variance = log(1.0 + deviation * deviation);
    return exp(0.5 * wave * sqrt(log_variance) - 0.5 * log_variance);
}

// The core of the thesis, by the distance in its radii [mueller2012, §4.3.2].
fn thesis_core(l: f32) -> f32 {
    let x = min(l, 1.0);
    return 1.0 + x * x * (2.0 * x - 3.0);
}

// Its glare, by the distance in radii of the billboard.
fn thesis_glare(l: f32) -> f32 {
    return 1.0 - pow(clamp(l, 1e-6, 1.0), 0.0625);
}
