// Light of a window of a level's blocks.

import package::curve::node::{node_start, quick_length, quick_passed};
import package::records::area::{LevelMap, block_nodes, block_number};
import package::shade::spot::{
    Windows, narrower, receiver_end, slack_within, spot_at, spot_center, spot_shape, spot_shear, turned,
    window_cover, windows_of,
};

// Smallest change of light that counts as an occluder.
const NOTHING: f32 = 1e-3;
const NEVER: f32 = 1e30;
// Distance from a block's middle over which a plane's ramp spreads in it [blocks]; half a block at the first
// level, whose blocks don't overlap.
const BLOCK_REACH: f32 = 1.0;

// Light of a level's blocks, averaged over its windows.
struct LevelLight {
    before: vec3<f32>, // light before the level's depths
    taken: vec3<f32>,
    behind: vec3<f32>,
    most: vec3<f32>,   // bound of the light left of `before`
    next: f32,         // first depth behind the level's depths that removes light; NEVER for none
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
    let light = light_left * quick_passed(node);
    let drop = abs(light_left - light);
    light_left = light;
    let past = start + quick_length(node);
    light_open = select(light_open, light, start > 0.0 && past < since);
    let first = max(start, since);
    let takes = any(drop > vec3(NOTHING));
    let last = end + select(0.0, beyond, any(light > vec3(0.0)));
    let is = start > 0.0 && takes && past >= since && first < last;
    first_depth = select(first_depth, min(first_depth, first), is);
}

// Pairs of a block's nodes to evaluate: not the second, if all of it is behind the receiver.
fn pairs_before(first: vec4<u32>, end: f32) -> u32 {
    let start = node_start(first.zw);
    return select(1u, 2u, start > 0.0 && start < end);
}

// Rows of blocks on each side of the two next to the point that are searched for occluders: those of a long
// spot.
fn search_rows() -> f32 {
    return round(max(spot_shape.y - 1.0, 0.0));
}

// Blocker search (Fernando 2005) in a level: first depth from `since` on at which `blocks` around the point
// remove light; NEVER for none. `beyond`: distance behind the receiver's end up to which a filter counts,
// which may touch the receiver. Sets `least_open`.
fn next_occluder(map: LevelMap, blocks: u32, since: f32, around: f32, beyond: f32) -> f32 {
    let middle = turned(spot_center / map.edge - 0.5);
    let slack = slack_within(around * map.edge);
    var row = floor(middle.y) - search_rows();
    first_depth = NEVER;
    least_open = 1.0;
    // Loops test at their end: llvmpipe executes a body once more where the test comes first.
    var i = 0u;
    if blocks > 0u {
        loop {
            let column = floor(middle.x + spot_shear * (row - middle.y)) + f32(i % 2u);
            let at = turned(vec2(column, row));
            row += f32(i % 2u);
            let end = receiver_end((at + 0.5) * map.edge, slack);
            let block = block_number(map, vec2<i32>(at));
            light_left = vec3(1.0);
            light_open = vec3(1.0);
            var nodes = block_nodes(block, 0u);
            let pairs = pairs_before(nodes, end + beyond);
            var pair = 1u;
            loop {
                find_occluder(nodes.xy, since, end, beyond);
                find_occluder(nodes.zw, since, end, beyond);
                if pair >= pairs {
                    break;
                }
                nodes = block_nodes(block, pair);
                pair += 1u;
            }
            least_open = min(least_open, max(light_open.x, max(light_open.y, light_open.z)));
            i += 1u;
            if i >= blocks {
                break;
            }
        }
    }
    return first_depth;
}

// Values of the evaluated level. Hoisted by hand: llvmpipe's compiler leaves divisions in loops.
var<private> fade_since: Fade; // into the level above
var<private> fade_to: Fade;    // into the level below
var<private> windows: Windows;

// Light of a block behind the nodes so far.
var<private> node_left: vec3<f32>;

// `weight`: of the block in the widest window; `change`: of the weight from each window to the narrower one.
fn evaluate_node(node: vec2<u32>, weight: f32, change: vec2<f32>, end: f32) {
    let start = node_start(node);
    let length = max(quick_length(node), 1.0);
    let light = node_left * quick_passed(node);
    let drop = select(vec3(0.0), node_left - light, start > 0.0);
    node_left = light;
    let takes = any(abs(drop) > vec3(NOTHING));
    let next = max(start, fade_to.low);
    let follows = takes && start + length > fade_to.low && next < end;
    level_light.next = select(level_light.next, min(level_light.next, next), follows);
    let inverse = 1.0 / length;
    let stop = clamp(end, start, start + length);
    let shares = vec2(
        share_before(fade_since, start, stop, inverse),
        share_before(fade_to, start, stop, inverse),
    );
    level_light.before -= drop * (shares.x * weight);
    level_light.behind -= drop * (shares.y * weight);
    let texels = spot_at(start + length * 0.5 * (shares.x + shares.y));
    let cover = weight + dot(change, narrower(windows, texels));
    level_light.taken += drop * ((shares.y - shares.x) * cover);
}

// Evaluates the depths of a level from the fade `since` to the fade `to`; `texels`: radius of their widest
// spot.
fn evaluate_level(map: LevelMap, texels: f32, since: vec2<f32>, to: vec2<f32>) {
    let per_edge = 1.0 / map.edge;
    fade_since = fade_between(since);
    fade_to = fade_between(to);
    windows = windows_of(texels, spot_at(to.y), per_edge);
    let middle = turned(spot_center * per_edge - 0.5);
    let half = 0.5 * (windows.wide.width + 1.0);
    let low = ceil(middle.y - half.y);
    let high = floor(middle.y + half.y);
    // Bound of rows times columns, where floats are too coarse to count them.
    var left = u32((floor(2.0 * half.x) + 1.0) * (high - low + 1.0));
    let reach = select(BLOCK_REACH * map.edge, 1.0, map.edge == 2.0);
    level_light = LevelLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), NEVER);
    // Rows and columns are counted: division of integers is slow on llvmpipe. A sheared row starts anywhere
    // between two blocks.
    var row = low;
    var sheared = spot_shear * (row - middle.y);
    var column = ceil(middle.x + sheared - half.x);
    loop {
        let off = vec2(column - sheared, row) - middle;
        let wide = window_cover(off, windows.wide);
        let between = window_cover(off, windows.middle);
        let change = vec2(between - wide, window_cover(off, windows.narrow) - between);
        let at = turned(vec2(column, row));
        let end = receiver_end((at + 0.5) * map.edge, slack_within(reach));
        let block = block_number(map, vec2<i32>(at));
        node_left = vec3(1.0);
        level_light.before += wide;
        level_light.behind += wide;
        var nodes = block_nodes(block, 0u);
        let pairs = pairs_before(nodes, end);
        var pair = 1u;
        loop {
            evaluate_node(nodes.xy, wide, change, end);
            evaluate_node(nodes.zw, wide, change, end);
            if pair >= pairs {
                break;
            }
            nodes = block_nodes(block, pair);
            pair += 1u;
        }
        let is_last = !(column + 1.0 <= middle.x + sheared + half.x);
        row += select(0.0, 1.0, is_last);
        sheared = spot_shear * (row - middle.y);
        column = select(column + 1.0, ceil(middle.x + sheared - half.x), is_last);
        if left <= 1u || row > high {
            break;
        }
        left -= 1u;
    }
    // Light left in a narrower window is part of that in the widest: per area, at most as much.
    level_light.most = level_light.behind * (windows.narrow.per_area / windows.wide.per_area);
}

// Where one level hands over to the next, each occluder counts with a share that falls linearly over a range
// of depths. A block's ramp has the mean depth of its texels' ramps, and so the same share. Split at one
// depth, ramps of different lengths would have different shares, and the shadow a bright line.

// A fade: the share falls from 1 at `low` to 0 at `high`.
struct Fade {
    low: f32,
    high: f32,
    slope: f32,
}

fn fade_between(depths: vec2<f32>) -> Fade {
    return Fade(depths.x, depths.y, 1.0 / max(depths.y - depths.x, 1e-3));
}

// Share of a ramp of length 1 / `inverse` that counts as before the fade, seen from the light, of its part
// from `start` to `stop`.
fn share_before(fade: Fade, start: f32, stop: f32, inverse: f32) -> f32 {
    let inside = clamp(vec2(start, stop), vec2(fade.low), vec2(fade.high));
    let weights = (fade.high - inside) * fade.slope;
    let whole = max(min(stop, fade.low) - start, 0.0);
    return saturate((whole + (inside.y - inside.x) * 0.5 * (weights.x + weights.y)) * inverse);
}
