// The second walk gives each hit of a texel a place on the ray, half by the light that was lost and half by the depth
// that is gone, and ends a node behind its share of the places. CPU reference, with the rule:
// src/reference/curve/two_walks.rs.

import package::curve::node::{DEPTHS, node_passed, packed_node};
import package::curve::ray::{corner, count_hit, is_second, last_before, light_of, pass_hit, ray};
import package::features::NODES;
import package::hit::disc::{Disc, disc_hit};
import package::records::view::GpuView;
import package::sums::sums::BLACK;
import choice::output::{scattered, scattered_light, store_nodes};

fn write_node(view: GpuView, start: f32, end: f32, passed: vec3<f32>) {
    let fixed = u32(clamp(round(start * DEPTHS), 1.0, DEPTHS));
    let wanted = min(passed * ray.owed, vec3(1.0));
    let node = packed_node(fixed, max(end - start, 0.0) * DEPTHS, wanted);
    let stored = node_passed(node);
    ray.owed = select(vec3(1.0), wanted / max(stored, vec3(1e-9)), stored > vec3(0.0));
    if ray.used % 2u == 1u {
        store_nodes(view, corner, 0u, ray.used / 2u, vec4(ray.before, node));
    }
    ray.before = node;
    ray.used += 1u;
}

// Ramp of the open node, of the mean depth and the variance of the light that it takes. `light`: behind it.
fn write_open(view: GpuView, light: vec3<f32>) {
    let texel = ray;
    let share = 1.0 / max(texel.taken, 1e-30);
    let off = texel.sum * share;
    let spread = max(texel.square * share - off * off, 0.0);
    let mean = clamp(texel.anchor + off, texel.low, texel.high);
    let half = min(sqrt(3.0 * spread), min(mean - texel.low, texel.high - mean));
    let passed = select(light / max(texel.open_light, vec3(1e-9)), vec3(0.0), light < vec3(BLACK));
    let some = texel.taken > 0.0;
    write_node(view, select(texel.low, mean - half, some), select(texel.high, mean + half, some), passed);
    ray.open = false;
}

fn share_of_rest() -> f32 {
    return (1.0 - ray.place) / f32(NODES - ray.used);
}

fn place_hit(view: GpuView, absorbed: vec3<f32>, depth: f32, presence: f32) {
    let light = light_of();
    if !pass_hit(absorbed, depth, presence) {
        return;
    }
    let behind = light_of();
    let taken = dot(light - behind, vec3(1.0));
    let texel = ray;
    let z = max(depth, texel.at);
    let still = texel.count - texel.seen; // hits from this one on
    let free = NODES - texel.used - u32(texel.open);
    let by_light = 0.5 / max(texel.all, 1e-9);
    let by_depth = 0.5 / max(texel.last - texel.first, 1e-9);
    let few = texel.count <= NODES;
    let much = taken * f32(NODES - texel.used) > texel.all - texel.gone;
    let fits = free > 1u || (free > 0u && (texel.open || still == 1u));
    if few || (texel.count > 2u * NODES && much && fits) {
        // Behind a dark hit only what comes late is to be seen.
        let dark = (behind < vec3(BLACK)) & vec3(depth >= texel.at);
        write_node(view, depth, depth, select(1.0 - absorbed, vec3(0.0), dark));
        if texel.open {
            ray.open_light *= 1.0 - absorbed;
            ray.place += by_light * taken;
            ray.cut = ray.place + share_of_rest();
        }
    } else {
        let place = by_light * (texel.gone + 0.5 * taken) + by_depth * (2.0 * z - texel.at - texel.first);
        if texel.open && free > 0u && z > texel.at && (place > texel.cut || still <= free) {
            write_open(view, light);
        }
        if !ray.open {
            ray.open = true;
            ray.open_light = light;
            ray.low = depth;
            ray.high = depth;
            ray.anchor = depth;
            ray.taken = 0.0;
            ray.sum = 0.0;
            ray.square = 0.0;
            ray.place = by_light * texel.gone + by_depth * (z - texel.first);
            ray.cut = ray.place + share_of_rest();
        }
        let off = depth - ray.anchor;
        ray.low = min(ray.low, depth);
        ray.high = max(ray.high, depth);
        ray.taken += taken;
        ray.sum += taken * off;
        ray.square += taken * off * off;
    }
    ray.seen += 1u;
    ray.gone += taken;
    ray.at = z;
}

fn visit_hit(view: GpuView, absorbed: vec3<f32>, depth: f32, presence: f32) {
    if is_second {
        place_hit(view, absorbed, depth, presence);
    } else {
        count_hit(absorbed, depth, presence);
    }
}

// Visits a disc in this walk.
fn visit_disc(view: GpuView, disc: Disc) {
    let delta = corner + 0.5 - disc.center;
    let hit = disc_hit(view, disc, delta, ray.opaque);
    if hit.profile > 0.0 {
        visit_hit(view, hit.profile * disc.absorbed, hit.depth, hit.profile * disc.slope);
    }
}

// Visits casters without pairs, as one step behind all others.
fn visit_scattered(view: GpuView) {
    for (var turn = 0u; turn < u32(scattered()); turn += 1u) {
        let rest = scattered_light(corner, 0u);
        let depth = max(select(ray.nearest, rest.depth, rest.depth < 1.0), last_before());
        visit_hit(view, 1.0 - rest.light, depth, select(0.0, 1.0, any(rest.light < vec3(1.0))));
        ray.nearest = min(ray.nearest, rest.depth);
    }
}

// Ends the second walk.
fn end_walk(view: GpuView) {
    if ray.open {
        write_open(view, light_of());
    }
    for (; ray.used < NODES; ray.used += 1u) {
        let unused = packed_node(0u, 0.0, vec3(1.0));
        if ray.used % 2u == 1u {
            store_nodes(view, corner, 0u, ray.used / 2u, vec4(ray.before, unused));
        }
        ray.before = unused;
    }
}
