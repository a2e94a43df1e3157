// soften, curve columns: multiplies a texel's curve by the visibility through dithered surfaces over a
// window: one more ramp, which takes a free node or joins the node with which joining costs least. CPU
// reference: crates/gobo-reference/src/curve/soften.rs. Rust: src/stage/soften.rs.

import package::bind::sampled::raw_curves;
import package::bind::stored::curves;
import package::bind::uniform::views;
import package::curve::node::{
    DEPTHS, curve_layer, grows, node_length, node_of_pair, node_passed, node_start, packed_node,
};
import package::features::NODES;
import package::records::view::GpuView;
import package::soften::run::{EMPTY_RUN, Run, add_run, load_run, window};

fn column_run(view: GpuView, size: vec2<i32>, texel: vec2<i32>) -> Run {
    var sum = EMPTY_RUN;
    let ends = window(texel.y, size.y - 1 - texel.y);
    for (var i = ends.x; i <= ends.y; i += 1) {
        let y = clamp(texel.y + i, 0, size.y - 1);
        sum = add_run(sum, load_run(view, vec2<i32>(view.origin) + vec2(texel.x, y)), i);
    }
    return sum;
}

// Depths at which the ramp starts and ends.
fn ramp(run: Run) -> vec2<f32> {
    let mean = run.moments.y / run.moments.x;
    let variance = max(run.moments.z / run.moments.x - mean * mean, 0.0);
    let most = min(mean - run.nearest, run.farthest - mean);
    let reach = max(min(sqrt(3.0 * variance), most), 0.0);
    return vec2(mean - reach, mean + reach);
}

fn taken_by(passed: vec3<f32>) -> f32 {
    return dot(abs(1.0 - passed), vec3(1.0));
}

fn middle_of(node: vec2<u32>) -> f32 {
    return node_start(node) + 0.5 * node_length(node);
}

// The ramp that joins two nodes, with the mean depth and the variance of the light they take.
fn joined(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let lengths = vec2(node_length(a), node_length(b));
    let starts = vec2(node_start(a), node_start(b));
    let taken = vec2(taken_by(node_passed(a)), taken_by(node_passed(b)));
    let share = taken / max(taken.x + taken.y, 1e-9);
    let low = min(starts.x, starts.y);
    let high = max(starts.x + lengths.x, starts.y + lengths.y);
    let mean = dot(share, starts + 0.5 * lengths);
    let off = starts + 0.5 * lengths - mean;
    let spread = dot(share, off * off + lengths * lengths * (1.0 / 12.0));
    let half = max(min(sqrt(3.0 * spread), min(mean - low, high - mean)), 0.0);
    let start = u32(clamp(round(mean - half), 1.0, DEPTHS));
    let passed = node_passed(a) * node_passed(b);
    return packed_node(start, 2.0 * half, select(min(passed, vec3(1.0)), passed, grows()));
}

// Index of the node that is replaced, and its replacement.
struct Softened {
    index: u32,
    node: vec2<u32>,
}

fn softened(view: GpuView, at: vec2<u32>, ramp: vec2<u32>) -> Softened {
    var best = Softened(0u, ramp);
    var least = 3.4e38;
    var light = vec3(1.0);
    for (var k = 0u; k < NODES; k += 1u) {
        let node = node_of_pair(textureLoad(raw_curves, at, curve_layer(view.layer, k / 2u), 0), k);
        let taken = taken_by(node_passed(node)) + taken_by(node_passed(ramp));
        let free = node_start(node) == 0.0;
        let cost = dot(light, vec3(1.0)) * taken * abs(middle_of(node) - middle_of(ramp));
        if select(cost, -1.0, free) < least {
            least = select(cost, -1.0, free);
            best.index = k;
            best.node = ramp;
            if !free {
                best.node = joined(node, ramp);
            }
        }
        light *= node_passed(node);
    }
    return best;
}

@compute @workgroup_size(8, 8)
fn soften_curve_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    if any(texel >= vec2<i32>(view.size)) {
        return;
    }
    let run = column_run(view, vec2<i32>(view.size), texel);
    let at = view.origin + id.xy;
    // The closest hole's texel.
    let source = select(at, vec2<u32>(run.hole), run.hole.x >= 0.0 && run.moments.x > 0.0);
    var changed = Softened(NODES, vec2(0u));
    if run.moments.x > 0.0 {
        let span = ramp(run);
        let start = u32(clamp(round(span.x * DEPTHS), 1.0, DEPTHS));
        let passing = max(1.0 - run.blocked, vec3(0.0));
        changed = softened(view, source, packed_node(start, (span.y - span.x) * DEPTHS, passing));
    }
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        let layer = curve_layer(view.layer, pair);
        let nodes = textureLoad(raw_curves, source, layer, 0);
        let first = select(nodes.xy, changed.node, changed.index == 2u * pair);
        let second = select(nodes.zw, changed.node, changed.index == 2u * pair + 1u);
        textureStore(curves, at, layer, vec4(first, second));
    }
}
