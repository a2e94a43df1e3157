// accumulate, overflow: footprints whose pairs did not fit, straight into the sums. One workgroup
// per footprint and slice of its tiles: the 65,536 tiles of a large map are more than llvmpipe lets
// one invocation walk. CPU twin: src/reference/accumulate.rs. Host: src/stage/accumulate.rs.

import package::driver::overflow::{OVERFLOW_LANES, walk_overflow};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::scatter::scatter;

fn add(view: GpuView, place: vec4<u32>, look: vec4<u32>, tile_place: vec2<u32>, in_tile: vec2<u32>) {
    scatter(view, place, look, tile_place * TILE_SIZE + in_tile);
}

@compute @workgroup_size(OVERFLOW_LANES)
fn accumulate_overflow(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    walk_overflow(workgroup, workgroups, lane);
}
