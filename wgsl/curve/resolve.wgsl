// Output: curves, filter and nearest depth of tiles with several segments, whose curves are appended to each
// other. CPU reference: crates/gobo-reference/src/curve/tile.rs.

import package::bind::read::partials;
import package::bind::stored::{filters, nearests};
import package::curve::blank::stays_blank;
import package::curve::gather::{ROWS, Texel, nearest_of, new_texel, texels};
import package::curve::list::{Insertion, clear_lists, fixed, insert, last_end, merge_lists, must_merge};
import package::curve::node::{DEPTHS, curve_segment, node_length, node_of_pair, node_passed, node_start};
import package::curve::overflow::{overflowed, rest_light};
import package::curve::stored::{first_node, partial_size};
import package::curve::tile::store_curves;
import package::curve::volumes::{Ramp, Unentered, begin_inside, count_late, follow_inside, rest_steps};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES, unrolled};
import package::records::tile::Tile;
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::blackened;
import package::traversal::lane::sum_index;

// The segment that is appended to the curve of a texel.
struct Appended {
    light: vec3<f32>,   // its transfer of white light
    scale: vec3<f32>,   // its scale
    reached: vec3<f32>, // light at its start
    before: vec3<f32>,  // white light behind its last node
    whole: vec3<f32>,   // filter of all segments so far
}

var<private> appended: array<Appended, ROWS>;

fn partial_at(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(partials[at]);
}

// Light behind a segment of scale `scale` that turns white into `joined`.
fn behind(light: vec3<f32>, joined: vec3<f32>, scale: vec3<f32>) -> vec3<f32> {
    if HAS_OVER {
        return light * scale + (joined - scale);
    }
    return light * joined;
}

// Begins the segment whose record is at `at`; returns the ramp of the volumes that continue through it.
fn begin_segment(t: ptr<function, Texel>, s: ptr<function, Appended>, at: u32) -> Ramp {
    let all = partial_at(at);
    (*t).nearest = min((*t).nearest, all.a);
    (*s).light = all.rgb;
    (*s).scale = all.rgb;
    var ramp = Ramp();
    if HAS_OVER || HAS_VOLUMES {
        let surface_scale = partial_at(at + 2u);
        let inside = partial_at(at + 6u);
        let tau = partial_at(at + 7u);
        (*s).scale = partial_at(at + 1u).rgb;
        (*t).surface_light = behind((*t).surface_light, partial_at(at + 3u).rgb, surface_scale.rgb);
        (*t).crossed += bitcast<vec4<i32>>(partials[at + 5u]);
        if HAS_VOLUMES {
            let next = Unentered(inside.rgb, tau.rgb, inside.a, tau.a);
            ramp = follow_inside(t, partial_at(at + 4u).rgb, surface_scale.a, next);
            (*s).whole *= select(vec3(1.0), ramp.light, ramp.is);
        }
    }
    (*s).whole = behind((*s).whole, (*s).light, (*s).scale);
    return ramp;
}

// Least value of 1 minus an added colour for which the scale can be recovered from white light.
const MIN_REST: f32 = 0.0625;

// Scale of a segment up to the depth behind which white light has become `light`; near white, `part` of the
// segment's. CPU reference: crates/gobo-reference/src/curve/mod.rs, `Affine`.
fn scale_share(segment: Appended, light: vec3<f32>, part: f32) -> vec3<f32> {
    let lost = 1.0 - segment.scale;
    let rest = 1.0 - (segment.light - segment.scale) / max(lost, vec3(1e-3));
    let known = 1.0 - (1.0 - light) / max(rest, vec3(MIN_REST));
    let share = select(1.0 - lost * part, known, rest >= vec3(MIN_REST));
    return min(max(share, segment.scale), vec3(1.0));
}

// Hit of the segment's next node, number `k`.
fn next_hit(s: ptr<function, Appended>, pair: vec4<u32>, k: u32) -> Insertion {
    let node = node_of_pair(pair, k);
    let start = node_start(node);
    let end = min(round(start + node_length(node)), DEPTHS);
    var hit = Insertion((u32(start) << 16u) | u32(end), node_passed(node), vec3(0.0), vec3(1.0), start > 0.0);
    let light = (*s).before * hit.light;
    if HAS_OVER {
        let share = scale_share(*s, light, f32(k + 1u) / f32(NODES));
        hit.added = (*s).reached * share + (light - share);
        hit.light = vec3(0.0);
    }
    (*s).before = light;
    return hit;
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    let at = view.origin + tile.position * TILE_SIZE + in_tile;
    let count = (tile.end - tile.first + curve_segment() - 1u) / curve_segment();
    let blank = stays_blank(view, tile.position * TILE_SIZE, true);
    clear_lists(in_tile);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i] = new_texel();
        appended[i] = Appended(vec3(1.0), vec3(1.0), vec3(1.0), vec3(1.0), vec3(1.0));
    }
    // Steps of a segment: the volumes that continue through it, if any, then its nodes; behind all segments,
    // the volumes that contain the light, and the scattered casters.
    let ramps = select(0u, 1u, HAS_VOLUMES);
    let steps = ramps + NODES;
    let last = count * steps + rest_steps() - 1u;
    for (var step = 0u; step <= last; step += 1u) {
        let n = step % steps;
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            let below = in_tile + vec2(0u, i);
            var texel = texels[i];
            var segment = appended[i];
            var hit = Insertion(0u, vec3(1.0), vec3(0.0), vec3(1.0), false);
            var ramp = Ramp();
            if step < count * steps {
                let first = sum_index(tile.merged - 1u + step / steps, below) * partial_size();
                if n == 0u {
                    ramp = begin_segment(&texel, &segment, first);
                }
                if n == ramps {
                    segment.reached = texel.passed;
                    segment.before = vec3(1.0);
                }
                let k = max(n, ramps) - ramps;
                hit = next_hit(&segment, partials[first + first_node() + k / 2u], k);
                hit.is = hit.is & (n >= ramps);
            }
            if HAS_VOLUMES && step >= count * steps && step < last {
                ramp = begin_inside(texel.unentered, step - count * steps);
                segment.whole *= select(vec3(1.0), ramp.light, ramp.is);
            }
            if HAS_VOLUMES && ramp.is {
                count_late(ramp);
                let span = (fixed(ramp.start) << 16u) | fixed(ramp.end);
                hit = Insertion(span, ramp.light, vec3(0.0), vec3(1.0), true);
            }
            if step == last {
                let rest = overflowed(sum_index(tile_id, below), true);
                let light = rest_light(texel, rest, segment.whole);
                let depth = select(texel.nearest, rest.depth, rest.depth < 1.0);
                let behind_all = max(fixed(depth), last_end(i));
                let is = any(light != vec3(1.0));
                hit = Insertion((behind_all << 16u) | behind_all, light, vec3(0.0), vec3(1.0), is);
                segment.whole *= light;
                texel.nearest = min(texel.nearest, rest.depth);
            }
            texel.passed = select(texel.passed, texel.passed * hit.light + hit.added, hit.is);
            hit.passed = texel.passed;
            insert(&texel, i, hit);
            texels[i] = texel;
            appended[i] = segment;
        }
        if must_merge() {
            merge_lists();
        }
    }
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let texel_at = at + vec2(0u, i);
        let filtered = min(appended[i].whole, vec3(65504.0));
        textureStore(filters, texel_at, view.layer, vec4(blackened(filtered), 1.0));
        textureStore(nearests, texel_at, view.layer, vec4(nearest_of(texels[i])));
    }
    store_curves(view, at);
}
