// Accumulator: curves of four texels in a column. CPU reference: src/reference/curve/tile.rs.

import package::bind::sampled::opaques;
import package::curve::light4::{Light4, black4, fixed, minus, plus, scaled, selected, white4};
import package::curve::list::{
    adding, append, clear_list, has_free_node, insert, is_saturated, last_end,
};
import package::curve::node::DEPTHS;
import package::curve::volumes::{Ramp4, clear_volumes, count_late, nearest_inside};
import package::features::{FAINT, HAS_OVER, HAS_VOLUMES, NODES};
import package::hit::hit_order::clear_order;
import package::hit::key_depths::{front_depths, start_keys};
import package::records::view::GpuView;
import package::sums::faint::keep4;
import package::sums::sums::VISIBLE_OPACITY;
import choice::visit::{blocked, slabbed};

const ROWS: u32 = 4u; // texels that an invocation holds, in a column

const TRACE: f32 = 0.0000152587890625; // opacity below which hits set no start or end: 2^-16

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> opaque_depth: vec4<f32>;
var<private> nearest: vec4<f32>;
var<private> passed: Light4; // behind the curve; with `keeps`, behind open hits too
var<private> lost: Light4;   // with `keeps`: absorbed, not yet multiplied into `passed`
var<private> traces: vec4<f32>; // opacity of the hits since one set a start or an end, with `FAINT`
var<private> hit_count: vec4<u32>; // hits of the segment, as far as they were counted
var<private> few: vec4<bool>;      // texels with few hits, inserted one by one until the curve is full
// Hits that have not been inserted into the curve; start 2 if there are none.
var<private> open_start: vec4<f32>;
var<private> open_end: vec4<f32>;
var<private> open_light: Light4;
var<private> open_added: Light4; // added by `over`
// Scale of the affine transfer of all hits, for light from behind a segment.
var<private> scale: Light4;

// Most hits of a texel that are inserted into its curve one by one.
fn max_exact_hits() -> vec4<u32> {
    return vec4(2u * NODES);
}

// Whether hits at or behind `front` may still change `few` or the nearest depths.
fn is_counting(front: f32) -> bool {
    return any((hit_count <= max_exact_hits()) | (nearest > vec4(front)));
}

fn end_count() {
    few = hit_count <= max_exact_hits();
}

// Whether the next hit is inserted alone, without a merge.
fn is_single() -> vec4<bool> {
    return few & has_free_node();
}

// Whether faint absorption is kept apart: where light only passes hits.
fn keeps() -> bool {
    return FAINT && !HAS_OVER && !HAS_VOLUMES;
}

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest = vec4(1.0);
    passed = white4();
    lost = black4();
    traces = vec4(0.0);
    open_start = vec4(2.0);
    open_end = vec4(0.0);
    open_light = white4();
    open_added = black4();
    scale = white4();
    opaque_depth = vec4(1.0);
    if blocked() {
        let at = view.origin + texel;
        opaque_depth = vec4(
            textureLoad(opaques, at, view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 1u), view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 2u), view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 3u), view.layer, 0).r,
        );
    }
    hit_count = vec4(0u);
    few = vec4(true);
    clear_list();
    clear_volumes();
    if HAS_OVER {
        clear_order();
        start_keys(view, corner);
    }
}

fn keep(absorbed: Light4) {
    let red = keep4(passed.red, lost.red, absorbed.red);
    let green = keep4(passed.green, lost.green, absorbed.green);
    let blue = keep4(passed.blue, lost.blue, absorbed.blue);
    passed = Light4(red.passed, green.passed, blue.passed);
    lost = Light4(red.lost, green.lost, blue.lost);
}

// Adds a hit to the open ones. `absorbed`: 1 - `light`, precise where light is next to 1.
fn join(light: Light4, absorbed: Light4, depth: vec4<f32>, opacity: vec4<f32>) -> vec4<bool> {
    open_light = scaled(open_light, light);
    var placed = opacity >= vec4(TRACE);
    if keeps() {
        keep(absorbed);
    }
    if FAINT {
        // Many hits below `TRACE` have a place together.
        traces += opacity;
        placed = traces >= vec4(TRACE);
        traces = select(traces, vec4(0.0), placed);
    }
    // Faster than min and max, which must handle NaNs.
    open_start = select(open_start, depth, placed & (depth < open_start));
    open_end = select(open_end, depth, placed & (depth > open_end));
    return placed;
}

// Adds light of what is no hit to the open ones.
fn join_rest(light: Light4) {
    open_light = scaled(open_light, light);
    if keeps() {
        passed = scaled(passed, light);
    }
}

fn join_ramp(ramp: Ramp4) -> vec4<bool> {
    count_late(ramp);
    let light = selected(white4(), ramp.light, ramp.is);
    join_rest(light);
    scale = scaled(scale, light);
    if HAS_OVER {
        open_added = scaled(open_added, light);
    }
    open_start = select(open_start, min(open_start, ramp.start), ramp.is);
    open_end = select(open_end, max(open_end, ramp.end), ramp.is);
    return ramp.is;
}

// Updates the nearest depth by a hit.
fn see(depth: vec4<f32>, opacity: vec4<f32>) {
    nearest = select(nearest, depth, (opacity >= vec4(VISIBLE_OPACITY)) & (depth < nearest));
}

// Whether open hits must be inserted before the next caster.
fn must_flush(placed: vec4<bool>) -> bool {
    return any(placed & (is_single() | vec4(!slabbed())));
}

// Inserts open hits into the curves; before the end of a slab only where the next hit must not join them.
fn flush(whole: bool) {
    let goes = (open_start <= vec4(1.0)) & (vec4(whole) | is_single() | vec4(!slabbed()));
    let all = total_light();
    if HAS_OVER {
        adding = open_added;
    }
    insert(fixed(open_start), fixed(open_end), open_light, all, goes);
    close_open(all, goes);
}

// Inserts a single hit that fits without a merge: the same result, with far less work.
fn append_single() {
    let goes = (open_start <= vec4(1.0)) & is_single();
    let all = total_light();
    append(fixed(open_start), fixed(open_end), open_light, all, goes);
    close_open(all, goes);
}

fn close_open(all: Light4, goes: vec4<bool>) {
    if !keeps() {
        passed = selected(passed, all, goes);
    }
    open_light = selected(open_light, white4(), goes);
    if HAS_OVER {
        open_added = selected(open_added, black4(), goes);
    }
    open_start = select(open_start, vec4(2.0), goes);
    open_end = select(open_end, vec4(0.0), goes);
}

fn total_light() -> Light4 {
    if keeps() {
        return scaled(passed, minus(white4(), lost));
    }
    let filtered = scaled(passed, open_light);
    if HAS_OVER {
        return plus(filtered, open_added);
    }
    return filtered;
}

fn light_texel(light: Light4, i: u32) -> vec3<f32> {
    return vec3(light.red[i], light.green[i], light.blue[i]);
}

fn nearest_seen() -> vec4<f32> {
    if HAS_VOLUMES {
        return nearest_inside(nearest);
    }
    return nearest;
}

// Whether nothing at or behind light depth `front` can change these texels. Valid at the end of a slab
// only.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    let depth = front_depths(front);
    if HAS_OVER {
        return all(opaque_depth <= depth);
    }
    let closed = is_saturated() & (last_end() <= vec4<u32>(depth * DEPTHS)) & (nearest <= depth);
    return all(closed | (opaque_depth <= depth));
}
