// Part `plain` of kernels whose casters are all soft discs of the `filter` transfer.

import package::hit::disc::{Disc, DiscHit, broadcast_disc, disc_hit, disc_touches, prepare_disc};
import package::records::footprint::Footprint;
import package::records::view::GpuView;

alias Plain = Disc;
alias PlainHit = DiscHit;

// A visit is so short that the search for the nearest depth is worth a loop of its own.
const SEEKS_APART: bool = true;

fn prepare(view: GpuView, footprint: Footprint) -> Plain {
    return prepare_disc(view, footprint);
}

// The disc, or one that does nothing.
fn only_if(is_there: bool, plain: Plain) -> Plain {
    var disc = plain;
    disc.slope *= select(0.0, 1.0, is_there);
    disc.absorbed *= select(0.0, 1.0, is_there);
    return disc;
}

// `delta`: from the disc's centre [texels].
fn plain_hit(view: GpuView, plain: Plain, delta: vec2<f32>, opaque: f32) -> PlainHit {
    return disc_hit(view, plain, delta, opaque);
}

fn presence(plain: Plain, hit: PlainHit) -> f32 {
    return hit.profile * plain.slope;
}

// The disc of lane `lane` of the subgroup.
fn broadcast(plain: Plain, lane: u32) -> Plain {
    return broadcast_disc(plain, lane);
}

// Whether the disc may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return disc_touches(view, footprint.bounds, lo, hi);
}
