// Steps behind a tile's pairs, an insertion each: hits that still wait in order, volumes that contain the
// light, and casters whose pairs did not fit.

import package::records::view::GpuView;
import choice::output::{is_scattered, open_rest, tile_steps};
import choice::visit::{join_waiting, waiting_steps};

var<private> has_casters: bool; // with pairs or without
var<private> steps_behind: u32; // none where no caster is

// `first`, `end`: range of the pairs.
fn find_steps(first: u32, end: u32) {
    has_casters = (first < end) | is_scattered();
    steps_behind = select(0u, waiting_steps() + tile_steps(), has_casters);
}

// Opens the hits of one step, for the next insertion.
fn open_behind(view: GpuView, step: u32) {
    if step < waiting_steps() {
        join_waiting();
    } else {
        open_rest(view, step - waiting_steps());
    }
}
