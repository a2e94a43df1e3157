// shade, light points: evaluates the light at points: surfaces, panes and particles of the picture, or points
// of a host. One invocation per answer; the kernel chooses the answers. CPU reference:
// crates/gobo-reference/src/shading/mod.rs. Rust: crates/gobo-picture/src/stage/shade.rs.

import choice::light_output::{answer_count, store_answer};

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn light_points(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if index >= answer_count() {
        return;
    }
    store_answer(index);
}
