// Light past occluders that another occluder hides from the light's centre: taken from the nearest lit block.

import package::records::area::{block_nodes, block_number, level_map};
import package::records::view::GpuView;
import package::shade::level_light::{NEVER, continues, drop_of, fade_between, share_before};
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

// Share of the light behind a fade that reaches the receiver. Levels are asked from `first` to coarser ones,
// up to `last`, until a block around the point is lit, then back to the finest along the nearest lit blocks.
// 1 if no block is lit, or if `first` is beyond `last`.
fn nearest_lit(view: GpuView, leveled: u32, first: u32, last: u32, since: vec2<f32>) -> vec3<f32> {
    let fade = fade_between(vec2(since.x, since.x + EARLY * (since.y - since.x)));
    var number = first;
    var position = spot_center;
    var share = vec3(1.0);
    var is_found = false;
    if (first > 0u) & (first <= last) {
        loop {
            let map = level_map(view, leveled, number);
            let slack = slack_within(select(map.edge, 1.0, number == 1u));
            let corner = floor(position / map.edge - 0.5);
            var nearest = NEVER;
            var left = vec3(1.0);
            var before = vec3(1.0);
            var here = vec3(1.0); // at the receiver
            var i = 0u;
            var pair = 0u;
            loop {
                let at = corner + vec2<f32>(vec2(i % 2u, i / 2u));
                let middle = (at + 0.5) * map.edge;
                let end = receiver_end(middle, slack);
                let nodes = block_nodes(block_number(map, vec2<i32>(at)), pair);
                let is_first = pair == 0u;
                left = select(left, vec3(1.0), is_first);
                before = select(before, vec3(1.0), is_first);
                here = select(here, vec3(1.0), is_first);
                for (var n = 0u; n < 2u; n += 1u) {
                    let drop = drop_of(select(nodes.xy, nodes.zw, n == 1u), &left);
                    let length = max(drop.length, 1.0);
                    let early = share_before(fade, drop.start, drop.start + length, 1.0 / length);
                    let until = clamp(end, drop.start, drop.start + length) - drop.start;
                    before -= drop.light * early;
                    here -= drop.light * max(until / length, early);
                }
                if is_first & continues(nodes, end) {
                    pair = 1u;
                } else {
                    let off = middle - spot_center;
                    let away = dot(off, off);
                    let open = max(before.x, max(before.y, before.z));
                    let is_nearest = (open > LIT) & (away < nearest);
                    let mean = vec3(max(here.x, max(here.y, here.z)) / max(open, MIN_LIT));
                    let ratio = here / max(before, vec3(MIN_LIT));
                    share = select(share, select(ratio, mean, before < vec3(DIM * open)), is_nearest);
                    position = select(position, middle, is_nearest);
                    nearest = select(nearest, away, is_nearest);
                    pair = 0u;
                    i += 1u;
                    if i == 4u {
                        break;
                    }
                }
            }
            let is_lit = nearest < NEVER;
            // A lit block whose finer neighbours are all dark has the finest share known.
            let is_last = is_found & !is_lit;
            is_found = is_found | is_lit;
            number = select(select(number + 1u, number - 1u, is_found), 0u, is_last);
            if (number == 0u) | (number > last) {
                break;
            }
        }
    }
    return share;
}
