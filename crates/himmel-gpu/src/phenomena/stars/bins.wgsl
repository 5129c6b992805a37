// Bins of a picture: which points its pixels have to look at. Points are counted (move.wgsl), then `scan_bins` finds where the
// list of each bin begins, `list_points` fills the lists, and `sort_bins` puts them in order and writes out what pixels read. Points
// too wide for bins are listed apart, in order, and drawn as squares (wide.wgsl).

//#include "phenomena/stars/points.wgsl"

@group(2) @binding(2) var<storage, read_write> prepared_points: array<SeenPoint>;
// Of each view: what draws its wide points, then where the list of each bin begins and the last one ends. Then, of
// all views, the lists (four times as many as points), and the wide points: numbers of prepared points.
@group(2) @binding(8) var<storage, read_write> point_bins: array<atomic<u32>>;
// What pixels read, see binned.wgsl.
@group(2) @binding(10) var binned_out: texture_storage_2d<rgba32uint, write>;

// Before a view's bins: an indirect draw of its wide points, an indirect dispatch over them.
const DRAW_WORDS: u32 = 8u;

const SCAN: u32 = 256u;
// A list that is longer stays in the order in which it was filled: sorting takes its length squared.
const MOST_SORTED: u32 = 512u;

// The bins that a point reaches: first, and how many. None: it is not seen, or wide.
struct Reach {
    first: vec2u,
    count: vec2u,
}

fn bins_of(point: SeenPoint) -> Reach {
    let sides = vec2i(points.bins);
    let scale = 0.5 * vec2f(points.bins);
    var low = vec2i(floor((point.centre - point.half_size + 1.0) * scale));
    var high = vec2i(floor((point.centre + point.half_size + 1.0) * scale));
    // No more than two, whatever rounding does.
    high = min(high, low + 1);
    // Of an equirectangular picture the left edge is the right edge. Chosen, not branched on: see sky.wgsl.
    let around = ((low.x % sides.x) + sides.x) % sides.x;
    let turned = vec2i(around, around + min(high.x - low.x, sides.x - 1));
    low = max(low, vec2i(0));
    high = min(high, sides - 1);
    let closed = !linear && view.projection == 2u;
    low.x = select(low.x, turned.x, closed);
    high.x = select(high.x, turned.y, closed);
    let binned = point.wide == 0u && point.half_size.x > 0.0 && all(high >= low);
    return Reach(vec2u(low), select(vec2u(0u), vec2u(max(high - low + 1, vec2i(0))), binned));
}

fn bin_slot(reach: Reach, i: u32) -> u32 {
    let column = (reach.first.x + i % reach.count.x) % points.bins.x;
    let row = reach.first.y + i / reach.count.x;
    return points.bins_first + DRAW_WORDS + row * points.bins.x + column;
}

var<workgroup> sums: array<u32, SCAN>;

// The sum over all invocations before this one, of values in `sums`; the sum of all.
fn sum_before(i: u32) -> vec2u {
    for (var step = 1u; step < SCAN; step *= 2u) {
        workgroupBarrier();
        let own = sums[i];
        let before = select(0u, sums[max(i, step) - step], i >= step);
        workgroupBarrier();
        sums[i] = own + before;
    }
    workgroupBarrier();
    let all = sums[SCAN - 1u];
    let before = select(0u, sums[max(i, 1u) - 1u], i > 0u);
    workgroupBarrier();
    return vec2u(before, all);
}

@compute @workgroup_size(SCAN)
fn scan_bins(@builtin(local_invocation_index) i: u32) {
    let count = points.bins.x * points.bins.y;
    let first_bin = points.bins_first + DRAW_WORDS;
    let share = (count + SCAN - 1u) / SCAN;
    let start = min(i * share, count);
    let stop = min(start + share, count);
    var own = 0u;
    for (var bin = start; bin < stop; bin++) {
        own += atomicLoad(&point_bins[first_bin + bin]);
    }
    sums[i] = own;
    let before = sum_before(i);
    // Ends of the lists: `list_points` counts them down to their beginnings.
    var end = 4u * points.view_first + before.x;
    for (var bin = start; bin < stop; bin++) {
        end += atomicLoad(&point_bins[first_bin + bin]);
        atomicStore(&point_bins[first_bin + bin], end);
    }
    let wide_share = (points.view_count + SCAN - 1u) / SCAN;
    let wide_from = min(i * wide_share, points.view_count) + points.view_first;
    let wide_to = min((i + 1u) * wide_share, points.view_count) + points.view_first;
    own = 0u;
    for (var point = wide_from; point < wide_to; point++) {
        own += u32(is_wide(point));
    }
    sums[i] = own;
    let wide_before = sum_before(i);
    var place = points.wide_first + points.view_first + wide_before.x;
    for (var point = wide_from; point < wide_to; point++) {
        if is_wide(point) {
            atomicStore(&point_bins[place], point);
            place++;
        }
    }
    if i == 0u {
        atomicStore(&point_bins[first_bin + count], 4u * points.view_first + before.y);
        // Vertices, instances: equirectangular pictures draw each twice, since it may lie on their seam.
        atomicStore(&point_bins[points.bins_first], 6u * wide_before.y);
        atomicStore(&point_bins[points.bins_first + 1u], select(1u, 2u, !linear && view.projection == 2u));
        atomicStore(&point_bins[points.bins_first + 2u], 0u);
        atomicStore(&point_bins[points.bins_first + 3u], 0u);
        atomicStore(&point_bins[points.bins_first + 4u], (wide_before.y + 63u) / 64u);
        atomicStore(&point_bins[points.bins_first + 5u], 1u);
        atomicStore(&point_bins[points.bins_first + 6u], 1u);
    }
}

fn is_wide(point: u32) -> bool {
    return prepared_points[point].wide == 1u && prepared_points[point].half_size.x > 0.0;
}

@compute @workgroup_size(64)
fn list_points(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= points.view_count {
        return;
    }
    let index = points.view_first + id.x;
    let reach = bins_of(prepared_points[index]);
    for (var i = 0u; i < reach.count.x * reach.count.y; i++) {
        let place = atomicSub(&point_bins[bin_slot(reach, i)], 1u) - 1u;
        atomicStore(&point_bins[points.lists_first + place], index);
    }
}

fn listed(i: u32) -> u32 {
    return atomicLoad(&point_bins[points.lists_first + i]);
}

// Sums of floats hang on their order: the same picture twice is the same to the last bit.
@compute @workgroup_size(64)
fn sort_bins(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= points.bins.x * points.bins.y {
        return;
    }
    let bin = points.bins_first + DRAW_WORDS + id.x;
    let first = atomicLoad(&point_bins[bin]);
    let end = atomicLoad(&point_bins[bin + 1u]);
    let sorted = select(end, first, end - first > MOST_SORTED);
    for (var i = first + 1u; i < sorted; i++) {
        let moved = listed(i);
        var hole = i;
        while hole > first && listed(max(hole, 1u) - 1u) > moved {
            atomicStore(&point_bins[points.lists_first + hole], listed(hole - 1u));
            hole--;
        }
        atomicStore(&point_bins[points.lists_first + hole], moved);
    }
    let texels = points.binned_first;
    textureStore(binned_out, binned_texel(view.point_bins_first + id.x), vec4u(texels + first, texels + end, 0u, 0u));
    let sides = vec2f(points.bins);
    let corner = vec2f(vec2u(id.x % points.bins.x, id.x / points.bins.x));
    for (var i = first; i < end; i++) {
        let point = prepared_points[listed(i)];
        var place = (0.5 + 0.5 * point.centre) * sides - corner;
        if !linear {
            // Across the seam of an equirectangular picture.
            place.x -= select(0.0, sides.x * round(place.x / sides.x), view.projection == 2u && abs(place.x - 0.5) > 2.0);
        }
        let spread = point.light.a / (point.widen.x * point.widen.y * point.per_ndc);
        textureStore(binned_out, binned_texel(texels + i), pack_point(place, 1.0 / point.widen, point.light.rgb * spread));
    }
}
