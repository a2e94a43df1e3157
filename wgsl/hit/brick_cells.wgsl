// The cells of voxels that a ray crosses in a brick, in order, and the density at two Gauss points in each
// (Amanatides and Woo 1987). All crossings of faces are computed from the ray's start, so that neighbouring
// bricks agree on them. CPU reference: crates/gobo-reference/src/brick.rs.

import package::bind::sampled::voxels;
import package::hit::hit::to_world;
import package::records::brick::Grid;
import package::records::view::GpuView;

const CELLS: u32 = 25u; // more than the 22 cells that a ray may cross
const LAST_CELL: f32 = 7.0; // along an axis
const GAUSS: f32 = 0.28867513; // of a Gauss point from the middle, as a share of the length: 1 / sqrt(12)
const LEAST_WAY: f32 = 1e-20;  // along an axis [voxels]: no ray is parallel to a face

// A ray in the grid's index space, from its anchor.
struct IndexRay {
    start: vec3<f32>, // [voxels]
    way: vec3<f32>,   // per metre along the axis
    metres: f32,      // length of `way` [m]
}

fn index_ray(view: GpuView, grid: Grid, texel: vec2<f32>) -> IndexRay {
    let slope = (texel - view.size * 0.5) / view.scale;
    let aside = vec3(slope.x, -slope.y, 0.0);
    let forward = vec3(0.0, 0.0, -1.0);
    let anchor = (view.view_from_world * vec4(grid.anchor, 1.0)).xyz;
    let is_parallel = view.perspective == 0.0;
    let start = select(vec3(0.0), aside, is_parallel) - anchor;
    let along = select(aside + forward, forward, is_parallel);
    let way = to_world(view, along) * grid.index_from_world;
    return IndexRay(to_world(view, start) * grid.index_from_world, never_parallel(way), length(along));
}

fn never_parallel(way: vec3<f32>) -> vec3<f32> {
    return select(way, vec3(LEAST_WAY), abs(way) < vec3(LEAST_WAY));
}

// The cell at place `t` of the ray in a brick whose lowest voxel is `low`.
fn first_cell(ray: IndexRay, low: vec3<f32>, t: f32) -> vec3<f32> {
    return clamp(floor(ray.start + ray.way * t) - low, vec3(0.0), vec3(LAST_CELL));
}

// The way of a ray in one cell.
struct CellWay {
    next: f32,            // where it ends, along the axis [m]
    a: vec3<f32>,         // Gauss points, in the cell
    b: vec3<f32>,
    following: vec3<f32>, // cell behind it
}

// The ray's way from `t` up to `last`, in a `cell` of a brick whose lowest voxel is `low`.
fn way_in_cell(ray: IndexRay, low: vec3<f32>, cell: vec3<f32>, t: f32, last: f32) -> CellWay {
    let rises = ray.way > vec3(0.0);
    let lowest = low + cell;
    let faces = (lowest + select(vec3(0.0), vec3(1.0), rises) - ray.start) * (1.0 / ray.way);
    let next = max(min(min(faces.x, faces.y), min(faces.z, last)), t);
    let middle = ray.start + ray.way * (0.5 * (t + next)) - lowest;
    let apart = ray.way * (GAUSS * (next - t));
    let a = clamp(middle - apart, vec3(0.0), vec3(1.0));
    let b = clamp(middle + apart, vec3(0.0), vec3(1.0));
    let following = clamp(cell + select(vec3(-1.0), vec3(1.0), rises), vec3(0.0), vec3(LAST_CELL));
    return CellWay(next, a, b, select(cell, following, faces <= vec3(next)));
}

// Densities at place `at` of a cell, on its two faces across z. A texel has four voxels: its own, and the
// next in y, in z and in both. `low`, `high`: texels of the cell's lowest voxel, and of the next in x.
fn in_layers(low: vec4<f32>, high: vec4<f32>, at: vec3<f32>) -> vec2<f32> {
    let in_x = low + (high - low) * at.x;
    return in_x.xz + (in_x.yw - in_x.xz) * at.y;
}

// Sum of the density at two points in a cell, whose lowest voxel is at `texel`.
fn two_densities(texel: vec3<u32>, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let low = textureLoad(voxels, texel, 0);
    let high = textureLoad(voxels, texel + vec3(1u, 0u, 0u), 0);
    let of_a = in_layers(low, high, a);
    let of_b = in_layers(low, high, b);
    return of_a.x + (of_a.y - of_a.x) * a.z + of_b.x + (of_b.y - of_b.x) * b.z;
}

// Densities at these two points.
fn each_density(texel: vec3<u32>, a: vec3<f32>, b: vec3<f32>) -> vec2<f32> {
    let low = textureLoad(voxels, texel, 0);
    let high = textureLoad(voxels, texel + vec3(1u, 0u, 0u), 0);
    let of_a = in_layers(low, high, a);
    let of_b = in_layers(low, high, b);
    return vec2(of_a.x + (of_a.y - of_a.x) * a.z, of_b.x + (of_b.y - of_b.x) * b.z);
}
