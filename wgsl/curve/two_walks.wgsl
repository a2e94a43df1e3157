// Walks a tile's pairs front to back, twice.

import package::curve::ray::begin_second;
import package::curve::ray_nodes::{end_walk, visit_scattered};
import package::records::view::GpuView;
import choice::pass::visit_pairs;
import choice::written::WALKS_APART;

fn walk_once(view: GpuView, first: u32, end: u32) {
    visit_pairs(view, first, end);
    visit_scattered(view);
}

fn walk(view: GpuView, first: u32, end: u32) {
    if WALKS_APART {
        walk_once(view, first, end);
        begin_second();
        walk_once(view, first, end);
    } else {
        for (var turn = 0u; turn < 2u; turn += 1u) {
            if turn == 1u {
                begin_second();
            }
            walk_once(view, first, end);
        }
    }
    end_walk(view);
}
