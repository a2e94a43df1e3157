// Sorting of rays' hits by depth: casters come sorted by their nearest points, so their hits are nearly
// sorted. The last few wait in a sorted buffer; a late one is inserted among them. CPU reference:
// src/reference/order.rs.

import package::curve::lights::{Lights, black, selected, white, with_light};
import package::features::unrolled;
import package::hit::caster_hit::Hit;
import package::hit::crossing::added_light;
import choice::rows::{RowIs, Rows, count_rows, with_row};

const WAITING: u32 = 8u; // capacity of the buffer [hits]

// Hits of an invocation's texels.
struct Hits {
    depth: Rows, // light depth; negative for none
    light: Lights,
    added: Lights,
    opacity: Rows,
    end: Rows,
}

var<private> waiting: array<Hits, WAITING>; // the nearest first
var<private> last_left: Rows; // light depth of the last hit that left
var<private> late_hits: u32;  // hits that came after one behind them had left

fn no_hits() -> Hits {
    return Hits(Rows(-1.0), white(), black(), Rows(0.0), Rows(-1.0));
}

fn with_hit(v: Hits, i: u32, hit: Hit) -> Hits {
    return Hits(
        with_row(v.depth, i, hit.depth),
        with_light(v.light, i, hit.light),
        with_light(v.added, i, added_light(hit)),
        with_row(v.opacity, i, hit.opacity),
        with_row(v.end, i, hit.end),
    );
}

fn clear_order() {
    for (var i = 0u; i < unrolled(WAITING); i += 1u) {
        waiting[i] = no_hits();
    }
    last_left = Rows(-1.0);
    late_hits = 0u;
}

fn selected_hits(a: Hits, b: Hits, is: RowIs) -> Hits {
    return Hits(
        select(a.depth, b.depth, is),
        selected(a.light, b.light, is),
        selected(a.added, b.added, is),
        select(a.opacity, b.opacity, is),
        select(a.end, b.end, is),
    );
}

// Adds hits; returns those that leave in exchange.
fn pass_on(came: Hits) -> Hits {
    var left = came;
    for (var n = 1u; n < unrolled(WAITING + 1u); n += 1u) {
        let own = waiting[WAITING - n];
        let stays = left.depth < own.depth;
        waiting[WAITING - n] = selected_hits(left, own, stays);
        left = selected_hits(own, left, stays);
    }
    late_hits += count_rows((left.depth >= Rows(0.0)) & (left.depth < last_left));
    last_left = max(last_left, left.depth);
    return left;
}

// The nearest hits leave, none are added.
fn next_waiting() -> Hits {
    let left = waiting[0];
    for (var i = 1u; i < unrolled(WAITING); i += 1u) {
        waiting[i - 1u] = waiting[i];
    }
    waiting[WAITING - 1u] = no_hits();
    return left;
}
