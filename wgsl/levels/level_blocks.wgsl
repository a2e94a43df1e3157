// levels: the blocks of one level of all views with levels, each from texels or blocks below. One invocation
// per block, borders included. Truth: tests/common/area_truth.rs. Rust: src/stage/levels.rs.

import package::bind::stored::new_levels;
import package::bind::uniform::level_params;
import package::curve::mean::{Ramp, find_parts, part_node};
import package::curve::node::DEPTHS;
import package::features::HAS_FACES;
import package::records::area::{BLOCK_TEXELS, SKIRT, block_number, level_map, leveled_view};
import package::records::light::shadow_view;
import package::records::record::record_texel;
import package::records::view::{GpuView, ROLE_FACE};
import package::shade::incoming::cube_face;
import choice::below::{CHILDREN, open_child, ramp_count};

struct LevelParams {
    level: u32,
    first_block: u32, // first of the level, counted over all views
    pad_0: u32,
    pad_1: u32,
}

@compute @workgroup_size(8, 8)
fn level_blocks(@builtin(global_invocation_id) id: vec3<u32>) {
    let leveled = leveled_view(id.z);
    let view = shadow_view(leveled.x);
    let map = level_map(view, id.z, level_params.level);
    let size = vec2<u32>(map.size) + 2u * SKIRT;
    if any(id.xy >= size) || level_params.level > leveled.y {
        return;
    }
    let at = vec2<i32>(id.xy) - i32(SKIRT);
    open_child(view, id.z, level_params.level, at);
    let ramps = ramp_count();
    // Most blocks are empty.
    let children = select(0u, CHILDREN, ramps > 0u);
    find_parts(children, ramps, 2u * BLOCK_TEXELS);
    let number = block_number(map, at) - level_params.first_block;
    for (var pair = 0u; pair < BLOCK_TEXELS; pair += 1u) {
        let first = part_node(2u * pair, children, ramps);
        let second = part_node(2u * pair + 1u, children, ramps);
        textureStore(new_levels, record_texel(number * BLOCK_TEXELS + pair), vec4(first, second));
    }
}

// Source of a child of a block: beyond the edge of a cube's face, a child of the neighbouring face; else the
// nearest child.

// `shift` turns its depths into this face's: times x, plus y, in fixed point.
struct ChildOwner {
    view: GpuView,
    leveled: u32,
    at: vec2<i32>,
    shift: vec2<f32>,
}

// `size`: number of children of the face [children], `edge`: edge of a child [texels].
fn child_owner(
    view: GpuView,
    leveled: u32,
    first_face: u32,
    size: vec2<i32>,
    edge: f32,
    at: vec2<i32>,
) -> ChildOwner {
    let nearest = clamp(at, vec2(0), size - 1);
    var owner = ChildOwner(view, leveled, nearest, vec2(1.0, 0.0));
    if HAS_FACES && any(nearest != at) && view.role == ROLE_FACE {
        let slope = ((vec2<f32>(at) + 0.5) * edge - view.size * 0.5) / view.scale;
        let away = (vec4(slope.x, -slope.y, -1.0, 0.0) * view.view_from_world).xyz;
        owner.leveled = first_face + cube_face(away);
        owner.view = shadow_view(leveled_view(owner.leveled).x);
        let p = (owner.view.view_from_world * vec4(away, 0.0)).xyz;
        // Depth along the neighbour's axis per unit of depth along this face's.
        let along = max(-p.z, 1e-6);
        let position = vec2(p.x, -p.y) * (owner.view.scale / along) + owner.view.size * 0.5;
        let range = view.far - view.near;
        let offset = (owner.view.near / along - view.near) / range * DEPTHS;
        owner.shift = vec2((owner.view.far - owner.view.near) / (along * range), offset);
        let last = ceil(owner.view.size / edge) - 1.0;
        owner.at = vec2<i32>(clamp(floor(position / edge), vec2(0.0), last));
    }
    return owner;
}

// The ramp of a child, with its depths turned into this face's.
fn shifted(ramp: Ramp, shift: vec2<f32>) -> Ramp {
    if HAS_FACES {
        let start = clamp(round(ramp.start * shift.x + shift.y), 1.0, DEPTHS);
        return Ramp(select(0.0, start, ramp.start > 0.0), ramp.length * shift.x, ramp.drop);
    }
    return ramp;
}
