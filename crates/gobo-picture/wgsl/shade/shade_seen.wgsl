// shade, seen: nearest opaque caster of each pixel of a band; one workgroup per tile, one invocation per
// pixel. A long tile takes several rounds, each of which continues the one before: some drivers bound the
// iterations of an invocation. CPU reference: crates/gobo-reference/src/shade/mod.rs. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::accumulator::seen::{nearest, seen, seen_setup, start};
import package::bind::picture_in::band;
import package::bind::picture_out::{carried, seen_pixels};
import package::records::record::record_texel;
import package::shade::band::{ROUND_LENGTH, band_pixel};
import package::shade::camera::{camera, walked};
import package::shade::points::empty_lists;
import package::traversal::lane::LANES;
import choice::records::tile_at;
import choice::traversal::walk;

@compute @workgroup_size(LANES)
fn shade_seen(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = camera();
    let at = band_pixel(workgroup, workgroups, lane, view.tiles_x);
    if at.index == 0u {
        empty_lists();
    }
    let tile = tile_at(at.tile);
    let first = tile.first + band.round * ROUND_LENGTH;
    let goes_on = first > tile.first;
    if goes_on && first >= tile.end {
        return;
    }
    start(at.pixel);
    if goes_on {
        let before = carried[at.index];
        nearest = bitcast<f32>(before.x);
        seen = before.y;
        seen_setup = before.z;
        walked = before.w;
    }
    let end = min(first + ROUND_LENGTH, tile.end);
    walk(view, first, end);
    let found = vec4(bitcast<u32>(nearest), seen, seen_setup, walked);
    textureStore(seen_pixels, record_texel(at.index), found);
    if end < tile.end {
        carried[at.index] = found;
    }
}
