// shade, bricks: the points of the bricks' lattices. One invocation per point. CPU reference:
// crates/gobo-reference/src/brick_light.rs, crates/gobo-reference/src/shade/mod.rs. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::uniform::{materials, point_batch, views};
import package::features::NODES;
import package::records::brick::{
    BRICK_SIZE, brick_of, grid_lattices, grid_look, grid_of, lattice_points, temperature, voxel_edges,
};
import package::records::cluster::ALL_LIGHTS;
import package::records::light::cluster_of;
import package::records::point::{POINT_BRICK, POINT_NONE, Point};
import package::records::view::GpuView;
import package::shade::black_body::black_body;
import package::shade::store_point::store_point;

override WORKGROUP_SIZE: u32;

// Whether the camera may see a sphere; `center` in view space [m].
fn is_in_picture(view: GpuView, center: vec3<f32>, radius: f32) -> bool {
    let slope = view.size * 0.5 / view.scale;
    let beyond = abs(center.xy) + center.z * slope;
    let aside = all(beyond <= radius * sqrt(1.0 + slope * slope));
    return aside && -center.z + radius >= view.near && -center.z - radius <= view.far;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_bricks(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if index >= point_batch.count {
        return;
    }
    let lattices = grid_lattices(point_batch.grid);
    let edge = lattices.edge;
    let number = point_batch.first + index - lattices.first_point;
    let brick_id = lattices.first_brick + number / lattice_points(edge);
    let brick = brick_of(brick_id);
    let in_lattice = number % lattice_points(edge);
    let cell = vec3(in_lattice % edge, in_lattice / edge % edge, in_lattice / (edge * edge));
    let part = vec3<f32>(cell) / f32(edge - 1u);
    let size = brick.high - brick.low;
    let edges = voxel_edges(brick);
    let anchor = grid_of(brick).anchor;
    // Shares of whole numbers of voxels: neighbours place their shared points alike.
    let position = anchor + edges * (brick.low + size * part);
    let middle = anchor + edges * (brick.low + size * 0.5);
    let radius = 0.5 * (length(edges[0]) * size.x + length(edges[1]) * size.y + length(edges[2]) * size.z);
    let view = views[0];
    let center = (view.view_from_world * vec4(middle, 1.0)).xyz;
    let seen = (view.view_from_world * vec4(position, 1.0)).xyz;
    let along = -seen.z;
    let pixel = vec2(seen.x, -seen.y) * (view.scale / max(along, view.near)) + view.size * 0.5;
    let look = grid_look(point_batch.grid);
    var point: Point;
    point.kind = select(POINT_NONE, POINT_BRICK, is_in_picture(view, center, radius));
    point.position = position;
    point.brick = brick_id * point_batch.own_shadow;
    // A curve holds the occluders in front of a point in its own brick; without curves, a brick does not
    // shadow itself.
    point.reach = select(radius, 0.0, NODES > 0u);
    let cluster = cluster_of(pixel, (along - view.near) / (view.far - view.near));
    point.cluster = select(ALL_LIGHTS, cluster, along > view.near);
    point.receives = materials[look.material].receives;
    point.albedo = materials[look.material].tint.rgb;
    let hot = temperature(brick, part * BRICK_SIZE);
    point.emission = look.emission * black_body(hot);
    point.roughness = 0.5 + 0.5 * look.anisotropy;
    store_point(index, point);
}
