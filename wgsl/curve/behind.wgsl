// What follows a tile's pairs, one insertion after another: hits that still wait in order, volumes that
// contain the light, casters whose pairs did not fit.

import package::records::view::GpuView;
import choice::output::{open_rest, tile_steps};
import choice::visit::{join_waiting, waiting_steps};

fn steps_behind() -> u32 {
    return waiting_steps() + tile_steps();
}

// Opens the hits of one step, for the next insertion.
fn open_behind(view: GpuView, step: u32) {
    if step < waiting_steps() {
        join_waiting();
    } else {
        open_rest(view, step - waiting_steps());
    }
}
