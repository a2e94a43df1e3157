// load: casters in the host's buffers -> records as if they had been uploaded, and a box around each group.
// One invocation per caster, a workgroup per group. Invalid casters are counted; valid ones are compacted,
// in order. CPU reference: `Caster::new` in src/records/caster.rs. Rust: src/stage/load.rs.

import package::bind::stored::casters;
import package::bind::uniform::{load_params, materials};
import package::load::group::{
    add_caster, caster_count, is_color, is_finite, is_of_set, is_position, is_within, slot_in_group,
    store_group,
};
import package::load::pack_caster::{packed_look, packed_position};
import package::records::dispatch::workgroup_number;
import package::records::host::{CHUNK_SIZE, Caster};
import package::records::material::{MAX_GAIN, SHAPE_QUAD, TRANSFER_GAIN};
import package::records::record::record_texel;
import choice::loader::load_caster;

fn is_usable(caster: Caster) -> bool {
    if !is_of_set(caster.material) {
        return false;
    }
    let brightest = select(1.0, MAX_GAIN, materials[caster.material].transfer == TRANSFER_GAIN);
    return is_finite(caster.radius) && caster.radius > 0.0 && is_finite(caster.rotation)
        && is_within(caster.color.a, 0.0, 1.0)
        && is_position(caster.center) && is_color(caster.color.rgb, brightest);
}

@compute @workgroup_size(CHUNK_SIZE)
fn load_casters(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let group = workgroup_number(workgroup, workgroups);
    if group >= load_params.group_count {
        return;
    }
    let index = group * CHUNK_SIZE + lane;
    var caster: Caster;
    var taken = false;
    var is_left_out = false;
    var reach = 0.0;
    if index < caster_count() {
        caster = load_caster(index);
        taken = is_usable(caster);
        let is_there = (load_params.may_be_none == 0u) | (caster.radius != 0.0);
        is_left_out = is_there && !taken;
    }
    if taken {
        let is_quad = materials[caster.material].shape == SHAPE_QUAD;
        reach = caster.radius * select(1.0, load_params.quad_reach, is_quad);
    }
    add_caster(lane, taken, is_left_out, vec4(caster.center, reach), caster.color.a);
    let slot = slot_in_group(lane);
    if taken {
        let texel = 2u * (load_params.first_caster + group * CHUNK_SIZE + slot.x);
        textureStore(casters, record_texel(texel), packed_position(caster));
        textureStore(casters, record_texel(texel + 1u), packed_look(caster));
    }
    store_group(group, lane, slot.y);
}
