// What an eye makes of luminance: rods and cones. Twins in himmel-core's vision.rs and output/eye.rs.

// Scotopic luminance from linear Rec. 709, fitted to black bodies; see `scotopic_from_rec709`.
const SCOTOPIC_FROM_REC709: vec3f = vec3f(0.014067471, 1.4072090, 0.97690664);
// V′ at 555 nm, 683 / 1699.
const SCOTOPIC_AT_555: f32 = 0.40200117;
// The retina's own light, cd/m².
const EIGENGRAU: f32 = 1e-5;
const LUMINANCE_WEIGHTS: vec3f = vec3f(0.2126, 0.7152, 0.0722);

// Linear Rec. 709 of (0.25, 0.25) at luminance 1: the blue that painters give to the night [jensen2000].
const NIGHT_BLUE: vec3f = vec3f(0.70636524, 0.98983398, 1.9655962);

fn log10(x: f32) -> f32 {
    return log2(x) * 0.30103;
}

// x: CIE 191's adaptation coefficient; y: mesopic luminance, cd/m².
fn mesopic(photopic: f32, scotopic: f32) -> vec2f {
    let p = max(photopic, 0.0);
    let s = max(scotopic, 0.0);
    var m = 0.5;
    var luminance = 0.0;
    for (var i = 0; i <= 6; i++) {
        luminance = (m * p + (1.0 - m) * s * SCOTOPIC_AT_555) / (m + (1.0 - m) * SCOTOPIC_AT_555);
        if i < 6 {
            m = clamp(0.7670 + 0.3334 * log10(max(luminance, 1e-12)), 0.0, 1.0);
        }
    }
    return vec2f(m, luminance);
}

// The smallest step that cones see on a background, cd/m².
fn cone_threshold(background: f32) -> f32 {
    let x = log10(max(background, 1e-12));
    let low = pow(max(0.249 * x + 0.65, 0.0), 2.7) - 0.72;
    return exp2(3.3219281 * select(select(low, x - 1.255, x >= 1.9), -0.72, x <= -2.6));
}

// The same of rods, both scotopic.
fn rod_threshold(background: f32) -> f32 {
    let x = log10(max(background, 1e-12));
    let low = pow(max(0.405 * x + 1.6, 0.0), 2.18) - 2.86;
    return exp2(3.3219281 * select(select(low, x - 0.395, x >= -1.44), -2.86, x <= -3.94));
}

// How many thresholds a background is bright, over what it is by day.
fn brightness(photopic: f32, scotopic: f32) -> f32 {
    let p = max(photopic, 0.0);
    let s = max(scotopic, 0.0) + EIGENGRAU;
    // 10^1.255 is Weber's day.
    return min(length(vec2f(p / cone_threshold(p), s / rod_threshold(s))) / 17.98871, 1.0);
}

// What is seen of a luminance (linear Rec. 709, cd/m²): mesopic luminance with as much of the colour as cones give, and
// the retina's own light. `rod_colour`: what light seen by rods looks like, at luminance 1; white is what they report.
fn seen_by_eye(rgb: vec3f, rod_colour: vec3f) -> vec3f {
    let photopic = dot(rgb, LUMINANCE_WEIGHTS);
    let rods = dot(rgb, SCOTOPIC_FROM_REC709) + EIGENGRAU;
    let seen = mesopic(photopic, rods);
    let colour = select(vec3f(1.0), rgb / photopic, photopic > 0.0);
    return seen.y * mix(rod_colour, colour, seen.x);
}
