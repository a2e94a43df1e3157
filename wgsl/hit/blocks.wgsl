// Whether an opaque material's hit blocks the light at a texel. CPU reference:
// crates/gobo-reference/src/occlude.rs.

import package::bind::read::small_depths;
import package::bind::uniform::materials;
import package::features::{HAS_CAPSULES, HAS_DITHER, HAS_GAUSSIANS, HAS_PARTICLES, HAS_SMALL, HAS_TRIANGLES};
import package::hit::dither::{PATTERN_HASHED, cell_threshold, hashed_threshold, pattern_cell};
import package::hit::gaussian::approach;
import package::hit::hit::{Hit, facing, facing_hit, is_solid};
import package::hit::triangle::edge;
import package::records::caster::{caster_rotation, gaussian_setup, is_capsule, is_gaussian, object_of};
import package::records::footprint::{Footprint, caster_of, setup_of, setup_texel};
import package::records::material::TRANSFER_DITHER;
import package::records::texel::opaque_bits;
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::depth_to_nearness;

fn blocks(view: GpuView, footprint: Footprint, texel: vec2<f32>, hit: Hit) -> bool {
    if HAS_DITHER && hit.depth >= 0.0 && materials[hit.material].transfer == TRANSFER_DITHER {
        return hit.opacity > threshold(view, footprint, texel, hit.material, object_of(footprint));
    }
    return is_solid(hit);
}

// Point where a threshold is evaluated: the pattern's cell, or for `hashed` the coordinates on the caster and
// their change from one texel to the next.
struct PatternPoint {
    cell: vec2<u32>,
    on_caster: vec4<f32>,
}

// Dither threshold: a `dither` hit blocks if its opacity exceeds it. `id` chooses the pattern.
fn threshold(
    view: GpuView,
    footprint: Footprint,
    texel: vec2<f32>,
    material: u32,
    id: u32,
) -> f32 {
    return threshold_at(pattern_point(view, footprint, texel, material), material, id);
}

fn pattern_point(view: GpuView, footprint: Footprint, texel: vec2<f32>, material_id: u32) -> PatternPoint {
    let material = materials[material_id];
    var point = PatternPoint(vec2(0u), vec4(0.0));
    if material.pattern != PATTERN_HASHED {
        point.cell = pattern_cell(view, material.pattern_scale, texel);
    } else if HAS_TRIANGLES && footprint.is_triangle {
        point.on_caster = on_triangle(setup_of(footprint), texel);
    } else if HAS_GAUSSIANS && is_gaussian(footprint) {
        let setup = gaussian_setup(footprint);
        let w = setup.whitening;
        point.on_caster = vec4(
            approach(view, footprint, setup, texel).position,
            max(abs(w.x), abs(w.y)),
            abs(w.z),
        );
    } else if HAS_CAPSULES && is_capsule(footprint) {
        point.on_caster = vec4(texel - footprint.bounds.xy, vec2(1.0));
    } else if HAS_PARTICLES {
        let rotation = caster_rotation(caster_of(footprint));
        let plane = facing(view, footprint.bounds, rotation);
        let x = max(abs(plane.frame_x.x), abs(plane.frame_x.y));
        let y = max(abs(plane.frame_y.x), abs(plane.frame_y.y));
        point.on_caster = vec4(facing_hit(plane, view, texel).xy, x, y);
    }
    return point;
}

fn threshold_at(point: PatternPoint, material_id: u32, id: u32) -> f32 {
    let material = materials[material_id];
    if material.pattern != PATTERN_HASHED {
        return cell_threshold(material.pattern, material.blue_first, point.cell, id);
    }
    return hashed_threshold(point.on_caster.xy, point.on_caster.zw, material.pattern_scale, id);
}

// Barycentric weights of two corners, and their derivatives from one texel to the next.
fn on_triangle(setup: u32, texel: vec2<f32>) -> vec4<f32> {
    let weights = bitcast<vec3<f32>>(setup_texel(setup, 3u).xyz);
    let a = edge(setup, 0u, texel) * weights.x;
    let b = edge(setup, 1u, texel) * weights.y;
    let sum = a + b + edge(setup, 2u, texel) * weights.z;
    let da = edge_step(setup, 0u) * weights.x;
    let db = edge_step(setup, 1u) * weights.y;
    let dsum = da + db + edge_step(setup, 2u) * weights.z;
    let weighted = vec2(a, b) / sum;
    let along_a = abs(da - weighted.x * dsum) / sum;
    let along_b = abs(db - weighted.y * dsum) / sum;
    return vec4(weighted, max(along_a.x, along_a.y), max(along_b.x, along_b.y));
}

// Derivatives of an edge function along x and y.
fn edge_step(setup: u32, i: u32) -> vec2<f32> {
    let line = bitcast<vec4<f32>>(setup_texel(setup, i));
    return vec2(-line.w, line.z);
}

// Opaque depth in the format of a map.
fn stored_depth(hit: Hit) -> f32 {
    let dithered = HAS_DITHER && materials[hit.material].transfer == TRANSFER_DITHER;
    return bitcast<f32>(opaque_bits(hit.depth, dithered));
}

// Least depth of these triangles at a texel of the view's map, 1 for none.
fn small_depth(view: GpuView, texel: vec2<u32>) -> f32 {
    if !HAS_SMALL {
        return 1.0;
    }
    let first = view.first_tile * TILE_SIZE * TILE_SIZE;
    return bitcast<f32>(small_depths[first + texel.y * view.tiles_x * TILE_SIZE + texel.x]);
}

// Channels of the light that an opaque material's hit blocks at a texel; a `dither` caster has a threshold
// per channel.
fn blocked_channels(view: GpuView, footprint: Footprint, texel: vec2<f32>, hit: Hit) -> vec3<bool> {
    if hit.depth >= 0.0 && materials[hit.material].transfer == TRANSFER_DITHER {
        let id = object_of(footprint) * 3u;
        let point = pattern_point(view, footprint, texel, hit.material);
        let thresholds = vec3(
            threshold_at(point, hit.material, id),
            threshold_at(point, hit.material, id + 1u),
            threshold_at(point, hit.material, id + 2u),
        );
        return 1.0 - hit.light > thresholds;
    }
    return vec3(is_solid(hit));
}

// Depth behind which all channels are blocked.
fn last_depth(depths: vec3<f32>) -> f32 {
    return max(max(depths.r, depths.g), depths.b);
}

fn nearnesses(depths: vec3<f32>) -> vec3<u32> {
    return vec3(depth_to_nearness(depths.r), depth_to_nearness(depths.g), depth_to_nearness(depths.b));
}
