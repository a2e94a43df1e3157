// occlude, overflow: footprints whose pairs did not fit, straight into the nearest opaque depths.
// One workgroup per footprint and slice of its tiles. CPU twin: src/reference/occlude.rs. Host:
// src/stage/occlude.rs.

import package::bind::changed::scattered_tiles;
import package::driver::overflow::{OVERFLOW_LANES, walk_overflow};
import package::hit::blocks::{blocks, stored_depth};
import package::hit::caster_hit::caster_hit;
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::depth_to_nearness;
import package::walk::lane::sum_index;
import choice::sums::raise_nearness;

fn add(view: GpuView, place: vec4<u32>, look: vec4<u32>, tile_place: vec2<u32>, in_tile: vec2<u32>) {
    let middle = vec2<f32>(tile_place * TILE_SIZE + in_tile) + 0.5;
    let hit = caster_hit(view, place, look, middle, 1.0);
    if blocks(view, place, look, middle, hit) {
        let tile = view.first_tile + tile_place.y * view.tiles_x + tile_place.x;
        raise_nearness(sum_index(tile, in_tile), depth_to_nearness(stored_depth(hit)));
        scattered_tiles[tile] = 1u;
    }
}

@compute @workgroup_size(OVERFLOW_LANES)
fn occlude_overflow(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    walk_overflow(workgroup, workgroups, lane);
}
