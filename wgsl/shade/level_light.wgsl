// Light of a window of a level's blocks. CPU twin: src/reference/shading/level_light.rs.

import package::curve::node::{node_length, node_light, node_start};
import package::records::area::{LevelMap, block_nodes, block_number};
import package::shade::fade::{Fade, fade_between, share_before};
import package::shade::spot::{
    Window, filter_width, receiver_end, slack_within, spot_at, spot_center, spot_shear, turned,
    window_cover, window_of,
};

// Smallest change of light that counts as an occluder.
const NOTHING: f32 = 1e-3;
const NEVER: f32 = 1e30;
// Distance from a block's middle that a plane's ramp in it spans [blocks]; half a block at the first level,
// whose blocks don't overlap.
const BLOCK_REACH: f32 = 1.0;

// Light of a level's blocks, averaged over the window.
struct LevelLight {
    before: vec3<f32>, // light before the level's depths
    taken: vec3<f32>,
    behind: vec3<f32>,
    most: vec3<f32>,   // the most that can be left of `before`
    next: f32,         // first depth behind the level's that removes light; NEVER for none
}

var<private> level_light: LevelLight;

// Light behind the nodes of a block so far, and behind those that end before the search.
var<private> light_left: vec3<f32>;
var<private> light_open: vec3<f32>;
var<private> first_depth: f32; // found so far
var<private> least_open: f32;  // least light of a block where the search starts

// A filter counts up to `beyond` behind `end`.
fn find_occluder(node: vec2<u32>, since: f32, end: f32, beyond: f32) {
    let start = node_start(node);
    let light = node_light(node);
    let drop = abs(light_left - light);
    light_left = light;
    let past = start + node_length(node);
    light_open = select(light_open, light, start > 0.0 && past < since);
    let first = max(start, since);
    let takes = max(drop.x, max(drop.y, drop.z)) > NOTHING;
    let last = end + select(0.0, beyond, any(light > vec3(0.0)));
    let is = start > 0.0 && takes && past >= since && first < last;
    first_depth = select(first_depth, min(first_depth, first), is);
}

// Pairs of a block's nodes to evaluate: the second one not, if all of it is behind the receiver.
fn pairs_before(first: vec4<u32>, end: f32) -> u32 {
    let start = node_start(first.zw);
    return select(1u, 2u, start > 0.0 && start < end);
}

// First depth from `since` on at which `blocks` (0 or 4) of a level around the point remove light; NEVER
// for none. `beyond`: how far behind the receiver's end a filter counts, which may touch the receiver. Sets
// `least_open`.
fn next_occluder(map: LevelMap, blocks: u32, since: f32, around: f32, beyond: f32) -> f32 {
    let corner = vec2<i32>(floor(spot_center / map.edge - 0.5));
    let slack = slack_within(around * map.edge);
    first_depth = NEVER;
    least_open = 1.0;
    for (var i = 0u; i < blocks; i += 1u) {
        let at = corner + vec2<i32>(vec2(i % 2u, i / 2u));
        let end = receiver_end((vec2<f32>(at) + 0.5) * map.edge, slack);
        let block = block_number(map, at);
        light_left = vec3(1.0);
        light_open = vec3(1.0);
        var nodes = block_nodes(block, 0u);
        let pairs = pairs_before(nodes, end + beyond);
        for (var pair = 0u; pair < pairs; pair += 1u) {
            find_occluder(nodes.xy, since, end, beyond);
            find_occluder(nodes.zw, since, end, beyond);
            nodes = block_nodes(block, 1u);
        }
        least_open = min(least_open, max(light_open.x, max(light_open.y, light_open.z)));
    }
    return first_depth;
}

// Of the level that is evaluated. Hoisted by hand: compilers of llvmpipe leave divisions in loops.
var<private> fade_since: Fade; // into the level above
var<private> fade_to: Fade;    // into the level below
var<private> window: Window;       // of its widest spot

// Light of a block behind the nodes so far; before the level's depths, and behind them.
var<private> node_left: vec3<f32>;
var<private> block_light: mat2x3<f32>;

fn evaluate_node(node: vec2<u32>, off: vec2<f32>, end: f32) {
    let start = node_start(node);
    let length = max(node_length(node), 1.0);
    let light = node_light(node);
    let drop = select(vec3(0.0), node_left - light, start > 0.0);
    node_left = light;
    let size = abs(drop);
    let takes = max(size.x, max(size.y, size.z)) > NOTHING;
    let next = max(start, fade_to.low);
    let follows = takes && start + length > fade_to.low && next < end;
    level_light.next = select(level_light.next, min(level_light.next, next), follows);
    let inverse = 1.0 / length;
    let stop = clamp(end, start, start + length);
    let shares = vec2(
        share_before(fade_since, start, stop, inverse),
        share_before(fade_to, start, stop, inverse),
    );
    block_light -= mat2x3(drop * shares.x, drop * shares.y);
    let texels = spot_at(start + length * 0.5 * (shares.x + shares.y));
    let cover = window_cover(off, min(filter_width(window, texels), window.width));
    level_light.taken += drop * ((shares.y - shares.x) * cover);
}

// Evaluates the depths from the fade `since` to the fade `to` on a level; `texels` is the radius of their
// widest spot.
fn evaluate_level(map: LevelMap, texels: f32, since: vec2<f32>, to: vec2<f32>) {
    let per_edge = 1.0 / map.edge;
    fade_since = fade_between(since);
    fade_to = fade_between(to);
    window = window_of(texels, per_edge);
    let middle = turned(spot_center * per_edge - 0.5);
    let half = 0.5 * (window.width + 1.0);
    let low = ceil(middle - half);
    let straight = floor(middle + half) - low + 1.0;
    // A sheared row starts anywhere between two blocks.
    let columns = select(floor(2.0 * half.x) + 1.0, straight.x, spot_shear == 0.0);
    let count = u32(columns * straight.y);
    let reach = select(BLOCK_REACH * map.edge, 1.0, map.edge == 2.0);
    let slack = slack_within(reach);
    level_light = LevelLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), NEVER);
    // Row and column are counted: division of integers is slow on llvmpipe.
    var row = low.y;
    var step = 0.0;
    for (var i = 0u; i < count; i += 1u) {
        let sheared = spot_shear * (row - middle.y);
        let column = ceil(middle.x + sheared - half.x) + step;
        let off = vec2(column - sheared, row) - middle;
        let weight = window_cover(off, window.width);
        let at = turned(vec2(column, row));
        // A block beside the window is as if behind the receiver.
        let end = select(0.0, receiver_end((at + 0.5) * map.edge, slack), weight > 0.0);
        let block = block_number(map, vec2<i32>(at));
        node_left = vec3(1.0);
        block_light = mat2x3(vec3(1.0), vec3(1.0));
        var nodes = block_nodes(block, 0u);
        let pairs = pairs_before(nodes, end);
        for (var pair = 0u; pair < pairs; pair += 1u) {
            evaluate_node(nodes.xy, off, end);
            evaluate_node(nodes.zw, off, end);
            nodes = block_nodes(block, 1u);
        }
        level_light.before += block_light[0] * weight;
        level_light.behind += block_light[1] * weight;
        let is_last = step + 1.0 >= columns;
        row += select(0.0, 1.0, is_last);
        step = select(step + 1.0, 0.0, is_last);
    }
    // The light left in a narrower window is part of that in the widest: at most as much per area.
    let least = min(filter_width(window, spot_at(to.y)), window.width);
    level_light.most = level_light.behind * (window.width.x * window.width.y / (least.x * least.y));
}
