// soften, curve columns: curves of four texels in a column per invocation, multiplied by the visibility
// through dithered surfaces over a window. CPU reference: src/reference/curve/soften.rs. Rust:
// src/stage/soften.rs.

import package::bind::sampled::raw_curves;
import package::bind::stored::curves;
import package::bind::uniform::views;
import package::curve::lights::{Lights, fixed, scaled, selected, white, with_light};
import package::curve::list::{Node, clear_list, coded, insert, light_behind, merge_nodes, must_merge};
import package::curve::loaded::loaded_node;
import package::curve::node::curve_layer;
import package::curve::stored::{begin_stored, stored_node, stored_pair};
import package::features::{NODES, unrolled};
import package::records::view::GpuView;
import package::soften::run::{EMPTY_RUN, Run, add_run, load_run, window};
import choice::nodes::{node_at, set_node};
import choice::rows::{ROW_COUNT, RowBits, Rows, row, with_bits, with_row};

const ROWS: u32 = 4u;

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

var<private> loaded_light: Lights; // behind the nodes that were unpacked

fn unpacked(firsts: RowBits, seconds: RowBits) -> Node {
    let node = loaded_node(firsts, seconds);
    let none = node.start == RowBits(0u);
    let span = (node.start << RowBits(16u)) | node.end;
    loaded_light = selected(scaled(loaded_light, node.passed), loaded_light, none);
    return coded(select(span, RowBits(0u), none), loaded_light);
}

var<private> texels: array<vec2<u32>, ROW_COUNT>; // atlas texels of the curves that are softened

fn load_curves(view: GpuView) {
    loaded_light = white();
    for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
        let layer = curve_layer(view.layer, pair);
        var words = array(RowBits(0u), RowBits(0u), RowBits(0u), RowBits(0u));
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            let nodes = textureLoad(raw_curves, texels[i], layer, 0);
            words[0] = with_bits(words[0], i, nodes.x);
            words[1] = with_bits(words[1], i, nodes.y);
            words[2] = with_bits(words[2], i, nodes.z);
            words[3] = with_bits(words[3], i, nodes.w);
        }
        set_node(2u * pair, unpacked(words[0], words[1]));
        set_node(2u * pair + 1u, unpacked(words[2], words[3]));
    }
}

// A curve without blocked texels keeps its bits.
fn store_curves(view: GpuView, first: vec2<u32>, blocked: Rows) {
    begin_stored();
    for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
        let layer = curve_layer(view.layer, pair);
        let a = stored_node(2u * pair);
        let b = stored_node(2u * pair + 1u);
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            let at = first + vec2(0u, i);
            let raw = textureLoad(raw_curves, at, layer, 0);
            textureStore(curves, at, layer, select(raw, stored_pair(a, b, i), row(blocked, i) > 0.0));
        }
    }
}

// `id`: of the invocation.
fn soften_texels(view: GpuView, id: vec2<u32>, first: vec2<i32>) {
    let size = vec2<i32>(view.size);
    var passing = white();
    var start = Rows(0.0);
    var end = Rows(0.0);
    var blocked = Rows(0.0);
    for (var i = 0u; i < ROW_COUNT; i += 1u) {
        let texel = vec2(first.x, min(first.y + i32(i), size.y - 1));
        let run = column_run(view, size, texel);
        let at = vec2<i32>(view.origin) + texel;
        texels[i] = vec2<u32>(select(at, vec2<i32>(run.hole), run.hole.x >= 0.0));
        passing = with_light(passing, i, max(1.0 - run.blocked, vec3(0.0)));
        blocked = with_row(blocked, i, run.moments.x);
        let span = select(vec2(0.0), ramp(run), run.moments.x > 0.0);
        start = with_row(start, i, span.x);
        end = with_row(end, i, span.y);
    }
    clear_list(id);
    load_curves(view);
    let behind = scaled(light_behind(node_at(NODES - 1u)), passing);
    insert(fixed(start), fixed(end), passing, behind, blocked > Rows(0.0));
    if must_merge() {
        merge_nodes();
    }
    store_curves(view, view.origin + vec2<u32>(first), blocked);
}

@compute @workgroup_size(8, 8)
fn soften_curve_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    for (var i = 0u; i < ROWS; i += ROW_COUNT) {
        let first = vec2<i32>(vec2(id.x, ROWS * id.y + i));
        if all(first < vec2<i32>(view.size)) {
            soften_texels(view, id.xy, first);
        }
    }
}
