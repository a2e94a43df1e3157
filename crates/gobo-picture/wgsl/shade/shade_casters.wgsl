// shade, casters: points of particles, Gaussians and bricks. CPU reference: src/model/black_body.rs,
// crates/gobo-reference/src/brick_light.rs, crates/gobo-reference/src/shade/mod.rs,
// crates/gobo-reference/src/shade/mod.rs. Rust: crates/gobo-picture/src/stage/shade.rs.

import package::bind::sampled::{bricks, voxels};
import package::bind::uniform::{materials, point_batch, views};
import package::features::{HAS_CAPSULES, NODES};
import package::records::brick::{
    BRICK_SIZE, Brick, SLOT_HEIGHT, SLOT_WIDTH, brick_of, grid_lattices, grid_of, lattice_points, voxel_edges,
};
import package::records::caster::{capsule_of, material_of, particle_object};
import package::records::footprint::{caster_of, load_footprint};
import package::records::light::{ALL_LIGHTS, cluster_of};
import package::records::material::SHAPE_CAPSULE;
import package::records::point::{POINT_BRICK, POINT_NONE, POINT_PARTICLE, POINT_STRAND, Point};
import package::records::record::record_texel;
import package::records::texel::owner_tag;
import package::records::view::GpuView;
import package::shade::points::store_point;
import choice::records::{caster_record, rect_record};

// Light of hot media.

const RADIATION: f32 = 14387770.0; // Planck's second radiation constant [nm K]
// Wavelengths of the sum over the visible spectrum: the first, their distance [nm] and their number.
const FIRST_WAVELENGTH: f32 = 380.0;
const WAVELENGTH_STEP: f32 = 10.0;
const WAVELENGTHS: u32 = 41u;
const UNIT_RADIANCE: f32 = 423638.56; // of the sum, so that red is 1 at 1500 K
// Exponents of Planck's law between which exp(x) - 1 is representable.
const LEAST_POWER: f32 = 1e-3;
const MOST_POWER: f32 = 80.0;

// Radiance of a black body (Planck 1901) seen by the CIE 1931 observer: linear sRGB, as a share of red at
// 1500 K. Colours outside sRGB are clamped to it; 0 up to 0 K.
fn black_body(kelvin: f32) -> vec3<f32> {
    var seen = vec3(0.0);
    for (var i = 0u; i < WAVELENGTHS && kelvin > 0.0; i += 1u) {
        let nm = FIRST_WAVELENGTH + WAVELENGTH_STEP * f32(i);
        let power = clamp(RADIATION / (nm * kelvin), LEAST_POWER, MOST_POWER);
        let shorter = 600.0 / nm;
        let longer = shorter * shorter;
        seen += observer(nm) * (longer * longer * shorter / (exp(power) - 1.0));
    }
    // Linear sRGB (IEC 61966-2-1).
    let rgb = vec3(3.2406, -0.9689, 0.0557) * seen.x + vec3(-1.5372, 1.8758, -0.2040) * seen.y
        + vec3(-0.4986, 0.0415, 1.0570) * seen.z;
    return max(rgb * UNIT_RADIANCE, vec3(0.0));
}

// Colour matching functions of CIE 1931 (Wyman, Sloan and Shirley 2013, section 2.2).
fn observer(nm: f32) -> vec3<f32> {
    return vec3(
        lobe(nm, 1.056, 599.8, 37.9, 31.0)
            + lobe(nm, 0.362, 442.0, 16.0, 26.7)
            - lobe(nm, 0.065, 501.1, 20.4, 26.2),
        lobe(nm, 0.821, 568.8, 46.9, 40.5) + lobe(nm, 0.286, 530.9, 16.3, 31.1),
        lobe(nm, 1.217, 437.0, 11.8, 36.0) + lobe(nm, 0.681, 459.0, 26.0, 13.8),
    );
}

// A normal curve of two widths [nm].
fn lobe(nm: f32, height: f32, middle: f32, shorter: f32, longer: f32) -> f32 {
    let aside = (nm - middle) / select(longer, shorter, nm < middle);
    return height * exp(-0.5 * aside * aside);
}

override WORKGROUP_SIZE: u32;

// Whether the camera may see a sphere; `center` in view space [m].
fn is_in_picture(view: GpuView, center: vec3<f32>, radius: f32) -> bool {
    let slope = view.size * 0.5 / view.scale;
    let beyond = abs(center.xy) + center.z * slope;
    let aside = all(beyond <= radius * sqrt(1.0 + slope * slope));
    return aside && -center.z + radius >= view.near && -center.z - radius <= view.far;
}

// shade, bricks: the points of the bricks' lattices. One invocation per point.
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

// shade, casters: centre of each visible translucent particle, as a point. One invocation per footprint of
// the camera's view.
@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_casters(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if index >= point_batch.count {
        return;
    }
    let id_in_view = point_batch.first + index;
    let footprint = load_footprint(id_in_view);
    let is_particle = !footprint.is_triangle;
    let is_seen = rect_record(id_in_view).y != 0u;
    let caster = select(0u, caster_of(footprint), is_particle);
    let record = caster_record(caster);
    let material = materials[material_of(record)];
    var point: Point;
    point.kind = select(POINT_NONE, POINT_PARTICLE, is_particle && is_seen);
    point.position = record.center;
    // Does not shadow itself: the bias is its radius.
    point.reach = record.radius;
    point.cluster = cluster_of(footprint.bounds.xy, footprint.bounds.w);
    point.receives = material.receives;
    point.tag = owner_tag(record.id);
    point.albedo = vec3(1.0);
    if HAS_CAPSULES && is_particle && material.shape == SHAPE_CAPSULE {
        let capsule = capsule_of(record.id);
        let along = capsule.last - capsule.first;
        point.kind = select(POINT_NONE, POINT_STRAND, is_seen);
        point.normal = along / max(length(along), 1e-30);
        point.reach = max(capsule.radii.x, capsule.radii.y);
        point.tag = owner_tag(particle_object(record.id));
        point.roughness = material.roughness;
    }
    store_point(index, point);
}

// Temperature of a brick at x, y, z of 0..=8 [K]; 0 for a brick without temperatures.
fn temperature(brick: Brick, at: vec3<f32>) -> f32 {
    let end = textureDimensions(voxels);
    var slot = brick.first_texel + vec3(SLOT_WIDTH, 0u, 0u);
    slot = select(slot, vec3(0u, slot.y + SLOT_HEIGHT, slot.z), slot.x >= end.x);
    slot = select(slot, vec3(0u, 0u, slot.z + SLOT_HEIGHT), slot.y >= end.y);
    let is_hot = brick.density < -1.5;
    let cell = min(floor(at), vec3(BRICK_SIZE - 1.0));
    let aside = at - cell;
    let lower = select(vec3(0u), slot + vec3<u32>(cell), is_hot);
    // A texel has four voxels: its own, and the next in y, in z and in both.
    let four = mix(textureLoad(voxels, lower, 0), textureLoad(voxels, lower + vec3(1u, 0u, 0u), 0), aside.x);
    let two = mix(four.xz, four.yw, aside.y);
    return select(0.0, mix(two.x, two.y, aside.z), is_hot);
}

// Scattering and emission of a grid.
struct GridLook {
    anisotropy: f32, // `g` of its phase function
    material: u32,
    emission: f32,   // radiance of an opaque medium at 1500 K, in red
}

fn grid_look(grid: u32) -> GridLook {
    let look = textureLoad(bricks, record_texel(grid + 6u), 0);
    return GridLook(bitcast<f32>(look.x), look.y, bitcast<f32>(look.z));
}
