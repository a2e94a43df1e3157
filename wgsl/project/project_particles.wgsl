// project: particles -> footprints, depth keys and tile rectangles. One invocation per particle and view; a
// workgroup takes a chunk. CPU reference: crates/gobo-reference/src/project.rs. Rust: src/stage/project.rs.

import package::bind::read::chunks;
import package::bind::uniform::{materials, project_params, views};
import package::features::{HAS_BRICKS, HAS_CAPSULES, PARALLEL};
import package::hit::capsule::capsule_setup;
import package::project::extent::{brick_extent, capsule_extent, capsule_tiles, put, tangents};
import package::records::batch::workgroup_number;
import package::records::brick::brick_of;
import package::records::caster::{CAPSULE_MARK, caster_color, material_of};
import package::records::footprint::MIN_RADIUS;
import package::records::material::{
    GpuMaterial, SHAPE_BRICK, SHAPE_CAPSULE, SHAPE_GAUSSIAN, SHAPE_PUFF, SHAPE_QUAD, TRANSFER_NONE,
    TRANSFER_OPAQUE,
};
import package::records::pack::pack_color;
import package::records::record::{CasterRecord, FootprintRecord, OPACITY_SCALE};
import package::records::tile::{INVISIBLE, SLACK, box_rect, depth_key, distance_key, tile_rect};
import package::records::view::{GpuView, MIN_DISTANCE};
import choice::records::caster_record;
import choice::writes::write_footprint;

override WORKGROUP_SIZE: u32;

// A particle is beside the view if its depth along the axis is below this share of its distance from the
// light: its centre has no position in the map.
const MIN_COSINE: f32 = 0.05;
const SQRT_2: f32 = 1.41421356;
// Least nearest distance along the axis at which all corners of a brick have a position in the map, as a
// share of its farthest distance.
const BRICK_NEAR: f32 = 1e-3;

fn is_unseen(material: GpuMaterial) -> bool {
    return material.transfer == TRANSFER_NONE && project_params.include_non_casters == 0u;
}

// Key of a caster that is `nearest` [light depth] and at least `least` from the light [m].
fn front_key(view: GpuView, nearest: f32, least: f32) -> u32 {
    let by_distance = (project_params.by_distance == 1u) & (view.perspective > 0.0);
    return depth_key(select(nearest, distance_key(view, least), by_distance));
}

// A segment of a strand. `number`: of the view in its batch.
fn project_capsule(view: GpuView, number: u32, record: CasterRecord, index: u32, caster_id: u32) {
    let material = materials[material_of(record)];
    let extent = capsule_extent(view, capsule_setup(view, record));
    let alpha = unpack2x16float(record.blue_alpha).y * material.tint.a;
    // Written so that a NaN is invisible.
    if is_unseen(material) || !(alpha > 0.0 && extent.farthest >= 0.0 && extent.nearest <= 1.0) {
        put(index, INVISIBLE, vec2(0u));
        return;
    }
    let around = box_rect(view.size, number, extent.lo, extent.hi);
    let rect = capsule_tiles(extent, around);
    let front = front_key(view, extent.nearest, extent.least);
    put(index, select(front, INVISIBLE, (rect.y & 0xffffu) == 0u), rect);
    let look = vec4(bitcast<vec2<u32>>(extent.half), CAPSULE_MARK | (front << 16u), caster_id);
    write_footprint(index, FootprintRecord(extent.bounds, look));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn project_particles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let chunk_index = workgroup_number(workgroup, workgroups);
    if chunk_index >= project_params.chunk_count {
        return;
    }
    let chunk = chunks[chunk_index];
    if lane >= chunk.count {
        return;
    }
    let index = chunk.first_footprint + lane;
    let caster_id = chunk.first_caster + lane;
    let view = views[chunk.view];
    let record = caster_record(caster_id);
    let material = materials[material_of(record)];
    if material.shape == SHAPE_GAUSSIAN {
        return; // of the host's casters
    }
    if HAS_CAPSULES && material.shape == SHAPE_CAPSULE {
        project_capsule(view, chunk.view, record, index, caster_id);
        return;
    }
    let caster_radius = record.radius;

    let center = (view.view_from_world * vec4(record.center, 1.0)).xyz;
    let distance = -center.z;
    let range = view.far - view.near;
    let half_size = view.size * 0.5;
    let is_brick = HAS_BRICKS && material.shape == SHAPE_BRICK;
    // A sphere, or a brick in its sphere.
    let is_round = material.shape == SHAPE_PUFF || is_brick;
    let is_quad = material.shape == SHAPE_QUAD;
    let corner = select(1.0, SQRT_2, is_quad); // half a quad's diagonal reaches beyond its radius
    let is_parallel = PARALLEL || view.perspective == 0.0;
    let is_beside = !is_parallel && distance <= MIN_COSINE * length(center);
    var texel: vec2<f32>;
    var radius: f32;
    var grow: f32;
    var lo: vec2<f32>;
    var hi: vec2<f32>;
    var depth_reach: f32;
    if is_parallel {
        texel = vec2(center.x, -center.y) * view.scale + half_size;
        let projected = caster_radius * view.scale;
        grow = max(MIN_RADIUS / projected, 1.0);
        radius = projected * grow;
        lo = texel - radius * corner;
        hi = texel + radius * corner;
        depth_reach = select(0.0, caster_radius * grow, is_round);
    } else if is_beside {
        texel = half_size;
        grow = max(MIN_RADIUS * distance / (caster_radius * view.scale), 1.0);
        radius = caster_radius * grow;
        let away = max(length(center), MIN_DISTANCE);
        let reach = radius * corner;
        let sphere = select(reach / sqrt(1.0 + reach / away * (reach / away)), radius, is_round);
        let x = tangents(center.x, distance, sphere);
        let y = tangents(-center.y, distance, sphere);
        lo = vec2(x.x, y.x) * view.scale + half_size;
        hi = vec2(x.y, y.y) * view.scale + half_size;
        depth_reach = select(reach * (length(center.xy) / away), radius, is_round);
    } else {
        let slope = vec2(center.x, -center.y) / distance;
        texel = slope * view.scale + half_size;
        let len2 = 1.0 + dot(slope, slope);
        let projected = caster_radius * view.scale / distance;
        grow = max(MIN_RADIUS / projected, 1.0);
        let grown = caster_radius * grow;
        radius = grown / (distance * sqrt(len2));
        let reach = radius * corner;
        let sine = select(reach / sqrt(1.0 + reach * reach), reach, is_round);
        let sphere = sine * distance * sqrt(len2);
        let x = tangents(center.x, distance, sphere);
        let y = tangents(-center.y, distance, sphere);
        lo = vec2(x.x, y.x) * view.scale + half_size;
        hi = vec2(x.y, y.y) * view.scale + half_size;
        depth_reach = select(grown * corner * sqrt(max(1.0 - 1.0 / len2, 0.0)), grown, is_round);
    }
    var nearest = (distance - depth_reach - view.near) / range;
    var farthest = (distance + depth_reach - view.near) / range;
    // The nearest point of a plane that faces the light is its centre.
    var least = length(center) - select(0.0, depth_reach, is_round);
    if is_brick {
        let extent = brick_extent(view, brick_of(record.id), center);
        // Otherwise the bounding sphere's box holds.
        if is_parallel || extent.nearest > BRICK_NEAR * extent.farthest {
            lo = extent.lo;
            hi = extent.hi;
        }
        nearest = (extent.nearest - view.near) / range;
        farthest = (extent.farthest - view.near) / range;
        least = extent.least;
    }
    if is_unseen(material) || farthest < 0.0 || nearest > 1.0 {
        put(index, INVISIBLE, vec2(0u));
        return;
    }
    let circle = select(1e30, radius + SLACK, !(is_quad || is_brick) && is_parallel);
    // Only tiles can write opaque depths.
    let scatter = (project_params.scatter == 1u) & (material.transfer < TRANSFER_OPAQUE) & !is_beside;
    let rect = tile_rect(view.size, chunk.view, lo, hi, texel, circle, scatter);
    let front = front_key(view, nearest, least);
    put(index, select(front, INVISIBLE, (rect.y & 0xffffu) == 0u), rect);

    let color = caster_color(record, material.transfer) * material.tint;
    let thin = 1.0 / (grow * grow);
    let slope_a = (1.0 - material.reflectivity) * color.a * thin;
    let color_bits = pack_color(color.rgb, material.transfer);
    let blue_slope = color_bits.y | (pack2x16float(vec2(0.0, slope_a * OPACITY_SCALE)) & 0xffff0000u);
    let thin_front = (pack2x16float(vec2(thin * OPACITY_SCALE, 0.0)) & 0xffffu) | (front << 16u);
    var at = vec4(texel, radius, (distance - view.near) / range);
    if is_beside {
        at = vec4(center.x, -center.y, -radius, distance);
    }
    let look = vec4(color_bits.x, blue_slope, thin_front, caster_id);
    write_footprint(index, FootprintRecord(at, look));
}
