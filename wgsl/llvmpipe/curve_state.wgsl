// State of a walk of wgsl/llvmpipe/curve_queue.wgsl in an invocation's texels.

import package::curve::node::{DEPTHS, LEVELS};
import package::features::{NODES, unrolled};
import package::hit::disc::{Disc, disc_hit};
import package::llvmpipe::curve_texels::{ROWS, TRACE, corner, light_of, texels, unused_node};
import package::records::view::GpuView;
import package::sums::sums::BLACK;
import choice::output::store_nodes_where;

// Whether light can still change at or behind `front`.
fn changes(front: f32) -> bool {
    var most = vec3(0.0);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        most = max(most, select(vec3(0.0), texels[i].light, texels[i].opaque > front));
    }
    return any(most >= vec3(BLACK));
}

// Whether a nearest depth may still change.
fn seeks(front: f32) -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        some = some | ((texels[i].nearest > front) & (texels[i].opaque > front));
    }
    return some;
}

// Whether some texel may have few hits, by the count so far.
fn counts_on(front: f32) -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let is_open = any(texels[i].light >= vec3(BLACK)) & (texels[i].opaque > front);
        some = some | ((texels[i].count < f32(NODES + 1u)) & is_open);
    }
    return some;
}

// The same as `changes`, for the rows of `sample`.
fn sample_changes() -> bool {
    return any(max(texels[2].light, texels[5].light) >= vec3(BLACK));
}

fn sample_lost() -> f32 {
    return 6.0 - dot(light_of(2u) + light_of(5u), vec3(1.0));
}

// Light that the texels have lost.
fn lost_light() -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        sum += 3.0 - dot(light_of(i), vec3(1.0));
    }
    return sum;
}

// The same in the second walk, which keeps the sums of channels.
fn lost_so_far() -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        sum += 3.0 - texels[i].sum;
    }
    return sum;
}

fn sample_lost_so_far() -> f32 {
    return 6.0 - (texels[2].sum + texels[5].sum);
}

fn is_few(i: u32) -> bool {
    return (texels[i].count > 0.0) & (texels[i].count < f32(NODES + 1u));
}

// Rows that hold texels with few hits, as bits.
fn few_rows() -> u32 {
    var rows = 0u;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        rows |= select(0u, 1u << i, is_few(i));
    }
    return rows;
}

fn has_many() -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        some = some | (texels[i].count >= f32(NODES + 1u));
    }
    return some;
}

// Curves of a row of an invocation's texels with few hits, each of which has a node.

// The row of texels with few hits that is walked.
struct Row {
    offset: f32,     // from the first texel
    opaque: f32,
    is_few: bool,
    owed: vec3<f32>, // what rounding has taken of what the nodes pass
}

var<private> few: Row;
var<private> few_nodes: array<vec2<u32>, 16>; // the last ones are used

fn start_few(row: u32) {
    few = Row(f32(row), 1.0, false, vec3(0.0));
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        few.opaque = select(few.opaque, texels[i].opaque, i == row);
        few.is_few = select(few.is_few, is_few(i), i == row);
    }
    for (var k = 0u; k < unrolled(NODES); k += 1u) {
        few_nodes[k] = unused_node();
    }
}

// Puts a node behind the others.
fn push_node(node: vec2<u32>, is: bool) {
    for (var k = 0u; k < unrolled(NODES - 1u); k += 1u) {
        few_nodes[k] = select(few_nodes[k], few_nodes[k + 1u], is);
    }
    few_nodes[NODES - 1u] = select(few_nodes[NODES - 1u], node, is);
}

// Adds a hit, with a node of its own.
fn add_few(own: vec3<f32>, depth: f32, is_hit: bool) {
    let wanted = clamp(own + few.owed, vec3(0.0), vec3(1.0));
    let level = round(wanted * LEVELS);
    few.owed = select(few.owed, wanted - level * (1.0 / LEVELS), is_hit);
    let start = u32(clamp(round(depth * DEPTHS), 1.0, DEPTHS));
    let bits = vec3<u32>(level);
    push_node(vec2((start << 16u) | (bits.r >> 8u), (bits.r << 24u) | (bits.g << 12u) | bits.b), is_hit);
}

fn visit_few(view: GpuView, disc: Disc) {
    let hit = disc_hit(view, disc, corner + vec2(0.5, few.offset + 0.5) - disc.center, few.opaque);
    add_few(1.0 - hit.profile * disc.absorbed, hit.depth, hit.profile * disc.slope >= TRACE);
}

fn store_few(view: GpuView) {
    var rest = unused_node();
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        rest = select(rest, texels[i].rest, f32(i) == few.offset);
    }
    push_node(rest, rest.x >= 0x10000u);
    for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
        let nodes = vec4(few_nodes[2u * pair], few_nodes[2u * pair + 1u]);
        store_nodes_where(view, corner, u32(few.offset), pair, nodes, few.is_few);
    }
}
