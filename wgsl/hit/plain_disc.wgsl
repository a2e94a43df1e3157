// Part `plain` of kernels whose casters are all of one simple kind: soft discs of the `filter` transfer.

import package::features::PERSPECTIVE;
import package::hit::disc::{
    Disc, Profile4, broadcast_disc, column_rest, disc_profile, disc_touches, prepare_disc, rest_profile,
};
import package::records::footprint::Footprint;
import package::records::view::GpuView;
import choice::column::FOURS;

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

// Profiles of the fours of texels in a column. `first`: centre of the first of eight, which are rounded alike however
// many an invocation has; `below`: [texels] from there to the first four.
fn column_profile(
    view: GpuView,
    disc: Plain,
    first: vec2<f32>,
    below: f32,
    opaque: array<vec4<f32>, FOURS>,
) -> array<Profile4, FOURS> {
    let dx = first.x - disc.center.x;
    let dy = first.y - disc.center.y;
    var met: array<Profile4, FOURS>;
    if FOURS == 1u {
        met[0] = four_profile(view, disc, dx, first.y + below, dy + below, opaque[0]);
    } else {
        met[0] = four_profile(view, disc, dx, first.y, dy, opaque[0]);
        met[FOURS - 1u] = four_profile(view, disc, dx, first.y + 4.0, dy + 4.0, opaque[FOURS - 1u]);
    }
    return met;
}

// `y`: of the first texel's centre; `dy`: from the disc's, rounded.
fn four_profile(view: GpuView, disc: Plain, dx: f32, y: f32, dy: f32, opaque: vec4<f32>) -> Profile4 {
    if PERSPECTIVE {
        return disc_profile(view, disc, dx, y + vec4(0.0, 1.0, 2.0, 3.0) - disc.center.y, opaque);
    }
    return rest_profile(disc, column_rest(disc, dx, dy), opaque);
}
