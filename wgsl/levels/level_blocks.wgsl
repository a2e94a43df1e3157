// levels: the blocks of one level of all leveled views, each from four texels or blocks below. One
// invocation per block, the border included. CPU twin: src/reference/shading/levels.rs. Host:
// src/stage/levels.rs.

import choice::below::{open_child, ramp_count};
import package::bind::stored::new_levels;
import package::bind::uniform::level_params;
import package::curve::node::DEPTHS;
import package::curve::mean::{find_parts, part_node, ramp_shift};
import package::records::area::{
    BLOCK_TEXELS, LevelMap, SKIRT, block_number, level_map, leveled_view,
};
import package::records::light::shadow_view;
import package::records::record::record_texel;
import package::records::view::{GpuView, PART_FACE};
import package::shade::receive::cube_face;

struct LevelParams {
    level: u32,
    first_block: u32, // first of the level, counted over all views
    pad_0: u32,
    pad_1: u32,
}

// Source of a block's values: beyond the edge of a cube's face a block of the neighbour, else the nearest
// block. Its depths become this face's by `shift`: times x, plus y, in fixed point.
struct BlockOwner {
    leveled: u32,
    at: vec2<i32>,
    shift: vec2<f32>,
}

fn block_owner(view: GpuView, leveled: u32, first_face: u32, map: LevelMap, at: vec2<i32>) -> BlockOwner {
    let nearest = clamp(at, vec2(0), map.size - 1);
    if all(nearest == at) || view.part != PART_FACE {
        return BlockOwner(leveled, nearest, vec2(1.0, 0.0));
    }
    let slope = ((vec2<f32>(at) + 0.5) * map.edge - view.size * 0.5) / view.scale;
    let away = (vec4(slope.x, -slope.y, -1.0, 0.0) * view.view_from_world).xyz;
    let other = first_face + cube_face(away);
    let of_other = shadow_view(leveled_view(other).x);
    let p = (of_other.view_from_world * vec4(away, 0.0)).xyz;
    // Depth along the neighbour's axis per unit of depth along this face's.
    let along = max(-p.z, 1e-6);
    let place = vec2(p.x, -p.y) * (of_other.scale / along) + of_other.size * 0.5;
    let range = view.far - view.near;
    let offset = (of_other.near / along - view.near) / range * DEPTHS;
    let shift = vec2((of_other.far - of_other.near) / (along * range), offset);
    let there = clamp(vec2<i32>(floor(place / map.edge)), vec2(0), map.size - 1);
    return BlockOwner(other, there, shift);
}

@compute @workgroup_size(8, 8)
fn level_blocks(@builtin(global_invocation_id) id: vec3<u32>) {
    let own = leveled_view(id.z);
    let view = shadow_view(own.x);
    let map = level_map(view, id.z, level_params.level);
    let size = vec2<u32>(map.size) + 2u * SKIRT;
    if any(id.xy >= size) || level_params.level > own.y {
        return;
    }
    let at = vec2<i32>(id.xy) - i32(SKIRT);
    let owner = block_owner(view, id.z, own.z, map, at);
    open_child(owner.leveled, level_params.level, owner.at);
    ramp_shift = owner.shift;
    // Loop counts are not constant, so that compilers don't unroll.
    let some = map.first < 0xffffffffu;
    let children = select(0u, 4u, some);
    let ramps = select(0u, ramp_count(), some);
    find_parts(children, ramps, 2u * BLOCK_TEXELS);
    let number = block_number(map, at) - level_params.first_block;
    for (var pair = 0u; pair < children / 2u; pair += 1u) {
        let first = part_node(2u * pair, children, ramps);
        let second = part_node(2u * pair + 1u, children, ramps);
        textureStore(new_levels, record_texel(number * BLOCK_TEXELS + pair), vec4(first, second));
    }
}
