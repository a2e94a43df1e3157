// Output: curves, filter and nearest depth of tiles with several segments, whose curves are appended to each
// other. CPU reference: src/reference/curve/tile.rs.

import package::bind::read::partials;
import package::bind::stored::{filters, nearests};
import package::curve::light4::{
    Light4, black4, fixed, light4, minus, plus, quotient, scaled, selected, white4,
};
import package::curve::list::{adding, clear_list, insert, last_end};
import package::curve::loaded::loaded_node;
import package::curve::node::CURVE_SEGMENT;
import package::curve::overflow::{is_light, overflowed, rest_light};
import package::curve::partial::{first_node, partial_size};
import package::curve::tile::store_curves;
import package::curve::volumes::{
    Ramp4, begin_inside, clear_volumes, count_late, crossed, follow_inside, nearest_inside,
    rest_steps, surface_light,
};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES};
import package::records::tile::Tile;
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::blackened;
import package::traversal::lane::sum_index;
import choice::accumulator::ROWS;

fn ordered() -> bool {
    return false;
}

// Four rows of a segment.
var<private> next: Light4;       // its light from white
var<private> next_scale: Light4; // its scale
var<private> next_density: Light4;
var<private> next_last: vec4<f32>;

fn partial_rows(at: u32) -> array<vec4<u32>, 4> {
    let row = TILE_SIZE * partial_size();
    return array(partials[at], partials[at + row], partials[at + 2u * row], partials[at + 3u * row]);
}

fn row_color(row: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(row.rgb);
}

fn rows_light(rows: array<vec4<u32>, 4>) -> Light4 {
    return light4(row_color(rows[0]), row_color(rows[1]), row_color(rows[2]), row_color(rows[3]));
}

fn rows_last(rows: array<vec4<u32>, 4>) -> vec4<f32> {
    return bitcast<vec4<f32>>(vec4(rows[0].a, rows[1].a, rows[2].a, rows[3].a));
}

// Returns nearest depths.
fn load_segment(first: u32) -> vec4<f32> {
    let whole = partial_rows(first);
    next = rows_light(whole);
    next_scale = next;
    if HAS_OVER || HAS_VOLUMES {
        next_scale = rows_light(partial_rows(first + 1u));
        let of_surfaces = partial_rows(first + 2u);
        let scale = rows_light(of_surfaces);
        next_last = rows_last(of_surfaces);
        surface_light = behind(surface_light, rows_light(partial_rows(first + 3u)), scale);
        next_density = rows_light(partial_rows(first + 4u));
        let faces = partial_rows(first + 5u);
        for (var i = 0u; i < ROWS; i += 1u) {
            crossed[i] += bitcast<vec4<i32>>(faces[i]);
        }
    }
    return rows_last(whole);
}

// Light behind a segment of scale `scale` and transfer `own` of white.
fn behind(light: Light4, own: Light4, scale: Light4) -> Light4 {
    if HAS_OVER {
        return plus(scaled(light, scale), minus(own, scale));
    }
    return scaled(light, own);
}

// Least rest of 1 minus an added colour from which the scale can be recovered from light through white.
const MIN_REST: f32 = 0.0625;

// Scale up to a depth behind which white light has become `light`, for a segment with `scale` and `all`
// behind it. CPU reference: src/reference/curve/mod.rs, `Affine`.
fn scale_share(light: vec4<f32>, scale: vec4<f32>, all: vec4<f32>, part: f32) -> vec4<f32> {
    let lost = 1.0 - scale;
    let rest = 1.0 - (all - scale) / max(lost, vec4(1e-3));
    let known = 1.0 - (1.0 - light) / max(rest, vec4(MIN_REST));
    let share = select(1.0 - lost * part, known, rest >= vec4(MIN_REST));
    return min(max(share, scale), vec4(1.0));
}

fn scale_shares(light: Light4, part: f32) -> Light4 {
    return Light4(
        scale_share(light.red, next_scale.red, next.red, part),
        scale_share(light.green, next_scale.green, next.green, part),
        scale_share(light.blue, next_scale.blue, next.blue, part),
    );
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, place: vec2<u32>) {
    let at = view.origin + tile.place * TILE_SIZE + place;
    let count = (tile.end - tile.first + CURVE_SEGMENT - 1u) / CURVE_SEGMENT;
    clear_list();
    clear_volumes();
    var passed = white4(); // light behind the curve so far, whose nodes are rounded
    var reached = white4(); // light at the start of the segment
    var before = white4(); // light behind the segment's last node
    var whole = white4();  // filter of all segments
    var nearest = vec4(1.0);
    // Steps of a segment: the volumes that continue through it, if there are any, then its nodes; behind
    // all segments the rest.
    let ramps = rest_steps() - 1u;
    let steps = ramps + NODES;
    for (var i = 0u; i < count * steps + rest_steps(); i += 1u) {
        let n = i % steps;
        var start = vec4(0u);
        var end = vec4(0u);
        var own = white4();
        var is = vec4(false);
        adding = black4();
        var ramp = Ramp4(vec4(0.0), vec4(0.0), white4(), vec4(false));
        if i < count * steps {
            let first = sum_index(tile.merged - 1u + i / steps, place) * partial_size();
            if n == 0u {
                nearest = min(nearest, load_segment(first));
                if HAS_VOLUMES {
                    ramp = follow_inside(next_density, next_last);
                    whole = scaled(whole, selected(white4(), ramp.light, ramp.is));
                }
                whole = behind(whole, next, next_scale);
            }
            if n == ramps {
                reached = passed;
                before = white4();
            }
            let node = max(n, ramps) - ramps;
            let rows = partial_rows(first + first_node() + node / 2u);
            let a = rows[0];
            let b = rows[1];
            let c = rows[2];
            let d = rows[3];
            let odd = node % 2u == 1u;
            let firsts = select(vec4(a.x, b.x, c.x, d.x), vec4(a.z, b.z, c.z, d.z), odd);
            let seconds = select(vec4(a.y, b.y, c.y, d.y), vec4(a.w, b.w, c.w, d.w), odd);
            let loaded = loaded_node(firsts, seconds);
            let light = loaded.light;
            start = loaded.start;
            end = loaded.end;
            if HAS_OVER {
                let share = scale_shares(light, f32(node + 1u) / f32(NODES));
                own = black4();
                adding = plus(scaled(reached, share), minus(light, share));
            } else {
                own = quotient(light, before, 1e-9);
            }
            before = light;
            is = (start > vec4(0u)) & vec4(n >= ramps);
        }
        if HAS_VOLUMES && i == count * steps {
            ramp = begin_inside();
            whole = scaled(whole, selected(white4(), ramp.light, ramp.is));
        }
        if HAS_VOLUMES && any(ramp.is) {
            count_late(ramp);
            start = select(start, fixed(ramp.start), ramp.is);
            end = select(end, fixed(ramp.end), ramp.is);
            own = selected(own, ramp.light, ramp.is);
            adding = selected(adding, black4(), ramp.is);
            is = is | ramp.is;
        }
        // Once, behind all segments.
        if i + 1u == count * steps + rest_steps() {
            let rest = overflowed(sum_index(tile_id, place));
            own = rest_light(rest, whole);
            is = is_light(own);
            start = max(fixed(select(nearest, rest.depth, rest.depth < vec4(1.0))), last_end());
            end = start;
            whole = scaled(whole, own);
            nearest = min(nearest, rest.depth);
        }
        passed = selected(passed, plus(scaled(passed, own), adding), is);
        insert(start, end, own, passed, is);
    }
    if HAS_VOLUMES {
        nearest = nearest_inside(nearest);
    }
    for (var i = 0u; i < ROWS; i += 1u) {
        let texel = at + vec2(0u, i);
        let filtered = min(vec3(whole.red[i], whole.green[i], whole.blue[i]), vec3(65504.0));
        textureStore(filters, texel, view.layer, vec4(blackened(filtered), 1.0));
        textureStore(nearests, texel, view.layer, vec4(nearest[i]));
    }
    store_curves(view, at);
}
