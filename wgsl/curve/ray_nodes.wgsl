// The second walk makes the nodes of a texel. Of few hits, the pairs that cost least are joined. Of many,
// each has a place on the ray, half by the light lost and half by the depth passed, and a node ends behind
// its share of the places. CPU reference, with the rule: crates/gobo-reference/src/curve/two_walks.rs.

import package::curve::node::{DEPTHS, grows, node_passed, packed_node};
import package::curve::ray::{
    Placed, ROWS, RayHit, Texel, bend_of, corner, found, go_on, is_finished, light_of, pass_hit, splits,
    texels, visit_hit,
};
import package::features::{NODES, unrolled};
import package::records::view::GpuView;
import package::sums::sums::BLACK;
import choice::output::{scattered, scattered_light};
import choice::visit::OFTEN_FEW;
import choice::written::{end_nodes, put_node};

const LEAST_ROOTED: f32 = 0.00048828125; // in roots, black counts as this light: 1/2048
const FEW: u32 = 6u; // largest ratio of hits to nodes at which pairs are joined by cost
const MOST_FEW: u32 = 64u; // and largest number of such hits

// A node to write.
struct Ramp {
    start: f32,
    end: f32,
    passed: vec3<f32>,
}

fn write_node(view: GpuView, t: ptr<function, Texel>, i: u32, ramp: Ramp, is: bool) {
    let start = u32(clamp(round(ramp.start * DEPTHS), 1.0, DEPTHS));
    let most = select(1.0, 3.4e38, grows());
    let wanted = min(ramp.passed * (*t).owed, vec3(most));
    let node = packed_node(start, max(ramp.end - ramp.start, 0.0) * DEPTHS, wanted);
    let stored = node_passed(node);
    let owed = select(vec3(1.0), wanted / max(stored, vec3(1e-9)), stored > vec3(0.0));
    (*t).owed = select((*t).owed, owed, is);
    put_node(view, t, i, (*t).used, node, is);
    (*t).used += select(0u, 1u, is);
}

// Number of ramps for a hit that has a node of its own: bodies share the free nodes.
fn parts_of(t: ptr<function, Texel>, bend: f32) -> u32 {
    let share = bend / max((*t).bends, 1e-9) * f32((*t).spare);
    let more = min(u32(round(share)), (*t).spare);
    (*t).bends -= bend;
    (*t).spare -= more;
    return 1u + more;
}

// Writes a ramp as `parts` equal ones.
fn write_parts(view: GpuView, t: ptr<function, Texel>, i: u32, ramp: Ramp, parts: u32, is: bool) {
    let root = pow(max(ramp.passed, vec3(LEAST_ROOTED)), vec3(1.0 / f32(parts)));
    let length = (ramp.end - ramp.start) / f32(parts);
    for (var part = 0u; part < parts; part += 1u) {
        let dark = (ramp.passed < vec3(LEAST_ROOTED)) & vec3(part + 1u == parts);
        let start = ramp.start + f32(part) * length;
        let own = select(select(root, vec3(0.0), dark), ramp.passed, parts == 1u);
        write_node(view, t, i, Ramp(start, select(start + length, ramp.end, parts == 1u), own), is);
    }
}

// Channels in which no light is visible.
fn unseen(light: vec3<f32>) -> vec3<bool> {
    return light < vec3(select(BLACK, 0.0, grows()));
}

// Ramp of the open node, with the mean depth and variance of the light that it takes. `light`: behind the
// node.
fn open_ramp(t: ptr<function, Texel>, light: vec3<f32>) -> Ramp {
    let texel = *t;
    let share = 1.0 / max(texel.taken, 1e-30);
    let off = texel.sum * share;
    let spread = max(texel.square * share - off * off, 0.0);
    let mean = clamp(texel.anchor + off, texel.low, texel.high);
    let half = min(sqrt(3.0 * spread), min(mean - texel.low, texel.high - mean));
    let passed = select(light / max(texel.before, vec3(1e-9)), vec3(0.0), unseen(light));
    let some = texel.taken > 0.0;
    return Ramp(select(texel.low, mean - half, some), select(texel.high, mean + half, some), passed);
}

// Ramp of a hit with a node of its own. Behind a dark node only late hits are visible.
fn single_ramp(t: ptr<function, Texel>, hit: RayHit, placed: Placed) -> Ramp {
    let dark = unseen(placed.behind) & vec3(hit.start >= (*t).at);
    return Ramp(hit.start, hit.end, select(1.0 - hit.absorbed, vec3(0.0), dark));
}

fn share_of_rest(t: ptr<function, Texel>) -> f32 {
    return (1.0 - (*t).place) / f32(NODES - (*t).used);
}

// Adds a hit to the open node, or to a new one.
fn join_hit(t: ptr<function, Texel>, hit: RayHit, light: vec3<f32>, taken: f32, begun: f32) {
    let is_new = !(*t).open;
    (*t).place = select((*t).place, begun, is_new);
    (*t).cut = select((*t).cut, begun + share_of_rest(t), is_new);
    (*t).before = select((*t).before, light, is_new);
    (*t).low = select(min((*t).low, hit.start), hit.start, is_new);
    (*t).high = select(max((*t).high, hit.end), hit.end, is_new);
    (*t).anchor = select((*t).anchor, hit.start, is_new);
    let off = 0.5 * (hit.start + hit.end) - (*t).anchor;
    let length = hit.end - hit.start;
    let square = taken * (off * off + length * length * (1.0 / 12.0));
    (*t).taken = taken + select((*t).taken, 0.0, is_new);
    (*t).sum = taken * off + select((*t).sum, 0.0, is_new);
    (*t).square = square + select((*t).square, 0.0, is_new);
    (*t).open = true;
}

fn place_hit(view: GpuView, t: ptr<function, Texel>, i: u32, hit: RayHit) {
    if is_finished(t) {
        return;
    }
    let placed = pass_hit(t, hit);
    if !placed.is {
        return;
    }
    let texel = *t;
    let taken = placed.taken;
    let is_equal = OFTEN_FEW && placed.bin == texel.bin && texel.equal > 0u && texel.seen > 0u;
    let joins = placed.bin < texel.bin || is_equal;
    let still = texel.count - texel.seen; // hits from this one on
    let left = NODES - texel.used;
    let free = left - u32(texel.open);
    let by_light = 0.5 / max(texel.all, 1e-9);
    let by_depth = 0.5 / max(texel.last - texel.first, 1e-9);
    let by_cost = OFTEN_FEW && texel.count <= min(FEW * NODES, MOST_FEW);
    let much = taken * f32(left) > texel.all - texel.gone;
    let fits = free > 1u || (free > 0u && (texel.open || still == 1u));
    let is_alone = texel.count <= NODES || (!by_cost && much && fits);
    // The gap in front of the hit counts three times.
    let gone = 3.0 * placed.z - 2.0 * texel.at - texel.first;
    let place = by_light * (texel.gone + 0.5 * taken) + by_depth * gone;
    let passes = select(place > texel.cut, !joins, by_cost) || still <= free;
    let ends = !is_alone && texel.open && free > 0u && placed.z > texel.at && passes;
    var ramp = single_ramp(t, hit, placed);
    if !is_alone {
        ramp = open_ramp(t, placed.light);
    }
    if splits() {
        let parts = parts_of(t, select(0.0, bend_of(hit, placed), texel.count <= NODES));
        write_parts(view, t, i, ramp, parts, is_alone || ends);
    } else {
        write_node(view, t, i, ramp, is_alone || ends);
    }
    if is_alone {
        (*t).before *= 1.0 - hit.absorbed;
        (*t).place += by_light * taken;
        (*t).cut = (*t).place + share_of_rest(t);
    } else {
        (*t).open = texel.open && !ends;
        let begun = by_light * texel.gone + by_depth * (placed.z - texel.first);
        join_hit(t, hit, placed.light, taken, begun);
    }
    (*t).equal -= u32(is_equal);
    (*t).seen += 1u;
    (*t).gone += taken;
    go_on(t, placed);
}

// Visits the casters without pairs, as one hit behind all others.
fn visit_scattered(view: GpuView) {
    for (var turn = 0u; turn < u32(scattered()); turn += 1u) {
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            var texel = texels[i];
            let rest = scattered_light(corner, i);
            let depth = max(select(texel.nearest, rest.depth, rest.depth < 1.0), texel.at);
            let presence = select(0.0, 1.0, any(rest.light != vec3(1.0)));
            visit_hit(view, &texel, i, RayHit(1.0 - rest.light, depth, depth, depth, presence));
            texel.nearest = min(texel.nearest, rest.depth);
            texels[i] = texel;
        }
    }
}

// Ends the second walk.
fn end_walk(view: GpuView) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        write_node(view, &texel, i, open_ramp(&texel, light_of(&texel)), texel.open);
        end_nodes(view, &texel, i);
        found[i] = vec4(light_of(&texel), texel.nearest);
    }
}
