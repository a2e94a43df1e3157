// Hits of one ray that wait, in private memory: a ring, because few hits come late. One slot is free, so that
// the hit that leaves need not be held while others move up. An invocation has one texel.

import package::features::HAS_VOLUMES;
import package::hit::hit_order::{NO_HIT, OrderedHit, WAITING};

const HIT_WORDS: u32 = 12u;
const RING_SLOTS: u32 = WAITING + 1u;

var<private> ring: array<f32, RING_SLOTS * HIT_WORDS>;
var<private> nearest_slot: u32;

fn clear_waiting(i: u32) {
    nearest_slot = 0u;
    for (var slot = 0u; slot < WAITING; slot += 1u) {
        set_hit(slot, NO_HIT);
    }
}

fn hit_at(slot: u32) -> OrderedHit {
    let at = slot * HIT_WORDS;
    let light = vec3(ring[at + 1u], ring[at + 2u], ring[at + 3u]);
    let added = vec3(ring[at + 4u], ring[at + 5u], ring[at + 6u]);
    let change = vec3(ring[at + 9u], ring[at + 10u], ring[at + 11u]);
    return OrderedHit(ring[at], light, added, ring[at + 7u], ring[at + 8u], change);
}

fn set_hit(slot: u32, hit: OrderedHit) {
    let at = slot * HIT_WORDS;
    ring[at] = hit.depth;
    ring[at + 1u] = hit.light.r;
    ring[at + 2u] = hit.light.g;
    ring[at + 3u] = hit.light.b;
    ring[at + 4u] = hit.added.r;
    ring[at + 5u] = hit.added.g;
    ring[at + 6u] = hit.added.b;
    ring[at + 7u] = hit.presence;
    ring[at + 8u] = hit.end;
    if HAS_VOLUMES {
        ring[at + 9u] = hit.change.r;
        ring[at + 10u] = hit.change.g;
        ring[at + 11u] = hit.change.b;
    }
}

// Adds a hit; takes the nearest of it and those that wait.
fn exchange_hits(i: u32, came: OrderedHit) -> OrderedHit {
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
fn take_hit(i: u32) -> OrderedHit {
    let left = hit_at(nearest_slot);
    nearest_slot = (nearest_slot + 1u) % RING_SLOTS;
    return left;
}
