// levels: the blocks of one level of all views with levels, each from texels or blocks below. One invocation
// per block, borders included. Truth: tests/common/area_truth.rs. Rust: src/stage/levels.rs.

import choice::below::{child_count, open_child, ramp_count};
import package::bind::stored::new_levels;
import package::bind::uniform::level_params;
import package::curve::mean::{find_parts, part_node};
import package::records::area::{BLOCK_TEXELS, SKIRT, block_number, level_map, leveled_view};
import package::records::light::shadow_view;
import package::records::record::record_texel;

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
    let children = select(0u, child_count(), ramps > 0u);
    let pairs = select(0u, BLOCK_TEXELS, map.first < 0xffffffffu);
    find_parts(children, ramps, 2u * BLOCK_TEXELS);
    let number = block_number(map, at) - level_params.first_block;
    for (var pair = 0u; pair < pairs; pair += 1u) {
        let first = part_node(2u * pair, children, ramps);
        let second = part_node(2u * pair + 1u, children, ramps);
        textureStore(new_levels, record_texel(number * BLOCK_TEXELS + pair), vec4(first, second));
    }
}
