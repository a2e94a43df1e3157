// Hits of rays that wait, in registers, nearest first.

import package::curve::lights::selected;
import package::features::unrolled;
import package::hit::hit_order::{Hits, WAITING, no_hits};
import choice::rows::RowIs;

var<private> waiting: array<Hits, WAITING>;

fn clear_waiting() {
    for (var i = 0u; i < unrolled(WAITING); i += 1u) {
        waiting[i] = no_hits();
    }
}

fn selected_hits(a: Hits, b: Hits, is: RowIs) -> Hits {
    return Hits(
        select(a.depth, b.depth, is),
        selected(a.light, b.light, is),
        selected(a.added, b.added, is),
        select(a.presence, b.presence, is),
        select(a.end, b.end, is),
        selected(a.change, b.change, is),
    );
}

// Adds hits; takes the nearest of them and those that wait.
fn exchange_hits(came: Hits) -> Hits {
    var left = came;
    for (var n = 1u; n < unrolled(WAITING + 1u); n += 1u) {
        let right = waiting[WAITING - n];
        let stays = left.depth < right.depth;
        waiting[WAITING - n] = selected_hits(left, right, stays);
        left = selected_hits(right, left, stays);
    }
    return left;
}

// Takes the nearest hits, when no more are added.
fn take_hits() -> Hits {
    let left = waiting[0];
    for (var i = 1u; i < unrolled(WAITING); i += 1u) {
        waiting[i - 1u] = waiting[i];
    }
    waiting[WAITING - 1u] = no_hits();
    return left;
}
