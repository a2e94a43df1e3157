// Shadow of a brick's own voxels on a point in the brick. A curve keeps too little of them where they are
// dense. CPU reference: crates/gobo-reference/src/brick.rs, crates/gobo-reference/src/shading/mod.rs.

import package::hit::brick::{CELLS, IndexRay, first_cell, never_parallel, two_densities, way_in_cell};
import package::records::brick::{Brick, Grid, brick_of, grid_of};
import package::records::light::{GpuLight, LIGHT_DIRECTIONAL};

// Share of the way to a lamp at which the look-up from outside the brick stops: a lamp has no direction to
// itself.
const SHORT_OF: f32 = 0.999;
const SUN_DISTANCE: f32 = 3.4e38; // distance of a directional light [m]

// A point's way towards a light in its own brick.
struct OwnWay {
    ray: IndexRay,
    end: f32, // [m]
}

fn own_way(brick: Brick, grid: Grid, light: GpuLight, position: vec3<f32>, toward: vec3<f32>) -> OwnWay {
    let way = never_parallel(toward * grid.index_from_world);
    let ray = IndexRay((position - grid.anchor) * grid.index_from_world, way, 1.0);
    let leaves = max((brick.low - ray.start) * (1.0 / way), (brick.high - ray.start) * (1.0 / way));
    let away = SHORT_OF * length(light.position - position);
    let most = select(away, SUN_DISTANCE, light.kind == LIGHT_DIRECTIONAL);
    return OwnWay(ray, max(min(min(leaves.x, leaves.y), min(leaves.z, most)), 0.0));
}

// Point where the way towards a light leaves the point's own brick, world space [m]. `id`: of the brick.
fn outside(id: u32, light: GpuLight, position: vec3<f32>, toward: vec3<f32>) -> vec3<f32> {
    let brick = brick_of(id);
    return position + toward * own_way(brick, grid_of(brick), light, position, toward).end;
}

// Transmittance of the own brick from there to the point; 1 where `id` is 0.
fn own_passed(id: u32, light: GpuLight, position: vec3<f32>, toward: vec3<f32>) -> vec3<f32> {
    let brick = brick_of(id);
    let grid = grid_of(brick);
    let own = own_way(brick, grid, light, position, toward);
    let is_even = brick.density >= 0.0;
    var depth = select(0.0, brick.density * own.end, is_even);
    let end = select(own.end, 0.0, is_even | (id == 0u));
    var cell = first_cell(own.ray, brick.low, 0.0);
    var t = 0.0;
    for (var i = 0u; i < CELLS && t < end; i += 1u) {
        let stretch = way_in_cell(own.ray, brick.low, cell, t, end);
        let densities = two_densities(brick.first_texel + vec3<u32>(cell), stretch.a, stretch.b);
        depth += densities * (0.5 * (stretch.next - t));
        cell = stretch.following;
        t = stretch.next;
    }
    return select(exp(-depth * grid.extinction), vec3(1.0), id == 0u);
}
