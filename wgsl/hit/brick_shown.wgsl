// Light that a brick sends along a ray to the eye: for a thin grid by thirds, for a dense one cell by cell.
// CPU reference: crates/gobo-reference/src/brick.rs, crates/gobo-reference/src/brick_light.rs.

import package::hit::brick_cells::{CELLS, GAUSS, IndexRay, each_density, first_cell, index_ray, way_in_cell};
import package::hit::brick_light::{brick_light, lattice_light};
import package::records::brick::{Brick, Grid, LATTICE_EDGE, grid_lattices, lattice_points};
import package::records::view::GpuView;

// Equal parts of a ray's way through a box of constant density in a dense grid, each with light of its own.
const EVEN_PARTS: u32 = 25u;

// Mean of the light that a brick scatters along a ray between two ends, weighted by absorption. Each cell's
// light is taken at the mean place of its absorption.
fn dense_light(
    brick: Brick,
    ray: IndexRay,
    ends: vec2<f32>,
    extinction: vec3<f32>,
    first_point: u32,
    edge: u32,
) -> vec3<f32> {
    let is_even = brick.density >= 0.0;
    let texel = select(brick.first_texel, vec3(0u), is_even);
    let size = brick.high - brick.low;
    let mean = dot(extinction, vec3(1.0 / 3.0));
    var left = vec3(1.0); // share of the light from behind
    var all = vec3(0.0);
    var sum = vec3(0.0);
    var cell = first_cell(ray, brick.low, ends.x);
    var t = ends.x;
    for (var i = 0u; i < max(CELLS, EVEN_PARTS) && t < ends.y; i += 1u) {
        let stretch = way_in_cell(ray, brick.low, cell, t, ends.y);
        let part_end = select(
            mix(ends.x, ends.y, f32(i + 1u) / f32(EVEN_PARTS)),
            ends.y,
            i + 1u == EVEN_PARTS,
        );
        let next = select(stretch.next, part_end, is_even);
        let two = each_density(texel + vec3<u32>(cell), stretch.a, stretch.b);
        let depths = select(two, vec2(brick.density), is_even) * (0.5 * (next - t) * ray.metres);
        let passed = exp(-(depths.x + depths.y) * extinction);
        let absorbed = left * (1.0 - passed);
        let before = 1.0 - exp(-mean * depths.x);
        let behind = (1.0 - before) * (1.0 - exp(-mean * depths.y));
        let off = GAUSS * (behind - before) / max(before + behind, 1e-20);
        let at = 0.5 * (t + next) + off * (next - t);
        sum += absorbed * lattice_light(first_point, edge, (ray.start + ray.way * at - brick.low) / size);
        all += absorbed;
        left *= passed;
        cell = stretch.following;
        t = next;
    }
    return sum / max(all, vec3(1e-20));
}

// `ends`: where the ray enters and leaves the box, along the axis [m]; `depths`: optical depth of each third
// of the way between.
fn brick_shown(
    view: GpuView,
    id: u32,
    brick: Brick,
    grid: Grid,
    texel: vec2<f32>,
    ends: vec2<f32>,
    depths: vec3<f32>,
    extinction: vec3<f32>,
) -> vec3<f32> {
    let lattices = grid_lattices(brick.grid);
    let first_point = lattices.first_point + (id - lattices.first_brick) * lattice_points(lattices.edge);
    let ray = index_ray(view, grid, texel);
    if lattices.edge > LATTICE_EDGE {
        return dense_light(brick, ray, ends, extinction, first_point, lattices.edge);
    }
    let size = brick.high - brick.low;
    let enters = (ray.start + ray.way * ends.x - brick.low) / size;
    let leaves = (ray.start + ray.way * ends.y - brick.low) / size;
    return brick_light(first_point, lattices.edge, enters, leaves, depths, extinction);
}
