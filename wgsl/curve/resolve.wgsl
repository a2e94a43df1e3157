// Output: curves, filter and nearest depth of tiles with several segments, whose curves are appended to each
// other. CPU reference: crates/gobo-reference/src/curve/tile.rs.

import package::bind::read::partials;
import package::bind::stored::{filters, nearests};
import package::curve::blank::stays_blank;
import package::curve::lights::{
    Lights, black, fixed, light_row, minus, plus, scaled, selected, white, with_light,
};
import package::curve::list::{adding, clear_list, insert, last_end, merge_nodes, must_merge};
import package::curve::node::curve_segment;
import package::curve::overflow::{is_light, overflowed, rest_light};
import package::curve::stored::{first_node, loaded_node, partial_size};
import package::curve::tile::store_curves;
import package::curve::volumes::{
    Ramp, Unentered, begin_inside, clear_volumes, count_late, crossed, follow_inside, nearest_inside,
    rest_steps, surface_light,
};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES, unrolled};
import package::records::tile::Tile;
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::blackened;
import package::traversal::lane::sum_index;
import choice::rows::{ROW_COUNT, RowBits, RowIs, Rows, any_row, row, with_bits, with_row};

// A segment in the texels of an invocation.
var<private> next: Lights;       // its transfer of white light
var<private> next_scale: Lights; // its scale
var<private> next_density: Lights;
var<private> next_last: Rows;
var<private> next_unentered: Unentered;

fn partial_row(at: u32, i: u32) -> vec4<u32> {
    return partials[at + i * TILE_SIZE * partial_size()];
}

// `at`: record of the first row.
fn partial_light(at: u32) -> Lights {
    var light = white();
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        light = with_light(light, i, bitcast<vec3<f32>>(partial_row(at, i).rgb));
    }
    return light;
}

fn partial_last(at: u32) -> Rows {
    var last = Rows(0.0);
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        last = with_row(last, i, bitcast<f32>(partial_row(at, i).a));
    }
    return last;
}

// Loads a segment's record; returns its nearest depths.
fn load_segment(first: u32) -> Rows {
    next = partial_light(first);
    next_scale = next;
    if HAS_OVER || HAS_VOLUMES {
        next_scale = partial_light(first + 1u);
        next_last = partial_last(first + 2u);
        surface_light = behind(surface_light, partial_light(first + 3u), partial_light(first + 2u));
        next_density = partial_light(first + 4u);
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            crossed[i] += bitcast<vec4<i32>>(partial_row(first + 5u, i));
        }
        next_unentered = Unentered(
            partial_light(first + 6u),
            partial_light(first + 7u),
            partial_last(first + 6u),
            partial_last(first + 7u),
        );
    }
    return partial_last(first);
}

// Light behind a segment of scale `scale` that turns white into `joined`.
fn behind(light: Lights, joined: Lights, scale: Lights) -> Lights {
    if HAS_OVER {
        return plus(scaled(light, scale), minus(joined, scale));
    }
    return scaled(light, joined);
}

// Least value of 1 minus an added colour for which the scale can be recovered from white light.
const MIN_REST: f32 = 0.0625;

// Scale of a segment up to the depth behind which white light has become `light`; `scale` and `all` are the
// whole segment's scale and transfer of white. CPU reference: crates/gobo-reference/src/curve/mod.rs,
// `Affine`.
fn scale_share(light: Rows, scale: Rows, all: Rows, part: f32) -> Rows {
    let lost = 1.0 - scale;
    let rest = 1.0 - (all - scale) / max(lost, Rows(1e-3));
    let known = 1.0 - (1.0 - light) / max(rest, Rows(MIN_REST));
    let share = select(1.0 - lost * part, known, rest >= Rows(MIN_REST));
    return min(max(share, scale), Rows(1.0));
}

fn scale_shares(light: Lights, part: f32) -> Lights {
    return Lights(
        scale_share(light.red, next_scale.red, next.red, part),
        scale_share(light.green, next_scale.green, next.green, part),
        scale_share(light.blue, next_scale.blue, next.blue, part),
    );
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    let at = view.origin + tile.position * TILE_SIZE + in_tile;
    let count = (tile.end - tile.first + curve_segment() - 1u) / curve_segment();
    let blank = stays_blank(view, tile.position * TILE_SIZE, true);
    clear_list(in_tile);
    clear_volumes();
    var passed = white(); // light behind the curve so far, by its rounded nodes
    var reached = white(); // light at the start of the segment
    var before = white(); // light behind the segment's last node
    var whole = white();  // filter of all segments
    var nearest = Rows(1.0);
    // Steps of a segment: the volumes that continue through it, if any, then its nodes; behind all segments,
    // the scattered casters.
    let ramps = select(0u, 1u, HAS_VOLUMES);
    let steps = ramps + NODES;
    for (var i = 0u; i < count * steps + rest_steps(); i += 1u) {
        let n = i % steps;
        var start = RowBits(0u);
        var end = RowBits(0u);
        var joined = white();
        var is = RowIs(false);
        adding = black();
        var ramp = Ramp(Rows(0.0), Rows(0.0), white(), RowIs(false));
        if i < count * steps {
            let first = sum_index(tile.merged - 1u + i / steps, in_tile) * partial_size();
            if n == 0u {
                nearest = min(nearest, load_segment(first));
                if HAS_VOLUMES {
                    ramp = follow_inside(next_density, next_last, next_unentered);
                    whole = scaled(whole, selected(white(), ramp.light, ramp.is));
                }
                whole = behind(whole, next, next_scale);
            }
            if n == ramps {
                reached = passed;
                before = white();
            }
            let node = max(n, ramps) - ramps;
            var firsts = RowBits(0u);
            var seconds = RowBits(0u);
            for (var k = 0u; k < unrolled(ROW_COUNT); k += 1u) {
                let pair = partial_row(first + first_node() + node / 2u, k);
                firsts = with_bits(firsts, k, select(pair.x, pair.z, node % 2u == 1u));
                seconds = with_bits(seconds, k, select(pair.y, pair.w, node % 2u == 1u));
            }
            let loaded = loaded_node(firsts, seconds);
            let light = scaled(before, loaded.passed);
            start = loaded.start;
            end = loaded.end;
            if HAS_OVER {
                let share = scale_shares(light, f32(node + 1u) / f32(NODES));
                joined = black();
                adding = plus(scaled(reached, share), minus(light, share));
            } else {
                joined = loaded.passed;
            }
            before = light;
            is = (start > RowBits(0u)) & RowIs(n >= ramps);
        }
        if HAS_VOLUMES && i >= count * steps && i + 1u < count * steps + rest_steps() {
            ramp = begin_inside(i - count * steps);
            whole = scaled(whole, selected(white(), ramp.light, ramp.is));
        }
        if HAS_VOLUMES && any_row(ramp.is) {
            count_late(ramp);
            start = select(start, fixed(ramp.start), ramp.is);
            end = select(end, fixed(ramp.end), ramp.is);
            joined = selected(joined, ramp.light, ramp.is);
            adding = selected(adding, black(), ramp.is);
            is = is | ramp.is;
        }
        // Once, behind all segments.
        if i + 1u == count * steps + rest_steps() {
            let rest = overflowed(sum_index(tile_id, in_tile), true);
            joined = rest_light(rest, whole);
            is = is_light(joined);
            start = max(fixed(select(nearest, rest.depth, rest.depth < Rows(1.0))), last_end());
            end = start;
            whole = scaled(whole, joined);
            nearest = min(nearest, rest.depth);
        }
        passed = selected(passed, plus(scaled(passed, joined), adding), is);
        insert(start, end, joined, passed, is);
        if must_merge() {
            merge_nodes();
        }
    }
    if HAS_VOLUMES {
        nearest = nearest_inside(nearest);
    }
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let texel = at + vec2(0u, i);
        let filtered = min(light_row(whole, i), vec3(65504.0));
        textureStore(filters, texel, view.layer, vec4(blackened(filtered), 1.0));
        textureStore(nearests, texel, view.layer, vec4(row(nearest, i)));
    }
    store_curves(view, at);
}
