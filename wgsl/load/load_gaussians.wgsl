// load: Gaussians in the host's buffers -> records and axes as if they had been uploaded, and a box around
// each group. One invocation per Gaussian, a workgroup per group. Invalid Gaussians are counted; valid ones
// are compacted, in order. CPU reference: `Caster::of_gaussian` in src/records/gaussian.rs. Rust:
// src/stage/load.rs.

import package::bind::stored::casters;
import package::bind::uniform::{gaussian_looks, load_params, materials};
import package::load::group::{
    add_caster, caster_count, is_color, is_finite, is_of_set, is_position, is_within, slot_in_group,
    store_group,
};
import package::load::pack_gaussian::{gaussian_radius, most_opacity, packed_axes, packed_gaussian};
import package::records::dispatch::workgroup_number;
import package::records::host::{CHUNK_SIZE, MAX_COORDINATE, Gaussian};
import package::records::material::{MAX_GAIN, TRANSFER_GAIN};
import package::records::record::record_texel;
import choice::loader::load_gaussian;

const NOT_UNIT: f32 = 2e-4; // largest error of a unit quaternion's squared length

fn is_usable(gaussian: Gaussian) -> bool {
    if !is_of_set(gaussian.material) {
        return false;
    }
    let brightest = select(1.0, MAX_GAIN, materials[gaussian.material].transfer == TRANSFER_GAIN);
    let q = gaussian.rotation;
    var usable = is_position(gaussian.center) && is_color(gaussian.color, brightest);
    usable = usable && is_finite(q.x) && is_finite(q.y) && is_finite(q.z) && is_finite(q.w);
    usable = usable && abs(dot(q, q) - 1.0) <= NOT_UNIT;
    usable = usable && is_within(gaussian.opacity, 0.0, gaussian_looks[gaussian.material].most);
    for (var i = 0u; i < 3u; i += 1u) {
        usable = usable && is_within(gaussian.sigma[i], 0.0, MAX_COORDINATE) && gaussian.sigma[i] > 0.0;
    }
    return usable;
}

@compute @workgroup_size(CHUNK_SIZE)
fn load_gaussians(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let group = workgroup_number(workgroup, workgroups);
    if group >= load_params.group_count {
        return;
    }
    let index = group * CHUNK_SIZE + lane;
    var gaussian: Gaussian;
    var taken = false;
    var radius = 0.0;
    var opacity = 0.0;
    let is_there = index < caster_count();
    if is_there {
        gaussian = load_gaussian(index);
        taken = is_usable(gaussian);
    }
    if taken {
        opacity = most_opacity(gaussian);
        radius = gaussian_radius(gaussian, opacity);
    }
    add_caster(lane, taken, is_there && !taken, vec4(gaussian.center, radius), opacity);
    let slot = slot_in_group(lane);
    if taken {
        let loaded = group * CHUNK_SIZE + slot.x;
        let axes = load_params.first_axes + loaded;
        let texel = 2u * (load_params.first_caster + loaded);
        let center = vec4(bitcast<vec3<u32>>(gaussian.center), bitcast<u32>(radius));
        textureStore(casters, record_texel(texel), center);
        textureStore(casters, record_texel(texel + 1u), packed_gaussian(gaussian, axes));
        let packed = packed_axes(gaussian);
        textureStore(casters, record_texel(2u * axes), packed.rotation);
        textureStore(casters, record_texel(2u * axes + 1u), packed.sigma);
    }
    store_group(group, lane, slot.y);
}
