// Sorting of four rays' hits by depth: casters come sorted by their nearest points, so their hits are
// nearly sorted. The last few wait in a sorted buffer; a late one is inserted among them.
// CPU reference: src/reference/order.rs.
//
// Indices are literals, so that the arrays become registers.

import package::curve::light4::{Light4, black4, light4, selected, white4};
import package::hit::caster_hit::Hit;
import package::hit::crossing::added_light;

const WAITING: u32 = 8u; // capacity of the buffer [hits]

struct Hit4 {
    depth: vec4<f32>, // light depth; negative for an empty slot
    light: Light4,
    added: Light4,
    opacity: vec4<f32>,
    end: vec4<f32>,
}

var<private> waiting: array<Hit4, 8>; // the nearest first
var<private> last_left: vec4<f32>;    // light depth of the last hit that left
var<private> late_hits: u32;          // hits that came after one behind them had left

fn no_hits() -> Hit4 {
    return Hit4(vec4(-1.0), white4(), black4(), vec4(0.0), vec4(-1.0));
}

fn hits_of(met: array<Hit, 4>) -> Hit4 {
    return Hit4(
        vec4(met[0].depth, met[1].depth, met[2].depth, met[3].depth),
        light4(met[0].light, met[1].light, met[2].light, met[3].light),
        light4(added_light(met[0]), added_light(met[1]), added_light(met[2]), added_light(met[3])),
        vec4(met[0].opacity, met[1].opacity, met[2].opacity, met[3].opacity),
        vec4(met[0].end, met[1].end, met[2].end, met[3].end),
    );
}

fn clear_order() {
    let none = no_hits();
    waiting = array(none, none, none, none, none, none, none, none);
    last_left = vec4(-1.0);
    late_hits = 0u;
}

fn selected_hits(a: Hit4, b: Hit4, is: vec4<bool>) -> Hit4 {
    return Hit4(
        select(a.depth, b.depth, is),
        selected(a.light, b.light, is),
        selected(a.added, b.added, is),
        select(a.opacity, b.opacity, is),
        select(a.end, b.end, is),
    );
}

// Content of slot `place` after `came` was inserted and the nearest has left.
fn move_up(place: u32, came: Hit4) {
    let here = selected_hits(came, waiting[place], came.depth < waiting[place].depth);
    waiting[place] = selected_hits(waiting[place + 1u], here, came.depth < waiting[place + 1u].depth);
}

// Adds hits; returns those that leave in exchange.
fn pass_on(came: Hit4) -> Hit4 {
    let left = selected_hits(waiting[0], came, came.depth < waiting[0].depth);
    move_up(0u, came);
    move_up(1u, came);
    move_up(2u, came);
    move_up(3u, came);
    move_up(4u, came);
    move_up(5u, came);
    move_up(6u, came);
    waiting[7] = selected_hits(came, waiting[7], came.depth < waiting[7].depth);
    let late = (left.depth >= vec4(0.0)) & (left.depth < last_left);
    late_hits += dot(vec4<u32>(late), vec4(1u));
    last_left = max(last_left, left.depth);
    return left;
}

// The nearest hits leave, none are added.
fn next_waiting() -> Hit4 {
    let left = waiting[0];
    waiting = array(
        waiting[1], waiting[2], waiting[3], waiting[4], waiting[5], waiting[6], waiting[7], no_hits(),
    );
    return left;
}
