// The light of points in the sky's own pixels, read from bins of the picture (bins.wgsl).

//#include "phenomena/stars/psf.wgsl"

// Whether pixels read points.
override with_points: bool = false;

// What draws a view's wide points, before its bins.
const DRAW_WORDS: u32 = 4u;

@group(3) @binding(1) var<storage, read> bins_of_points: array<u32>;
@group(3) @binding(2) var<storage, read> points_in_bins: array<vec4f>;

// Luminance at a place of the picture, linear Rec. 709 in cd/m². `step`: sides of a pixel in ndc.
fn binned_light(ndc: vec2f, step: vec2f) -> vec3f {
    let sides = vec2f(view.point_bins);
    let place = vec2u(clamp((0.5 + 0.5 * ndc) * sides, vec2f(0.0), sides - 1.0));
    let bin = view.point_bins_first + DRAW_WORDS + place.y * view.point_bins.x + place.x;
    let end = bins_of_points[bin + 1u];
    let per_px = 1.0 / max(step, vec2f(1e-30));
    var sum = vec3f(0.0);
    for (var i = bins_of_points[bin]; i < end; i++) {
        let point = points_in_bins[2u * i];
        var offset = ndc - point.xy;
        if !linear {
            // Across the seam of an equirectangular picture.
            offset.x -= select(0.0, 2.0 * round(0.5 * offset.x), view.projection == 2u);
        }
        let at = offset * per_px * point.zw;
        sum += core_weight(at.x) * core_weight(at.y) * points_in_bins[2u * i + 1u].rgb;
    }
    return sum * per_px.x * per_px.y;
}
