// Light that a brick of a thin grid sends along a ray to the eye: light scattered at four points of the ray,
// interpolated in the brick's lattice, weighted by the light absorbed near each, with even density in each
// third of the way. CPU reference: crates/gobo-reference/src/brick_light.rs,
// crates/gobo-reference/src/brick.rs, crates/gobo-reference/src/brick_light.rs,
// crates/gobo-reference/src/brick.rs, crates/gobo-reference/src/shading/mod.rs.

import package::bind::sampled::brick_lights;
import package::hit::brick::{CELLS, GAUSS, IndexRay, each_density, first_cell, index_ray, way_in_cell};
import package::records::brick::{Brick, Grid, LATTICE_EDGE, grid_lattices, lattice_points};
import package::records::record::record_texel;
import package::records::view::GpuView;

// Whether the kernel shades bricks.
override SHADES_BRICKS: bool = false;

const THIRDS: u32 = 3u;
const SERIES: f32 = 0.02; // optical depth below which a series is more precise

fn point_light_at(index: u32) -> vec3<f32> {
    return textureLoad(brick_lights, record_texel(index), 0).rgb;
}

// Trilinear between the points of a lattice, `edge` along each edge; `position` in the box, 0..1.
fn lattice_light(first_point: u32, edge: u32, position: vec3<f32>) -> vec3<f32> {
    let last = f32(edge - 1u);
    let at = clamp(position, vec3(0.0), vec3(1.0)) * last;
    let low = min(floor(at), vec3(last - 1.0));
    let aside = at - low;
    let cell = vec3<u32>(low);
    let row = edge;
    let layer = edge * edge;
    let lattice_point = first_point + cell.x + cell.y * row + cell.z * layer;
    let a = mix(point_light_at(lattice_point), point_light_at(lattice_point + 1u), aside.x);
    let b = mix(point_light_at(lattice_point + row), point_light_at(lattice_point + row + 1u), aside.x);
    let low_layer = mix(a, b, aside.y);
    let c = mix(point_light_at(lattice_point + layer), point_light_at(lattice_point + layer + 1u), aside.x);
    let d = mix(
        point_light_at(lattice_point + layer + row),
        point_light_at(lattice_point + layer + row + 1u),
        aside.x,
    );
    return mix(low_layer, mix(c, d, aside.y), aside.z);
}

// Mean distance from its start at which a homogeneous medium of optical depth `tau` absorbs light, as a share
// of its length: 1 / tau - 1 / (exp(tau) - 1).
fn mean_way(tau: vec3<f32>) -> vec3<f32> {
    let exact = 1.0 / tau - 1.0 / (exp(min(tau, vec3(80.0))) - 1.0);
    return select(exact, 0.5 - tau / 12.0, tau < vec3(SERIES));
}

// Mean of the light that a brick scatters along a ray, weighted by absorption. `depths`: optical depth of
// each third of the ray's way through the box.
fn brick_light(
    first_point: u32,
    edge: u32,
    enters: vec3<f32>,
    leaves: vec3<f32>,
    depths: vec3<f32>,
    extinction: vec3<f32>,
) -> vec3<f32> {
    var left = vec3(1.0); // share of the light from behind
    var all = vec3(0.0);
    var sum = vec3(0.0);
    var far = vec3(0.0);  // absorbed in the third before, in the weight of its end
    // A count unknown to compilers keeps the loop from being unrolled: its code is large.
    let samples = select(0u, THIRDS + 1u, any(depths > vec3(0.0)));
    for (var i = 0u; i < samples; i += 1u) {
        let depth = select(select(depths.z, depths.y, i == 1u), depths.x, i == 0u);
        let tau = select(depth, 0.0, i == THIRDS) * extinction;
        let passed = exp(-tau);
        let absorbed = left * (1.0 - passed);
        let at_end = absorbed * mean_way(tau);
        let position = mix(enters, leaves, f32(i) / f32(THIRDS));
        sum += (far + absorbed - at_end) * lattice_light(first_point, edge, position);
        all += absorbed;
        far = at_end;
        left *= passed;
    }
    return sum / max(all, vec3(1e-20));
}

// Light that a brick sends along a ray to the eye: for a thin grid by thirds, for a dense one cell by cell.

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
