// The cells of voxels that a ray crosses in a brick, in order, and the density at two Gauss points in each
// (Amanatides and Woo 1987). All crossings of faces are computed from the ray's start, so that neighbouring
// bricks agree on them. CPU reference: crates/gobo-reference/src/brick.rs.

import package::bind::sampled::voxels;
import package::features::{CELLS_AT_ONCE, NODES, unrolled};
import package::hit::brick_light::SHADES_BRICKS;
import package::hit::hit::to_world;
import package::records::brick::{Brick, Grid};
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

// Optical depth of a ray in a brick of voxels, or in one of the equal parts of its way through it. Exact:
// trilinear density is a cubic along a ray within a cell, which two Gauss points integrate exactly.

const VOXEL_PARTS: u32 = 3u; // ramps of a curve for a brick with voxels of its own

// Index of the part of the ray's way through the brick that is met, and number of parts; 0 for the whole.
var<private> ramp_index: u32;
var<private> ramp_count: u32;

// Number of a curve's ramps for a brick. A brick of constant density fills the curve if it is alone.
fn ramps_of(brick: Brick) -> u32 {
    return select(VOXEL_PARTS, NODES, brick.density >= 0.0);
}

struct Passage {
    first: f32, // where density begins, along the axis [m]
    ramp: vec2<f32>, // of the ramp in a curve, along the axis [m]
    depth: f32, // integral of density along the ray [m]; 0 for a miss
    thirds: vec2<f32>,  // optical depth of one and of two thirds of the way through the box, for its light
    ends: vec2<f32>,    // where the ray enters and leaves the box, along the axis [m]
}

const NO_PASSAGE: Passage = Passage(0.0, vec2(0.0), 0.0, vec2(0.0), vec2(0.0));

// Span of the ramp with the mean and variance of depths `first` + off, within begins..ends. `moments`: sums
// of weights, of weights times off, and of weights times off squared.
fn fitted_ramp(moments: vec3<f32>, first: f32, begins: f32, ends: f32) -> vec2<f32> {
    if !(moments.x > 0.0) {
        return vec2(begins, ends);
    }
    let off = moments.y / moments.x;
    let spread = max(moments.z / moments.x - off * off, 0.0);
    let mean = clamp(first + off, begins, ends);
    let half = min(sqrt(3.0 * spread), min(mean - begins, ends - mean));
    return vec2(mean - half, mean + half);
}

// `end`: end of the ray, along the axis [m].
fn passage(view: GpuView, brick: Brick, grid: Grid, texel: vec2<f32>, end: f32) -> Passage {
    let ray = index_ray(view, grid, texel);
    let at_low = (brick.low - ray.start) * (1.0 / ray.way);
    let at_high = (brick.high - ray.start) * (1.0 / ray.way);
    let enters = min(at_low, at_high);
    let leaves = max(at_low, at_high);
    var first = max(max(enters.x, enters.y), max(enters.z, view.near));
    var last = min(min(leaves.x, leaves.y), min(leaves.z, end));
    if !(first < last) {
        return NO_PASSAGE;
    }
    if ramp_count > 0u {
        let length = (last - first) / f32(ramp_count);
        let to = first + length * f32(ramp_index + 1u);
        first += length * f32(ramp_index);
        last = select(to, last, ramp_index + 1u == ramp_count);
    }
    var all = NO_PASSAGE;
    if brick.density >= 0.0 {
        all.ends = vec2(first, last);
        all.first = first;
        all.ramp = vec2(first, last);
        all.depth = brick.density * (last - first) * ray.metres;
        all.thirds = vec2(1.0 / 3.0, 2.0 / 3.0) * all.depth;
        return all;
    }
    let at_third = mix(vec2(first), vec2(last), vec2(1.0 / 3.0, 2.0 / 3.0));
    var cell = first_cell(ray, brick.low, first);
    var t = first;
    var begins = last;
    var ends = first;
    var depth = 0.0;
    // Depths are weighted by the light lost there, in the mean of the channels.
    let dim = -ray.metres * dot(grid.extinction, vec3(1.0 / 3.0));
    var light = 1.0;
    var moments = vec3(0.0);
    for (var turn = 0u; turn < CELLS; turn += CELLS_AT_ONCE) {
        for (var n = 0u; n < unrolled(CELLS_AT_ONCE); n += 1u) {
            if t < last {
                let stretch = way_in_cell(ray, brick.low, cell, t, last);
                let next = stretch.next;
                let at = brick.first_texel + vec3<u32>(cell);
                let within = two_densities(at, stretch.a, stretch.b) * (0.5 * (next - t));
                depth += within;
                if SHADES_BRICKS {
                    all.thirds += within * clamp(
                        (at_third - t) / max(next - t, LEAST_WAY),
                        vec2(0.0),
                        vec2(1.0),
                    );
                }
                begins = select(begins, min(begins, t), within > 0.0);
                ends = select(ends, next, within > 0.0);
                if NODES > 0u {
                    let behind = exp(depth * dim);
                    let off = 0.5 * (t + next) - first;
                    let square = off * off + (next - t) * (next - t) * (1.0 / 12.0);
                    moments += (light - behind) * vec3(1.0, off, square);
                    light = behind;
                }
                cell = stretch.following;
                t = next;
            }
        }
        if t >= last {
            break;
        }
    }
    all.ends = vec2(first, last);
    all.first = begins;
    all.ramp = fitted_ramp(moments, first, begins, ends);
    all.depth = depth * ray.metres;
    all.thirds *= ray.metres;
    return all;
}
