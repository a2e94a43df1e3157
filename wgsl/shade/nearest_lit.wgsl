// Light past occluders that another occluder hides from the light's centre: taken from the nearest lit block.

import package::curve::node::{node_start, quick_length, quick_passed};
import package::records::area::{block_nodes, block_number, level_map};
import package::records::view::GpuView;
import package::shade::level_light::{Fade, NEVER, fade_between, pairs_before, share_before};
import package::shade::spot::{receiver_end, slack_within, spot_center};

// Least light of a lit block.
const LIT: f32 = 0.25;
// Part of a fade over which the share of occluders before it falls here: blocks of an occluder with much of
// its share behind the fade are lit, but dark at the receiver.
const EARLY: f32 = 0.1;
// Share of the brightest channel below which a channel has no share of its own.
const DIM: f32 = 0.01;
// Least light to divide by.
const MIN_LIT: f32 = 1e-4;

// Light of a block: behind its nodes so far, before the fade, and at the receiver.
var<private> lit_left: vec3<f32>;
var<private> lit_before: vec3<f32>;
var<private> lit_here: vec3<f32>;

fn light_node(node: vec2<u32>, fade: Fade, end: f32) {
    let start = node_start(node);
    let length = max(quick_length(node), 1.0);
    let light = lit_left * quick_passed(node);
    let drop = select(vec3(0.0), lit_left - light, start > 0.0);
    lit_left = light;
    let inverse = 1.0 / length;
    let before = share_before(fade, start, start + length, inverse);
    let here = (clamp(end, start, start + length) - start) * inverse;
    lit_before -= drop * before;
    lit_here -= drop * max(here, before);
}

// Share of the light behind a fade that reaches the receiver. Levels are asked from `first` to coarser ones,
// up to `last`, until a block around the point is lit, then back to the finest along the nearest lit blocks.
// 1 if no block is lit, or if `first` is beyond `last`.
fn nearest_lit(view: GpuView, leveled: u32, first: u32, last: u32, since: vec2<f32>) -> vec3<f32> {
    let fade = fade_between(vec2(since.x, since.x + EARLY * (since.y - since.x)));
    var number = first;
    var position = spot_center;
    var share = vec3(1.0);
    var is_found = false;
    // The loop count is not constant, so that compilers do not unroll.
    let four = select(0u, 4u, first <= last);
    if first > 0u && first <= last {
        loop {
            let map = level_map(view, leveled, number);
            let slack = slack_within(select(map.edge, 1.0, number == 1u));
            let corner = floor(position / map.edge - 0.5);
            var nearest = NEVER;
            var i = 0u;
            loop {
                let at = corner + vec2<f32>(vec2(i % 2u, i / 2u));
                let middle = (at + 0.5) * map.edge;
                let end = receiver_end(middle, slack);
                let block = block_number(map, vec2<i32>(at));
                lit_left = vec3(1.0);
                lit_before = vec3(1.0);
                lit_here = vec3(1.0);
                var nodes = block_nodes(block, 0u);
                let pairs = pairs_before(nodes, end);
                var pair = 1u;
                loop {
                    light_node(nodes.xy, fade, end);
                    light_node(nodes.zw, fade, end);
                    if pair >= pairs {
                        break;
                    }
                    nodes = block_nodes(block, pair);
                    pair += 1u;
                }
                let off = middle - spot_center;
                let away = dot(off, off);
                let open = max(lit_before.x, max(lit_before.y, lit_before.z));
                let is_nearest = open > LIT && away < nearest;
                let mean = vec3(max(lit_here.x, max(lit_here.y, lit_here.z)) / max(open, MIN_LIT));
                let ratio = lit_here / max(lit_before, vec3(MIN_LIT));
                let here = select(ratio, mean, lit_before < vec3(DIM * open));
                share = select(share, here, is_nearest);
                position = select(position, middle, is_nearest);
                nearest = select(nearest, away, is_nearest);
                i += 1u;
                if i >= four {
                    break;
                }
            }
            let is_lit = nearest < NEVER;
            // A lit block whose finer neighbours are all dark has the finest share known.
            let is_last = is_found && !is_lit;
            is_found = is_found || is_lit;
            number = select(select(number + 1u, number - 1u, is_found), 0u, is_last);
            if number == 0u || number > last {
                break;
            }
        }
    }
    return share;
}
