// project: Gaussians -> footprints, depth keys, tile rectangles and setups. One invocation per Gaussian and
// view; a workgroup takes a chunk. CPU reference: crates/gobo-reference/src/gaussian.rs. Rust:
// src/stage/project.rs.

import package::bind::read::chunks;
import package::bind::uniform::{materials, project_params, views};
import package::features::PARALLEL;
import package::project::conic::{
    Placed, gaussian_beside, gaussian_within, has_outline, outline_of, reach_squared,
};
import package::project::extent::put;
import package::records::batch::workgroup_number;
import package::records::caster::{
    GAUSSIAN_MARK, GAUSSIAN_TEXELS, MEDIUM_BIT, NEUTRAL_BIT, OUTLINE_TEXEL, caster_color, gaussian_axes,
    material_of,
};
import package::records::material::{SHAPE_GAUSSIAN, TRANSFER_NONE};
import package::records::outline::{Outline, is_outlined, outlined_tiles};
import package::records::pack::pack_color;
import package::records::record::{FootprintRecord, OPACITY_SCALE};
import package::records::tile::{INVISIBLE, box_rect, depth_key, distance_key};
import choice::records::caster_record;
import choice::writes::{write_footprint, write_setup_words};

override WORKGROUP_SIZE: u32;

// A Gaussian is beside the view if its depth along the axis is below this share of its distance from the
// light.
const MIN_COSINE: f32 = 0.05;
const MEDIUM_REACH: f32 = 4.0; // of a medium's absorption around its closest approach [standard deviations]
const ROOT_TAU: f32 = 2.5066283;
const MIN_DISTANCE: f32 = 1.17549435e-38; // [m]

// Columns are the axes of a unit quaternion.
fn axes_of(q: vec4<f32>) -> mat3x3<f32> {
    let d = q + q;
    let x = q.x * d;
    let y = q.y * d;
    let z = q.z * d;
    let w = q.w * d;
    return mat3x3(
        vec3(1.0 - y.y - z.z, x.y + w.z, x.z - w.y),
        vec3(x.y - w.z, 1.0 - x.x - z.z, y.z + w.x),
        vec3(x.z + w.y, y.z - w.x, 1.0 - x.x - y.y),
    );
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn project_gaussians(
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
    let caster_id = chunk.first_caster + lane;
    let index = chunk.first_footprint + lane;
    let view = views[chunk.view];
    let record = caster_record(caster_id);
    let material = materials[material_of(record)];
    if material.shape != SHAPE_GAUSSIAN {
        return; // of the host's casters
    }
    let unprojected = gaussian_axes(record.id);
    let sigma = unprojected.sigma;

    let to_map = vec3(1.0, -1.0, -1.0);
    let center = (view.view_from_world * vec4(record.center, 1.0)).xyz * to_map;
    let rotation_axes = axes_of(unprojected.rotation);
    var axes: mat3x3<f32>; // its deviations to the right, down and along the axis [m]
    for (var i = 0; i < 3; i += 1) {
        axes[i] = (view.view_from_world * vec4(rotation_axes[i] * sigma[i], 0.0)).xyz * to_map;
    }
    let color = caster_color(record, material.transfer) * material.tint;
    let is_medium = (record.material_rotation & MEDIUM_BIT) != 0u;
    let longest = max(max(sigma.x, sigma.y), sigma.z);
    var amplitude = color.a * select(1.0, OPACITY_SCALE * ROOT_TAU, is_medium);
    let squared = reach_squared(amplitude * select(1.0, longest, is_medium));
    let is_beside = !PARALLEL && view.perspective > 0.0 && center.z <= MIN_COSINE * length(center);
    var placed: Placed;
    if !PARALLEL && is_beside {
        placed = gaussian_beside(view, center, axes, sigma, squared);
    } else {
        placed = gaussian_within(view, center, axes, squared);
    }
    // A medium absorbs in front of and behind its closest approach.
    let reach = sqrt(squared) + select(0.0, MEDIUM_REACH, is_medium);
    let depth_reach = reach * length(vec3(axes[0].z, axes[1].z, axes[2].z));
    let range = view.far - view.near;
    let nearest = (center.z - depth_reach - view.near) / range;
    let farthest = (center.z + depth_reach - view.near) / range;
    let in_shadows = project_params.include_non_casters == 0u;
    let unseen = material.transfer == TRANSFER_NONE && in_shadows;
    // Written so that a NaN is invisible.
    if unseen || !(amplitude > 0.0 && farthest >= 0.0 && nearest <= 1.0) {
        put(index, INVISIBLE, vec2(0u));
        return;
    }
    let bounds = vec4(placed.center, select(1.0, -1.0, is_beside) * sqrt(squared), placed.depth);
    var rect = box_rect(view.size, chunk.view, placed.lo, placed.hi);
    var outline: Outline;
    if (rect.y & 0xffffu) != 0u && !is_beside && has_outline(placed.ellipse) {
        outline = outline_of(placed.ellipse, (rect.x >> 8u) & 255u);
        let outlined = outlined_tiles(outline, rect);
        // `bin` finds outlines by the indices of footprints, which differ from those of setups for a host's
        // Gaussians.
        let is_found = (project_params.first_gaussian == 0u) | !is_outlined(outlined);
        rect = select(rect, outlined, is_found);
    }
    let away = length(center);
    let toward = center / max(away, MIN_DISTANCE);
    let along = length(vec3(dot(axes[0], toward), dot(axes[1], toward), dot(axes[2], toward)));
    let least = distance_key(view, max(away - reach * along, 0.0));
    let by_distance = (project_params.by_distance == 1u) & (view.perspective > 0.0);
    let front = depth_key(select(nearest, least, by_distance));
    put(index, select(front, INVISIBLE, (rect.y & 0xffffu) == 0u), rect);

    let rgb = select(color.rgb, vec3(0.0), in_shadows & ((record.material_rotation & NEUTRAL_BIT) != 0u));
    amplitude *= select(placed.thin, 1.0, is_medium);
    let color_bits = pack_color(rgb, material.transfer);
    let blue_thin = color_bits.y | (pack2x16float(vec2(0.0, placed.thin * OPACITY_SCALE)) & 0xffff0000u);
    let setup = placed.setup;
    let setup_index = index - project_params.first_gaussian;
    let at = setup_index * GAUSSIAN_TEXELS;
    write_setup_words(at, bitcast<vec4<u32>>(vec4(setup.whitening, setup.spread)));
    let tilt = bitcast<vec2<u32>>(setup.tilt);
    write_setup_words(at + 1u, vec4(tilt, color_bits.x, blue_thin));
    let lines = vec4(bitcast<u32>(outline.first), outline.step_shift, outline.lean_width, outline.row_middle);
    write_setup_words(at + OUTLINE_TEXEL, lines);
    let look = vec4(setup_index, bitcast<u32>(amplitude), GAUSSIAN_MARK | (front << 16u), caster_id);
    write_footprint(index, FootprintRecord(bounds, look));
}
