// Sorting of rays' hits by depth: casters come sorted by their nearest points, so their hits are nearly
// sorted. The last few hits wait in order, and a late one is inserted among them (a k-buffer: Bavoil et al.
// 2007). CPU reference: crates/gobo-reference/src/order.rs.

import package::features::HAS_OVER;
import package::hit::crossing::added_light;
import package::hit::hit::{Hit, presence_of};
import package::records::tile::depth_of_key;
import package::records::view::GpuView;
import choice::waiting::exchange_hits;

const WAITING: u32 = 8u; // capacity of the buffer [hits]

// A hit, or a face of a volume.
struct OrderedHit {
    depth: f32, // light depth; negative for none
    light: vec3<f32>,
    added: vec3<f32>,
    presence: f32,
    end: f32,
    change: vec3<f32>, // of the optical depth per light depth, behind a face
}

const NO_HIT: OrderedHit = OrderedHit(-1.0, vec3(1.0), vec3(0.0), 0.0, -1.0, vec3(0.0));

var<private> late_hits: u32; // hits that came after one behind them had left

fn ordered_hit(hit: Hit) -> OrderedHit {
    return OrderedHit(hit.depth, hit.light, added_light(hit), presence_of(hit), hit.end, vec3(0.0));
}

// Adds a hit of texel `i`; returns the hit that leaves in exchange. `last_left`: light depth of the last one.
fn pass_on(i: u32, came: OrderedHit, last_left: f32) -> OrderedHit {
    let left = exchange_hits(i, came);
    late_hits += u32((left.depth >= 0.0) & (left.depth < last_left));
    return left;
}

// Depth keys along a ray. With order-dependent blending, keys are distances.

// Light depths of keys 0 and 1 along the ray through a texel's centre.
fn depths_of_keys(view: GpuView, center: vec2<f32>) -> vec2<f32> {
    return vec2(depth_of_key(view, center, 0.0), depth_of_key(view, center, 1.0));
}

// Least light depth of the hits of a caster with key `front`, as a share of the largest key. `keys`: light
// depths of keys 0 and 1.
fn least_depth(keys: vec2<f32>, front: f32) -> f32 {
    return select(front, keys.x + front * (keys.y - keys.x), HAS_OVER);
}
