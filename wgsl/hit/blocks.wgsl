// Whether an opaque material's hit blocks the light at a texel. CPU reference:
// crates/gobo-reference/src/occlude.rs.

import package::bind::uniform::materials;
import package::features::{
    HAS_CAPSULES, HAS_DITHER, HAS_GAUSSIANS, HAS_PARTICLES, HAS_TRIANGLES,
};
import package::hit::triangle::edge;
import package::hit::dither::{PATTERN_HASHED, cell_threshold, hashed_threshold, pattern_cell};
import package::hit::gaussian::approach;
import package::hit::hit::{Hit, facing, facing_hit};
import package::hit::object::object_of;
import package::hit::solid::is_solid;
import package::records::capsule::is_capsule;
import package::records::caster::caster_rotation;
import package::records::footprint::{Footprint, caster_of, setup_of};
import package::records::gaussian::{gaussian_setup, is_gaussian};
import package::records::material::TRANSFER_DITHER;
import package::records::opaque_depth::opaque_bits;
import package::records::setup::setup_texel;
import package::records::view::GpuView;

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
