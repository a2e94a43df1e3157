// Light of a window of a level's blocks.

import package::curve::node::{node_start, quick_length, quick_passed};
import package::records::area::{LevelMap, block_nodes, block_number};
import package::shade::cells::{cell_at, cells_around, is_past, next_cell};
import package::shade::spot::{
    FADE, WIDEST, box_area, box_cover, box_of_level, box_reach, box_widths, receiver_end, slack_within,
    spot_at, spot_center, spot_shape, spot_shear, turned,
};

// Smallest change of light that counts as an occluder.
const NOTHING: f32 = 1e-3;
const NEVER: f32 = 1e30;
// Distance from a block's middle over which a plane's ramp spreads in it [blocks]; half a block at the first
// level, whose blocks don't overlap.
const BLOCK_REACH: f32 = 1.0;

// Light of a level's blocks, averaged over its boxes.
struct LevelLight {
    before: vec3<f32>, // light before the level's depths
    taken: vec3<f32>,
    behind: vec3<f32>,
    most: vec3<f32>,   // bound of the light left of `before`
    next: f32,         // first depth behind the level's depths that removes light; NEVER for none
}

// Light that the ramp of a node takes.
struct Drop {
    start: f32,
    length: f32,
    light: vec3<f32>,
}

// `left`: light behind the nodes before; behind this one afterwards.
fn drop_of(node: vec2<u32>, left: ptr<function, vec3<f32>>) -> Drop {
    let start = node_start(node);
    let light = *left * quick_passed(node);
    let drop = select(vec3(0.0), *left - light, start > 0.0);
    *left = light;
    return Drop(start, quick_length(node), drop);
}

fn takes_light(drop: Drop) -> bool {
    return any(abs(drop.light) > vec3(NOTHING));
}

// Whether a block has nodes behind its first pair that start before the receiver.
fn continues(first: vec4<u32>, end: f32) -> bool {
    let start = node_start(first.zw);
    return (start > 0.0) & (start < end);
}

// Rows of blocks on each side of the two next to the point that are searched for occluders: those of a long
// spot.
fn search_rows() -> f32 {
    return round(max(spot_shape.y - 1.0, 0.0));
}

struct Occluder {
    depth: f32, // NEVER for none
    open: f32,  // least light of a block where the search starts
}

// Blocker search (Fernando 2005) in a level: first depth from `since` on at which blocks around the point
// remove light. `beyond`: distance behind the receiver's end up to which a filter counts, which may touch the
// receiver.
fn next_occluder(map: LevelMap, since: f32, around: f32, beyond: f32, is_asked: bool) -> Occluder {
    let middle = turned(spot_center / map.edge - 0.5);
    var row = floor(middle.y) - search_rows();
    let last = floor(middle.y) + search_rows() + 1.0;
    var found = Occluder(NEVER, 1.0);
    var is_right = false;
    var left = vec3(1.0);
    var open = vec3(1.0);
    var pair = 0u;
    if is_asked {
        loop {
            let column = floor(middle.x + spot_shear * (row - middle.y)) + select(0.0, 1.0, is_right);
            let at = turned(vec2(column, row));
            let end = receiver_end((at + 0.5) * map.edge, slack_within(around * map.edge));
            let nodes = block_nodes(block_number(map, vec2<i32>(at)), pair);
            let is_first = pair == 0u;
            left = select(left, vec3(1.0), is_first);
            open = select(open, vec3(1.0), is_first);
            for (var i = 0u; i < 2u; i += 1u) {
                let drop = drop_of(select(nodes.xy, nodes.zw, i == 1u), &left);
                let past = drop.start + drop.length;
                open = select(open, left, (drop.start > 0.0) & (past < since));
                let first = max(drop.start, since);
                let stop = end + select(0.0, beyond, any(left > vec3(0.0)));
                let counts = takes_light(drop) & (past >= since) & (first < stop);
                found.depth = select(found.depth, min(found.depth, first), counts);
            }
            if is_first & continues(nodes, end + beyond) {
                pair = 1u;
            } else {
                pair = 0u;
                found.open = min(found.open, max(open.x, max(open.y, open.z)));
                row += select(0.0, 1.0, is_right);
                is_right = !is_right;
                if row > last {
                    break;
                }
            }
        }
    }
    return found;
}

// Light of a level's depths from the fade into it to the fade out of it. `widest`: widths of the box of their
// widest spot.
fn light_of_level(map: LevelMap, widest: vec2<f32>, fade_in: vec2<f32>, fade_out: vec2<f32>) -> LevelLight {
    let since = fade_between(fade_in);
    let to = fade_between(fade_out);
    let box = box_of_level(map.edge);
    let per_area = 1.0 / box_area(widest);
    var sum = LevelLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), NEVER);
    var cells = cells_around(spot_center / map.edge - 0.5, box_reach(widest));
    var left = vec3(1.0);
    var pair = 0u;
    loop {
        let at = cell_at(cells);
        let weight = box_cover(cells.reach, cells.off);
        let reach = select(BLOCK_REACH * map.edge, 1.0, map.edge == 2.0);
        let end = receiver_end((at + 0.5) * map.edge, slack_within(reach));
        let nodes = block_nodes(block_number(map, vec2<i32>(at)), pair);
        let is_first = pair == 0u;
        left = select(left, vec3(1.0), is_first);
        sum.before += select(0.0, weight, is_first);
        sum.behind += select(0.0, weight, is_first);
        for (var i = 0u; i < 2u; i += 1u) {
            let drop = drop_of(select(nodes.xy, nodes.zw, i == 1u), &left);
            let length = max(drop.length, 1.0);
            let next = max(drop.start, to.low);
            let follows = takes_light(drop) & (drop.start + length > to.low) & (next < end);
            sum.next = select(sum.next, min(sum.next, next), follows);
            let inverse = 1.0 / length;
            let stop = clamp(end, drop.start, drop.start + length);
            let before = share_before(since, drop.start, stop, inverse);
            let within = share_before(to, drop.start, stop, inverse);
            sum.before -= drop.light * (before * weight);
            sum.behind -= drop.light * (within * weight);
            // Spots of the coarsest level may be wider than its box.
            let spot = spot_at(drop.start + length * 0.5 * (before + within));
            let widths = min(box_widths(box, spot), 2.0 * cells.reach - 1.0);
            let share = box_cover(box_reach(widths), cells.off) / box_area(widths);
            sum.taken += drop.light * ((within - before) * share);
        }
        if is_first & continues(nodes, end) {
            pair = 1u;
        } else {
            pair = 0u;
            cells = next_cell(cells);
            if is_past(cells) {
                break;
            }
        }
    }
    // Light left in a narrower box is part of that in the widest: per area, at most as much.
    let narrow = box_widths(box, WIDEST * (1.0 - FADE) * 0.5 * map.edge);
    let most = sum.behind / box_area(narrow);
    return LevelLight(sum.before * per_area, sum.taken, sum.behind * per_area, most, sum.next);
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
