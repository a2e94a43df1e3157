// shade, light points: the light that each point sends to the eye. The only kernel of the picture
// that asks the shadow maps; surfaces, panes, particles and air write its points. One invocation
// per point.
// CPU twin: src/cpu/shading/mod.rs. Host: src/stage/shade.rs.

import package::bind::stored::lit;
import package::bind::uniform::point_batch;
import package::records::point::load_point;
import package::records::record::record_texel;
import package::shade::point_light::point_light;

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
    let light = point_light(load_point(index));
    textureStore(lit, record_texel(point_batch.first + index), vec4(light, 1.0));
}
