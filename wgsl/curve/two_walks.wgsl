// Walks a tile's pairs front to back, twice.

import package::curve::ray::begin_second;
import package::curve::ray_nodes::{end_walk, visit_scattered};
import package::records::view::GpuView;
import choice::pass::visit_pairs;

fn walk(view: GpuView, first: u32, end: u32) {
    visit_pairs(view, first, end);
    visit_scattered(view);
    begin_second();
    visit_pairs(view, first, end);
    visit_scattered(view);
    end_walk(view);
}
