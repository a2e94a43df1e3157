// Accumulator: curves of an invocation's texels, as lists of nodes. CPU reference:
// crates/gobo-reference/src/curve/tile.rs.

import package::bind::sampled::opaques;
import package::curve::list::{Insertion, clear_lists, fixed, insert, is_saturated, last_end, merge_lists};
import package::curve::node::DEPTHS;
import package::curve::visit_hits::join_delayed;
import package::curve::volumes::{Ramp, Unentered, count_late};
import package::features::{FAINT, HAS_OVER, HAS_VOLUMES, unrolled};
import package::hit::hit_order::{NO_HIT, OrderedHit, depths_of_keys, least_depth};
import package::records::view::GpuView;
import package::sums::sums::keep;
import choice::nodes::{laid_aside, lay_aside, lay_kept};
import choice::rows::ROW_COUNT;
import choice::waiting::clear_waiting;

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

const TRACE: f32 = 0.0000152587890625; // presence below which hits set no start or end: 2^-16

struct Texel {
    opaque: f32,       // light depths: of the opaque surface, and of the nearest visible hit
    nearest: f32,
    passed: vec3<f32>, // with `keeps`: light behind all hits; otherwise that light is laid aside
    lost: vec3<f32>,   // with `keeps`: absorbed, not yet multiplied into `passed`
    traces: f32,       // presence of the hits since one set a start or an end, with `FAINT`
    // Hits that have not been inserted into the curve; start 2 if there are none.
    open_start: f32,
    open_end: f32,
    open_light: vec3<f32>,
    open_added: vec3<f32>, // by `over`
    // Scale of the affine transfer of all hits, for light that comes from behind a segment.
    scale: vec3<f32>,
    // Light that passes all hits except volumes, and the scale of that affine transfer.
    surface_light: vec3<f32>,
    surface_scale: vec3<f32>,
    // Order of hits:
    keys: vec2<f32>,     // light depths of depth keys 0 and 1
    last_left: f32,      // light depth of the last hit that left
    delayed: OrderedHit, // has left, but comes behind a volume's ramp that is inserted first
    // List:
    latest: u32,    // largest start of a hit so far
    overfull: bool, // whether the curve has one node too many
    alone: u32,     // bit k: node k is a single hit, not merged
    // Volumes:
    crossed: vec4<i32>, // sums over all faces, as in nearest-depth mode
    density: vec3<f32>, // optical depth per light depth, behind `last_face`, of those entered and not left
    last_face: f32,
    unentered: Unentered,
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> texels: array<Texel, ROWS>;

// Whether faint absorption is kept apart: only where hits do nothing but pass light on.
fn keeps() -> bool {
    return FAINT && !HAS_OVER && !HAS_VOLUMES;
}

fn new_texel() -> Texel {
    var fresh = Texel();
    fresh.opaque = 1.0;
    fresh.nearest = 1.0;
    fresh.passed = vec3(1.0);
    fresh.open_start = 2.0;
    fresh.open_light = vec3(1.0);
    fresh.scale = vec3(1.0);
    fresh.surface_light = vec3(1.0);
    fresh.surface_scale = vec3(1.0);
    fresh.last_left = -1.0;
    fresh.delayed = NO_HIT;
    return fresh;
}

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    clear_lists(texel);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i] = new_texel();
        texels[i].opaque = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
        lay_aside(i, vec3(1.0), false);
        if HAS_OVER || HAS_VOLUMES {
            clear_waiting(i);
        }
        if HAS_OVER {
            texels[i].keys = depths_of_keys(view, corner + vec2(0.5, f32(i) + 0.5));
        }
    }
}

// Adds a hit to the open ones; returns whether it must be inserted before the next caster. `absorbed`: 1 -
// its light, precise where that is next to 1; not read with `over` or volumes.
fn join(t: ptr<function, Texel>, hit: OrderedHit, absorbed: vec3<f32>) -> bool {
    (*t).open_light *= hit.light;
    if keeps() {
        let kept = keep((*t).passed, (*t).lost, absorbed);
        (*t).passed = kept.passed;
        (*t).lost = kept.lost;
    }
    var placed = hit.presence >= TRACE;
    if FAINT {
        // Many hits below `TRACE` share a depth.
        let traces = (*t).traces + hit.presence;
        placed = traces >= TRACE;
        (*t).traces = select(traces, 0.0, placed);
    }
    // Faster than min and max, which must handle NaNs.
    (*t).open_start = select((*t).open_start, hit.depth, placed & (hit.depth < (*t).open_start));
    (*t).open_end = select((*t).open_end, hit.end, placed & (hit.end > (*t).open_end));
    if HAS_OVER || HAS_VOLUMES {
        (*t).scale *= hit.light;
        (*t).surface_light *= hit.light;
        (*t).surface_scale *= hit.light;
    }
    if HAS_OVER {
        (*t).open_added = (*t).open_added * hit.light + hit.added;
        (*t).surface_light += hit.added;
    }
    return placed;
}

// Adds light that is no hit's to the open hits, with a stretch of light depths where `is` holds.
fn join_rest(t: ptr<function, Texel>, light: vec3<f32>, start: f32, end: f32, is: bool) {
    (*t).open_light *= light;
    if keeps() {
        (*t).passed *= light;
    }
    if HAS_OVER {
        (*t).open_added *= light;
    }
    (*t).open_start = select((*t).open_start, min((*t).open_start, start), is);
    (*t).open_end = select((*t).open_end, max((*t).open_end, end), is);
}

fn join_ramp(t: ptr<function, Texel>, ramp: Ramp) -> bool {
    count_late(ramp);
    let light = select(vec3(1.0), ramp.light, ramp.is);
    join_rest(t, light, ramp.start, ramp.end, ramp.is);
    (*t).scale *= light;
    return ramp.is;
}

// Inserts open hits into the curves.
fn flush() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        flush_texel(&texel, i);
        join_delayed(&texel);
        texels[i] = texel;
    }
}

fn flush_texel(t: ptr<function, Texel>, i: u32) {
    let goes = (*t).open_start <= 1.0;
    let behind = laid_aside(i);
    let all = total_light(t, i);
    let span = (fixed((*t).open_start) << 16u) | fixed((*t).open_end);
    insert(t, i, Insertion(span, (*t).open_light, (*t).open_added, all, goes));
    lay_aside(i, select(behind, all, goes), (*t).overfull);
    (*t).open_light = select((*t).open_light, vec3(1.0), goes);
    (*t).open_added = select((*t).open_added, vec3(0.0), goes);
    (*t).open_start = select((*t).open_start, 2.0, goes);
    (*t).open_end = select((*t).open_end, 0.0, goes);
}

// Merges nodes where the last insertion left too many.
fn merge() {
    merge_lists();
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        lay_kept(i);
    }
}

fn total_light(t: ptr<function, Texel>, i: u32) -> vec3<f32> {
    if keeps() {
        return (*t).passed * (1.0 - (*t).lost);
    }
    let filtered = laid_aside(i) * (*t).open_light;
    if HAS_OVER {
        return filtered + (*t).open_added;
    }
    return filtered;
}

// Nearest depth: 0 if the light is inside a volume.
fn nearest_of(texel: Texel) -> f32 {
    return select(texel.nearest, 0.0, HAS_VOLUMES && texel.crossed.w > 0);
}

// Whether nothing at or behind `front` can change these texels. Valid only at the end of a slab.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    var open = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let depth = least_depth(texels[i].keys, front);
        let ends = (last_end(i) <= u32(depth * DEPTHS)) & (texels[i].nearest <= depth);
        let closed = is_saturated(i) & !texels[i].overfull & ends;
        open = open | (!closed & (texels[i].opaque > depth));
    }
    return !open;
}
