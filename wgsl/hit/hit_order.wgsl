// Sorting of rays' hits by depth: casters come sorted by their nearest points, so their hits are nearly
// sorted. The last few hits wait in order, and a late one is inserted among them (a k-buffer: Bavoil et al.
// 2007). CPU reference: crates/gobo-reference/src/order.rs.

import package::curve::lights::{Lights, black, white, with_light};
import package::features::{HAS_OVER, unrolled};
import package::hit::crossing::added_light;
import package::hit::hit::{Hit, presence_of};
import package::records::tile::depth_of_key;
import package::records::view::GpuView;
import choice::rows::{ROW_COUNT, Rows, count_rows, with_row};
import choice::waiting::{clear_waiting, exchange_hits};

const WAITING: u32 = 8u; // capacity of the buffer [hits]

// Hits of an invocation's texels, and faces of volumes.
struct Hits {
    depth: Rows, // light depth; negative for none
    light: Lights,
    added: Lights,
    presence: Rows,
    end: Rows,
    change: Lights, // of the optical depth per light depth, behind a face
}

var<private> delayed: Hits;   // have left, but come behind a volume's ramp that is inserted first
var<private> last_left: Rows; // light depth of the last hit that left
var<private> late_hits: u32;  // hits that came after one behind them had left

fn no_hits() -> Hits {
    return Hits(Rows(-1.0), white(), black(), Rows(0.0), Rows(-1.0), black());
}

fn with_hit(v: Hits, i: u32, hit: Hit) -> Hits {
    return Hits(
        with_row(v.depth, i, hit.depth),
        with_light(v.light, i, hit.light),
        with_light(v.added, i, added_light(hit)),
        with_row(v.presence, i, presence_of(hit)),
        with_row(v.end, i, hit.end),
        v.change,
    );
}

fn clear_order() {
    clear_waiting();
    delayed = no_hits();
    last_left = Rows(-1.0);
    late_hits = 0u;
}

// Adds hits; returns the hits that leave in exchange.
fn pass_on(came: Hits) -> Hits {
    let left = exchange_hits(came);
    late_hits += count_rows((left.depth >= Rows(0.0)) & (left.depth < last_left));
    last_left = max(last_left, left.depth);
    return left;
}

// Light depths of depth keys along the rays of an invocation's texels. With order-dependent blending, keys
// are distances.

var<private> key_start: Rows; // light depths of keys 0 and 1
var<private> key_end: Rows;

fn start_keys(view: GpuView, texel: vec2<f32>) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let middle = texel + vec2(0.5, f32(i) + 0.5);
        key_start = with_row(key_start, i, depth_of_key(view, middle, 0.0));
        key_end = with_row(key_end, i, depth_of_key(view, middle, 1.0));
    }
}

// Least light depths of the hits of a caster with key `front`, as a share of the largest key.
fn front_depths(front: f32) -> Rows {
    return select(Rows(front), key_start + front * (key_end - key_start), HAS_OVER);
}
