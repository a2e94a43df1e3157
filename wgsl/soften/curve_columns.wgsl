// soften, curve columns: curves of four texels in a column per invocation, multiplied by the visibility
// through dithered surfaces over a window. CPU reference: src/reference/curve/soften.rs. Rust:
// src/stage/soften.rs.

import package::bind::sampled::raw_curves;
import package::bind::stored::curves;
import package::bind::uniform::views;
import package::curve::light4::{
    black4, decode_light, encode_lights, encode_means, fixed, scaled, selected, white4,
};
import package::curve::list::{adding, clear_list, insert, node_lights, node_means, spans};
import package::curve::loaded::loaded_node;
import package::curve::node::curve_layer;
import package::curve::stored::{packed_pair, packed_row};
import package::features::NODES;
import package::records::view::GpuView;
import package::soften::run::{EMPTY_RUN, Run, add_run, load_run, window};

const ROWS: u32 = 4u;

// Hits are not in order.
fn ordered() -> bool {
    return false;
}

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

var<private> places: array<vec2<u32>, ROWS>; // atlas texels of the curves that are softened

fn load_node(i: u32, firsts: vec4<u32>, seconds: vec4<u32>) {
    let node = loaded_node(firsts, seconds);
    let none = node.start == vec4(0u);
    let light = selected(node.light, white4(), none);
    spans[i] = select((node.start << vec4(16u)) | node.end, vec4(0u), none);
    node_lights[i] = encode_lights(light);
    node_means[i] = encode_means(light);
}

fn load_pair(view: GpuView, pair: u32) {
    let layer = curve_layer(view.layer, pair);
    let a = textureLoad(raw_curves, places[0], layer, 0);
    let b = textureLoad(raw_curves, places[1], layer, 0);
    let c = textureLoad(raw_curves, places[2], layer, 0);
    let d = textureLoad(raw_curves, places[3], layer, 0);
    load_node(2u * pair, vec4(a.x, b.x, c.x, d.x), vec4(a.y, b.y, c.y, d.y));
    load_node(2u * pair + 1u, vec4(a.z, b.z, c.z, d.z), vec4(a.w, b.w, c.w, d.w));
}

// A curve without blocked texels keeps its bits.
fn store_pair(view: GpuView, at: vec2<u32>, pair: u32, softened: vec4<bool>) {
    let nodes = packed_pair(pair);
    let layer = curve_layer(view.layer, pair);
    for (var i = 0u; i < ROWS; i += 1u) {
        let own = textureLoad(raw_curves, at + vec2(0u, i), layer, 0);
        textureStore(curves, at + vec2(0u, i), layer, select(own, packed_row(nodes, i), softened[i]));
    }
}

@compute @workgroup_size(8, 8)
fn soften_curve_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let size = vec2<i32>(view.size);
    let first = vec2<i32>(id.xy) * vec2(1, i32(ROWS));
    if any(first >= size) {
        return;
    }
    var passing = white4();
    var start = vec4(0.0);
    var end = vec4(0.0);
    var softened = vec4(false);
    for (var i = 0u; i < ROWS; i += 1u) {
        let texel = vec2(first.x, min(first.y + i32(i), size.y - 1));
        let run = column_run(view, size, texel);
        let own = vec2<i32>(view.origin) + texel;
        places[i] = vec2<u32>(select(own, vec2<i32>(run.hole), run.hole.x >= 0.0));
        let left = max(1.0 - run.blocked, vec3(0.0));
        passing.red[i] = left.r;
        passing.green[i] = left.g;
        passing.blue[i] = left.b;
        softened[i] = run.moments.x > 0.0;
        let span = ramp(run);
        start[i] = select(0.0, span.x, softened[i]);
        end[i] = select(0.0, span.y, softened[i]);
    }
    clear_list();
    adding = black4();
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        load_pair(view, pair);
    }
    let behind = decode_light(node_lights[NODES - 1u], node_means[NODES - 1u]);
    insert(fixed(start), fixed(end), passing, scaled(behind, passing), softened);
    let at = view.origin + vec2<u32>(first);
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        store_pair(view, at, pair, softened);
    }
}
