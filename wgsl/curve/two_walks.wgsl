// Walks a tile's pairs front to back, twice.

import package::curve::ray::begin_walk;
import package::curve::ray_nodes::{end_walk, visit_scattered};
import package::features::unrolled;
import package::records::view::GpuView;
import choice::pass::visit_pairs;

fn walk(view: GpuView, first: u32, end: u32) {
    for (var turn = 0u; turn < unrolled(2u); turn += 1u) {
        begin_walk(turn == 1u);
        visit_pairs(view, first, end);
        visit_scattered(view);
    }
    end_walk(view);
}
