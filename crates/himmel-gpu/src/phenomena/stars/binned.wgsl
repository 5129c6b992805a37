// The light of points in the sky's own pixels, read from bins of the picture (bins.wgsl).

//#include "phenomena/stars/psf.wgsl"

// Whether pixels read points; whether points have glare.
override with_points: bool = false;
override with_glare: bool = false;

// Texels, counted along rows of `BINNED_WIDTH`. Of each view's bins: where the points begin and end. Then points: place in the bin, light.
@group(3) @binding(0) var binned_points: texture_2d<u32>;

const BINNED_WIDTH: u32 = 1024u;

fn binned_texel(index: u32) -> vec2u {
    return vec2u(index % BINNED_WIDTH, index / BINNED_WIDTH);
}

// A point in a bin: its place in sizes of the bin from the lower left corner, −1 to 2; 1 / widening of its core; light over the solid
// angle of ndc, linear Rec. 709. Luminance keeps all its digits, colours eleven bits.
fn pack_point(place: vec2f, per_widen: vec2f, light: vec3f) -> vec4u {
    let luminance = dot(light, vec3f(0.2126, 0.7152, 0.0722));
    return vec4u(
        pack2x16unorm((place + 1.0) / 3.0), pack2x16float(per_widen), bitcast<u32>(luminance),
        pack2x16float(light.rb / max(luminance, 1e-37)));
}

// The angle of a pixel's height away from the middle of the picture, where it is least, rad.
fn radial_pixel(ndc: vec2f, height: f32) -> f32 {
    if linear {
        let ray = view.ray_origin + view.ray_x * ndc.x + view.ray_y * ndc.y;
        return height * length(view.ray_y) / dot(ray, ray);
    }
    return height * select(0.5 * PI, view.half_angle, view.projection == 1u);
}

// Luminance at a place of the picture, linear Rec. 709 in cd/m². `step`: sides of a pixel in ndc; `dx`, `dy`: how the ray changes
// along them; `exposure`: factor on luminance.
fn binned_light(ndc: vec2f, step: vec2f, dx: vec3f, dy: vec3f, exposure: f32) -> vec3f {
    let sides = vec2f(view.point_bins);
    let scaled = (0.5 + 0.5 * ndc) * sides;
    let bin = clamp(floor(scaled), vec2f(0.0), sides - 1.0);
    let index = view.point_bins_first + u32(bin.y) * view.point_bins.x + u32(bin.x);
    let list = textureLoad(binned_points, binned_texel(index), 0).xy;
    let per_px = 1.0 / max(step, vec2f(1e-30));
    let bin_px = 2.0 / sides * per_px;
    let place = scaled - bin + 1.0;
    // Glare reaches no farther than a bin: a pixel's own metric will do, and what the core lacks for it does not count.
    let metric = vec3f(dot(dx, dx), 2.0 * dot(dx, dy), dot(dy, dy));
    let pixel_sr = length(cross(dx, dy));
    let soft = max(view.glare.z, radial_pixel(ndc, step.y));
    let floor_lx = view.glare.w / exposure;
    var sum = vec3f(0.0);
    for (var i = list.x; i < list.y; i++) {
        let point = textureLoad(binned_points, binned_texel(i), 0);
        let apart = (place - 3.0 * unpack2x16unorm(point.x)) * bin_px;
        let per_widen = unpack2x16float(point.y);
        let at = apart * per_widen;
        let colour = unpack2x16float(point.w);
        let green = (1.0 - 0.2126 * colour.x - 0.0722 * colour.y) / 0.7152;
        // Luminance of a pixel that had all the light.
        let whole = bitcast<f32>(point.z) * per_px.x * per_px.y;
        var luminance = core_weight(at.x) * core_weight(at.y) * whole;
        if with_glare {
            let lx = whole * pixel_sr / (per_widen.x * per_widen.y);
            let theta = sqrt(max(dot(metric, vec3f(apart.x * apart.x, apart.x * apart.y, apart.y * apart.y)), 0.0));
            luminance += max(lx * glare_per_sr(view.glare.xy, theta, soft) - floor_lx, 0.0);
        }
        sum += luminance * vec3f(colour.x, green, colour.y);
    }
    return sum;
}
