// Part `plain` of kernels whose casters are all of one simple kind: soft discs of the `filter` transfer.

import package::features::PERSPECTIVE;
import package::hit::disc::{
    Disc, Profile4, broadcast_disc, column_rest, disc_profile, disc_touches, prepare_disc, rest_profile,
};
import package::records::footprint::Footprint;
import package::records::view::GpuView;

alias Plain = Disc;

// A visit is so short that the search for the nearest depth repays a loop of its own.
const SEEKS_APART: bool = true;

fn prepare(view: GpuView, footprint: Footprint) -> Plain {
    return prepare_disc(view, footprint);
}

// The same, or one that nothing is to be seen of.
fn only_if(is_there: bool, plain: Plain) -> Plain {
    var disc = plain;
    disc.slope *= select(0.0, 1.0, is_there);
    disc.absorbed *= select(0.0, 1.0, is_there);
    return disc;
}

fn presence(plain: Plain, profile: vec4<f32>) -> vec4<f32> {
    return profile * plain.slope;
}

// That of lane `lane` of the subgroup.
fn broadcast(plain: Plain, lane: u32) -> Plain {
    return broadcast_disc(plain, lane);
}

// Whether it may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return disc_touches(view, footprint.bounds, lo, hi);
}

// Profiles of eight texels in a column; `first`: centre of the first.
fn column_profile(view: GpuView, disc: Plain, first: vec2<f32>, opaque: array<vec4<f32>, 2>) -> array<Profile4, 2> {
    let dx = first.x - disc.center.x;
    if PERSPECTIVE {
        let ys = first.y + vec4(0.0, 1.0, 2.0, 3.0);
        return array(
            disc_profile(view, disc, dx, ys - disc.center.y, opaque[0]),
            disc_profile(view, disc, dx, ys + 4.0 - disc.center.y, opaque[1]),
        );
    }
    let dy = first.y - disc.center.y;
    return array(
        rest_profile(disc, column_rest(disc, dx, dy), opaque[0]),
        rest_profile(disc, column_rest(disc, dx, dy + 4.0), opaque[1]),
    );
}
