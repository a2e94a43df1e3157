// shade, light points: the light of points, which surfaces, panes and particles of the picture are, and
// points of the host. One invocation per answer; what is answered is the kernel's choice.
// CPU twin: src/reference/shading/mod.rs. Host: src/stage/shade.rs.

import choice::answer::store_answer;
import package::bind::uniform::point_batch;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn light_points(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if index >= point_batch.count {
        return;
    }
    store_answer(index);
}
