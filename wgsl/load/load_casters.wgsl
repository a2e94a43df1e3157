// Casters of a host. CPU reference: `CasterRecord::new` in src/records/caster.rs. Rust: `CasterRecord::new`
// in src/records/caster.rs, src/stage/load.rs.

import package::bind::changed::casters;
import package::bind::uniform::{load_params, materials};
import package::load::group::{
    add_caster, caster_count, is_color, is_finite, is_of_set, is_position, is_within, slot_in_group,
    store_group,
};
import package::records::batch::workgroup_number;
import package::records::host::{CHUNK_SIZE, Caster};
import package::records::material::{MAX_GAIN, SHAPE_QUAD, TRANSFER_GAIN};
import package::records::record::{CasterRecord, OPACITY_SCALE};
import choice::loader::load_caster;

// Packs a host's caster into the record that its upload would make, bit for bit if the device divides as in
// IEEE 754.

const TURN: f32 = 6.2831853; // [radians]

// Linear rgb as in wgsl/records/pack.wgsl; divided by 16 for a `gain` material.
fn packed_color(color: vec3<f32>, material: u32) -> vec3<u32> {
    let is_gain = materials[material].transfer == TRANSFER_GAIN;
    let squared = select(1.0 - color, color / MAX_GAIN, is_gain);
    return vec3<u32>(floor(0.5 + 65535.0 * sqrt(squared)));
}

fn packed_caster(caster: Caster) -> CasterRecord {
    let levels = packed_color(caster.color.rgb, caster.material);
    let turns = caster.rotation / TURN;
    let part = turns - floor(turns);
    // Halves are rounded up, as in the CPU reference.
    let angle = u32(floor(part * 65536.0 + 0.5)) & 0xffffu;
    return CasterRecord(
        caster.center,
        caster.radius,
        levels.r | (levels.g << 16u),
        levels.b | (half_bits(caster.color.a * OPACITY_SCALE) << 16u),
        caster.material | (angle << 16u),
        caster.id,
    );
}

// f16 of a number in 0..65504, rounded to nearest even: `pack2x16float` may round otherwise.
fn half_bits(x: f32) -> u32 {
    const MIN_NORMAL: f32 = 6.1035156e-5;
    if x < MIN_NORMAL {
        return u32(round(x * 16777216.0));
    }
    let bits = bitcast<u32>(x);
    // Exponents of f32 have a bias of 127, of f16 one of 15.
    return ((bits + 0xfffu + ((bits >> 13u) & 1u)) >> 13u) - (112u << 10u);
}

fn is_usable_caster(caster: Caster) -> bool {
    if !is_of_set(caster.material) {
        return false;
    }
    let brightest = select(1.0, MAX_GAIN, materials[caster.material].transfer == TRANSFER_GAIN);
    return is_finite(caster.radius) && caster.radius > 0.0 && is_finite(caster.rotation)
        && is_within(caster.color.a, 0.0, 1.0)
        && is_position(caster.center) && is_color(caster.color.rgb, brightest);
}

// load: casters in the host's buffers -> records as if they had been uploaded, and a box around each group.
// One invocation per caster, a workgroup per group. Invalid casters are counted; valid ones are compacted, in
// order.
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
        taken = is_usable_caster(caster);
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
        casters[load_params.first_caster + group * CHUNK_SIZE + slot.x] = packed_caster(caster);
    }
    store_group(group, lane, slot.y);
}
