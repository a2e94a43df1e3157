// Accumulator: curves of an invocation's texels. CPU reference: crates/gobo-reference/src/curve/tile.rs.

import package::bind::sampled::opaques;
import package::curve::lights::{Lights, black, fixed, minus, plus, scaled, selected, white};
import package::curve::list::{adding, clear_list, insert, is_saturated, last_end, merge_nodes, overfull};
import package::curve::node::DEPTHS;
import package::curve::volumes::{Ramp, clear_volumes, count_late, nearest_inside};
import package::features::{FAINT, HAS_OVER, HAS_VOLUMES, unrolled};
import package::hit::hit_order::{clear_order, front_depths, start_keys};
import package::records::view::GpuView;
import package::sums::sums::{FULL, VISIBLE_PRESENCE};
import choice::nodes::{laid_aside, lay_aside, lay_kept};
import choice::rows::{ROW_COUNT, RowBits, RowIs, Rows, any_row, with_row};
import choice::visit::join_delayed;

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

const TRACE: f32 = 0.0000152587890625; // presence below which hits set no start or end: 2^-16

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> opaque_depth: Rows;
var<private> nearest: Rows;
var<private> passed: Lights; // with `keeps`: light behind all hits; otherwise that light is laid aside
var<private> lost: Lights;   // with `keeps`: absorbed, not yet multiplied into `passed`
var<private> traces: Rows;   // presence of the hits since one set a start or an end, with `FAINT`
// Hits that have not been inserted into the curve; start 2 if there are none.
var<private> open_start: Rows;
var<private> open_end: Rows;
var<private> open_light: Lights;
var<private> open_added: Lights; // added by `over`
// Scale of the affine transfer of all hits, for light that comes from behind a segment.
var<private> scale: Lights;

// Whether faint absorption is kept apart: only where hits do nothing but pass light on.
fn keeps() -> bool {
    return FAINT && !HAS_OVER && !HAS_VOLUMES;
}

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest = Rows(1.0);
    passed = white();
    lost = black();
    traces = Rows(0.0);
    open_start = Rows(2.0);
    open_end = Rows(0.0);
    open_light = white();
    open_added = black();
    scale = white();
    opaque_depth = Rows(1.0);
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let at = view.origin + texel + vec2(0u, i);
        opaque_depth = with_row(opaque_depth, i, textureLoad(opaques, at, view.layer, 0).r);
    }
    clear_list(texel);
    lay_aside(white(), RowIs(false));
    clear_volumes();
    if HAS_OVER || HAS_VOLUMES {
        clear_order();
    }
    if HAS_OVER {
        start_keys(view, corner);
    }
}

fn kept(light: Rows, absorbed: Rows) -> Rows {
    return select(light, light * (1.0 - absorbed), absorbed > Rows(FULL));
}

fn pending(absorbed: Rows) -> Rows {
    return select(absorbed, Rows(0.0), absorbed > Rows(FULL));
}

fn keep(absorbed: Lights) {
    let all = plus(lost, scaled(absorbed, minus(white(), lost)));
    passed = Lights(kept(passed.red, all.red), kept(passed.green, all.green), kept(passed.blue, all.blue));
    lost = Lights(pending(all.red), pending(all.green), pending(all.blue));
}

// Adds a hit to the open ones. `absorbed`: 1 - `light`, precise where light is next to 1.
fn join(light: Lights, absorbed: Lights, depth: Rows, presence: Rows) -> RowIs {
    open_light = scaled(open_light, light);
    var placed = presence >= Rows(TRACE);
    if keeps() {
        keep(absorbed);
    }
    if FAINT {
        // Many hits below `TRACE` share a depth.
        traces += presence;
        placed = traces >= Rows(TRACE);
        traces = select(traces, Rows(0.0), placed);
    }
    // Faster than min and max, which must handle NaNs.
    open_start = select(open_start, depth, placed & (depth < open_start));
    open_end = select(open_end, depth, placed & (depth > open_end));
    return placed;
}

// Adds light that is no hit's to the open hits.
fn join_rest(light: Lights) {
    open_light = scaled(open_light, light);
    if keeps() {
        passed = scaled(passed, light);
    }
}

fn join_ramp(ramp: Ramp) -> RowIs {
    count_late(ramp);
    let light = selected(white(), ramp.light, ramp.is);
    join_rest(light);
    scale = scaled(scale, light);
    if HAS_OVER {
        open_added = scaled(open_added, light);
    }
    open_start = select(open_start, min(open_start, ramp.start), ramp.is);
    open_end = select(open_end, max(open_end, ramp.end), ramp.is);
    return ramp.is;
}

// Lowers the nearest depth to a visible hit's.
fn see(depth: Rows, presence: Rows) {
    nearest = select(nearest, depth, (presence >= Rows(VISIBLE_PRESENCE)) & (depth < nearest));
}

// Whether open hits must be inserted before the next caster.
fn must_flush(placed: RowIs) -> bool {
    return any_row(placed);
}

// Merges nodes where the last insertion left too many.
fn merge() {
    merge_nodes();
    lay_kept();
}

// Inserts open hits into the curves.
fn flush() {
    let goes = open_start <= Rows(1.0);
    let behind = laid_aside();
    let all = total_light();
    if HAS_OVER {
        adding = open_added;
    }
    insert(fixed(open_start), fixed(open_end), open_light, all, goes);
    lay_aside(selected(behind, all, goes), overfull);
    open_light = selected(open_light, white(), goes);
    if HAS_OVER {
        open_added = selected(open_added, black(), goes);
    }
    open_start = select(open_start, Rows(2.0), goes);
    open_end = select(open_end, Rows(0.0), goes);
    join_delayed();
}

fn total_light() -> Lights {
    if keeps() {
        return scaled(passed, minus(white(), lost));
    }
    let filtered = scaled(laid_aside(), open_light);
    if HAS_OVER {
        return plus(filtered, open_added);
    }
    return filtered;
}

fn nearest_seen() -> Rows {
    if HAS_VOLUMES {
        return nearest_inside(nearest);
    }
    return nearest;
}

// Whether nothing at or behind light depth `front` can change these texels. Valid only at the end of a slab.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    let depth = front_depths(front);
    if HAS_OVER {
        return !any_row(opaque_depth > depth);
    }
    let closed = is_saturated() & !overfull & (last_end() <= RowBits(depth * DEPTHS)) & (nearest <= depth);
    return !any_row(!closed & (opaque_depth > depth));
}
