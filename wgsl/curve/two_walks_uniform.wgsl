// Walks a tile's discs front to back, twice; every invocation visits every pair. The core tier, without subgroups.

import package::curve::ray::{begin_walk, settled};
import package::curve::ray_nodes::{end_walk, visit_disc, visit_scattered};
import package::hit::disc::prepare_disc;
import package::records::footprint::front_depth;
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import choice::pairs::pair_footprint;

fn visit_pairs(view: GpuView, first: u32, end: u32) {
    var pair = first;
    var open = first < end;
    while open {
        let footprint = load_footprint(pair_footprint(pair));
        visit_disc(view, prepare_disc(view, footprint));
        pair += 1u;
        open = pair < end && !settled(front_depth(footprint));
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    for (var turn = 0u; turn < 2u; turn += 1u) {
        begin_walk(turn == 1u);
        visit_pairs(view, first, end);
        visit_scattered(view);
    }
    end_walk(view);
}
