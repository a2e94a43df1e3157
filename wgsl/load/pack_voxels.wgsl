// load: voxels of a host's grid -> the slots of its bricks in `voxels`. A workgroup per brick; an empty brick
// is not written. Densities out of range are counted and taken as 0. Rust: src/stage/load.rs.

import package::bind::changed::{brick_states, host_groups};
import package::bind::stored::voxels;
import package::bind::uniform::host_grid;
import package::load::group::is_within;
import package::load::load_casters::half_bits;
import package::records::batch::workgroup_number;
import package::records::brick::{SLOT_HEIGHT, SLOT_WIDTH};
import choice::loader::load_density;

override WORKGROUP_SIZE: u32;

const BRICK_VALUES: u32 = 729u; // SLOT_WIDTH along each axis
const SLOT_TEXELS: u32 = 576u;
const MAX_DENSITY: f32 = 65504.0; // of a half

var<workgroup> densities: array<f32, BRICK_VALUES>;
var<workgroup> is_filled: atomic<u32>;
var<workgroup> left_out: atomic<u32>;

// Coordinates of element `index` in an array of `size`.
fn coordinates_of(index: u32, size: vec2<u32>) -> vec3<u32> {
    return vec3(index % size.x, index / size.x % size.y, index / (size.x * size.y));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn pack_voxels(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let brick = workgroup_number(workgroup, workgroups);
    if brick >= host_grid.brick_count {
        return;
    }
    // The first bricks along each axis have the cells before voxel 0.
    let low = (vec3<i32>(coordinates_of(brick, host_grid.bricks)) - 1) * i32(SLOT_HEIGHT);
    for (var i = lane; i < BRICK_VALUES; i += WORKGROUP_SIZE) {
        let in_brick = coordinates_of(i, vec2(SLOT_WIDTH));
        let voxel = low + vec3<i32>(in_brick);
        var density = 0.0;
        if all(voxel >= vec3(0)) && all(voxel < vec3<i32>(host_grid.size)) {
            let found = load_density(vec3<u32>(voxel));
            if is_within(found, 0.0, MAX_DENSITY) {
                // Rounded as on the CPU: stores of halves may round otherwise.
                density = unpack2x16float(half_bits(found)).x;
            } else if all(in_brick < vec3(SLOT_HEIGHT)) {
                atomicAdd(&left_out, 1u);
            }
        }
        densities[i] = density;
        if density > 0.0 {
            atomicOr(&is_filled, 1u);
        }
    }
    workgroupBarrier(); // all densities before any is read
    let filled = atomicLoad(&is_filled);
    if lane == 0u {
        brick_states[brick] = filled;
        atomicAdd(&host_groups.counters.skipped, atomicLoad(&left_out));
    }
    if filled == 0u {
        return;
    }
    let slot = vec3(SLOT_WIDTH, SLOT_HEIGHT, SLOT_HEIGHT)
        * coordinates_of(host_grid.first_slot + brick, host_grid.slots);
    for (var i = lane; i < SLOT_TEXELS; i += WORKGROUP_SIZE) {
        let in_brick = coordinates_of(i, vec2(SLOT_WIDTH, SLOT_HEIGHT));
        let at = in_brick.x + SLOT_WIDTH * (in_brick.y + SLOT_WIDTH * in_brick.z);
        let layer = at + SLOT_WIDTH * SLOT_WIDTH;
        let four = vec4(
            densities[at],
            densities[at + SLOT_WIDTH],
            densities[layer],
            densities[layer + SLOT_WIDTH],
        );
        textureStore(voxels, slot + in_brick, four);
    }
}
