// Hits of one ray that wait, in private memory: a ring, because few hits come late. One slot is free, so that
// the hit that leaves need not be held while others move up.

import package::curve::lights::Lights;
import package::features::HAS_VOLUMES;
import package::hit::hit_order::{Hits, WAITING, no_hits};

const HIT_WORDS: u32 = 12u;
const RING_SLOTS: u32 = WAITING + 1u;

var<private> ring: array<f32, RING_SLOTS * HIT_WORDS>;
var<private> nearest_slot: u32;

fn clear_waiting() {
    nearest_slot = 0u;
    for (var i = 0u; i < WAITING; i += 1u) {
        set_hit(i, no_hits());
    }
}

fn hit_at(slot: u32) -> Hits {
    let at = slot * HIT_WORDS;
    let light = Lights(ring[at + 1u], ring[at + 2u], ring[at + 3u]);
    let added = Lights(ring[at + 4u], ring[at + 5u], ring[at + 6u]);
    let change = Lights(ring[at + 9u], ring[at + 10u], ring[at + 11u]);
    return Hits(ring[at], light, added, ring[at + 7u], ring[at + 8u], change);
}

fn set_hit(slot: u32, hit: Hits) {
    let at = slot * HIT_WORDS;
    ring[at] = hit.depth;
    ring[at + 1u] = hit.light.red;
    ring[at + 2u] = hit.light.green;
    ring[at + 3u] = hit.light.blue;
    ring[at + 4u] = hit.added.red;
    ring[at + 5u] = hit.added.green;
    ring[at + 6u] = hit.added.blue;
    ring[at + 7u] = hit.presence;
    ring[at + 8u] = hit.end;
    if HAS_VOLUMES {
        ring[at + 9u] = hit.change.red;
        ring[at + 10u] = hit.change.green;
        ring[at + 11u] = hit.change.blue;
    }
}

// Adds a hit; takes the nearest of it and those that wait.
fn exchange_hits(came: Hits) -> Hits {
    if came.depth < 0.0 || came.depth < ring[nearest_slot * HIT_WORDS] {
        return came;
    }
    let next = (nearest_slot + 1u) % RING_SLOTS;
    var slot = (nearest_slot + WAITING) % RING_SLOTS;
    while slot != next {
        let before = (slot + WAITING) % RING_SLOTS;
        if ring[before * HIT_WORDS] <= came.depth {
            break;
        }
        set_hit(slot, hit_at(before));
        slot = before;
    }
    set_hit(slot, came);
    let left = hit_at(nearest_slot);
    nearest_slot = next;
    return left;
}

// Takes the nearest hit, at most `WAITING` times, when no more are added.
fn take_hits() -> Hits {
    let left = hit_at(nearest_slot);
    nearest_slot = (nearest_slot + 1u) % RING_SLOTS;
    return left;
}
