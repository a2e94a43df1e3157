// Gaussians of a host. CPU reference: `CasterRecord::of_gaussian` in src/records/gaussian.rs. Rust:
// `CasterRecord::of_gaussian` and `GaussianAxes` in src/records/gaussian.rs, src/stage/load.rs.

import package::bind::changed::casters;
import package::bind::uniform::{gaussian_looks, load_params, materials};
import package::load::group::{
    add_caster, caster_count, is_color, is_finite, is_of_set, is_position, is_within, slot_in_group,
    store_group,
};
import package::load::load_casters::{half_bits, packed_color};
import package::project::conic::reach_squared;
import package::records::batch::workgroup_number;
import package::records::caster::MEDIUM_BIT;
import package::records::host::{CHUNK_SIZE, Gaussian, MAX_COORDINATE};
import package::records::material::{MAX_GAIN, TRANSFER_GAIN};
import package::records::record::{CasterRecord, OPACITY_SCALE};
import choice::loader::load_gaussian;

// Packs a host's Gaussian into the records that its upload would make: bit for bit, but for the radius where
// its quaternion has unit length only up to rounding.

const ROOT_TAU: f32 = 2.5066283;
const UNIT_ROUNDING: f32 = 1e-6; // of a unit quaternion's squared length
const RADIUS_SLACK: f32 = 1.0001; // rounding of a logarithm and a root

fn is_medium(gaussian: Gaussian) -> bool {
    return (gaussian_looks[gaussian.material].marks & MEDIUM_BIT) != 0u;
}

// Opacity of a Gaussian, or a medium's optical depth along its longest axis.
fn most_opacity(gaussian: Gaussian) -> f32 {
    let longest = max(max(gaussian.sigma.x, gaussian.sigma.y), gaussian.sigma.z);
    let of_medium = gaussian_looks[gaussian.material].density * longest * ROOT_TAU;
    return gaussian.opacity * select(1.0, of_medium, is_medium(gaussian));
}

// Radius of a sphere around the Gaussian [m].
fn gaussian_radius(gaussian: Gaussian, opacity: f32) -> f32 {
    let longest = max(max(gaussian.sigma.x, gaussian.sigma.y), gaussian.sigma.z);
    return longest * sqrt(reach_squared(opacity)) * RADIUS_SLACK;
}

// `axes`: record of its axes.
fn packed_gaussian(gaussian: Gaussian, radius: f32, axes: u32) -> CasterRecord {
    let look = gaussian_looks[gaussian.material];
    let levels = packed_color(gaussian.color, gaussian.material);
    let scale = select(OPACITY_SCALE, look.density, is_medium(gaussian));
    return CasterRecord(
        gaussian.center,
        radius,
        levels.r | (levels.g << 16u),
        levels.b | (half_bits(gaussian.opacity * scale) << 16u),
        gaussian.material | look.marks,
        axes,
    );
}

// As a particle's record.
fn packed_axes(gaussian: Gaussian) -> CasterRecord {
    let squared = dot(gaussian.rotation, gaussian.rotation);
    let step = select(1.0, 1.5 - 0.5 * squared, abs(squared - 1.0) > UNIT_ROUNDING);
    let unit = gaussian.rotation * step;
    let sigma = bitcast<vec3<u32>>(gaussian.sigma);
    return CasterRecord(unit.xyz, unit.w, sigma.x, sigma.y, sigma.z, gaussian.id);
}

const NOT_UNIT: f32 = 2e-4; // largest error of a unit quaternion's squared length

fn is_usable_gaussian(gaussian: Gaussian) -> bool {
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

// load: Gaussians in the host's buffers -> records and axes as if they had been uploaded, and a box around
// each group. One invocation per Gaussian, a workgroup per group. Invalid Gaussians are counted; valid ones
// are compacted, in order.
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
        taken = is_usable_gaussian(gaussian);
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
        let own = packed_gaussian(gaussian, radius, load_params.first_record + axes);
        casters[load_params.first_caster + loaded] = own;
        casters[axes] = packed_axes(gaussian);
    }
    store_group(group, lane, slot.y);
}
