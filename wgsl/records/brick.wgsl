// A brick of a grid, and the grid's values that all its bricks share, from `bricks`. Rust: `BrickRecord` and
// `GridRecord` in src/records/brick.rs.

import package::bind::sampled::bricks;
import package::records::record::record_texel;

const BRICK_TEXELS: u32 = 2u;
const BRICK_SIZE: f32 = 8.0; // edge of a brick with voxels of its own [voxels]

const SLOT_WIDTH: u32 = 9u;  // of a brick in `voxels` [texels]
const SLOT_HEIGHT: u32 = 8u; // and depth

// The light of a brick is evaluated at a lattice of points over its box, including the faces, which
// neighbours share. Points along an edge, in a thin grid; a dense grid has more.
const LATTICE_EDGE: u32 = 5u;

struct Brick {
    low: vec3<f32>,   // lowest corner, from the grid's anchor [voxels]
    high: vec3<f32>,  // highest corner
    density: f32,     // if constant; negative for voxels of its own, -2 with temperatures in the next slot
    first_texel: vec3<u32>, // first texel of these voxels in `voxels`
    grid: u32,        // first texel of the grid's record
}

struct Grid {
    index_from_world: mat3x3<f32>, // transposed: the right factor of a vector [voxels/m]
    anchor: vec3<f32>,             // world space [m]
    extinction: vec3<f32>,         // at density 1 [1/m]
}

fn brick_of(id: u32) -> Brick {
    let words = textureLoad(bricks, record_texel(BRICK_TEXELS * id), 0);
    let shape = textureLoad(bricks, record_texel(BRICK_TEXELS * id + 1u), 0);
    let low = vec3<f32>(bitcast<vec3<i32>>(words.xyz));
    let density = bitcast<f32>(shape.w);
    let size = select(vec3<f32>(shape.xyz), vec3(BRICK_SIZE), density < 0.0);
    return Brick(low, low + size, density, shape.xyz, words.w);
}

fn grid_texel(grid: u32, texel: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(textureLoad(bricks, record_texel(grid + texel), 0));
}

fn grid_extinction(grid: u32) -> vec3<f32> {
    return vec3(grid_texel(grid, 3u).w, grid_texel(grid, 4u).w, grid_texel(grid, 5u).w);
}

fn grid_of(brick: Brick) -> Grid {
    let x = grid_texel(brick.grid, 0u);
    let y = grid_texel(brick.grid, 1u);
    let z = grid_texel(brick.grid, 2u);
    return Grid(mat3x3(x.xyz, y.xyz, z.xyz), vec3(x.w, y.w, z.w), grid_extinction(brick.grid));
}

// Lattices of the bricks of a grid, among those of all bricks.
struct Lattices {
    edge: u32,        // points along an edge
    first_brick: u32, // record of its first brick
    first_point: u32, // first point of that brick
}

fn grid_lattices(grid: u32) -> Lattices {
    let words = textureLoad(bricks, record_texel(grid + 7u), 0);
    return Lattices(words.x, words.y, words.z);
}

fn lattice_points(edge: u32) -> u32 {
    return edge * edge * edge;
}

// Edges of a voxel as columns, world space [m].
fn voxel_edges(brick: Brick) -> mat3x3<f32> {
    return mat3x3(
        grid_texel(brick.grid, 3u).xyz,
        grid_texel(brick.grid, 4u).xyz,
        grid_texel(brick.grid, 5u).xyz,
    );
}
