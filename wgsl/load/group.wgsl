// A workgroup of `load`: a run of the host's casters. The valid ones are compacted, in order, with a box
// around them. Every lane adds its caster, then asks for its slot, then the group is stored.

import package::bind::changed::host_groups;
import package::bind::read::host_counts;
import package::bind::uniform::load_params;
import package::records::host::{CHUNK_SIZE, MAX_COORDINATE, HostGroup};

const STRETCH: u32 = 16u; // spheres per invocation when the box is computed

var<workgroup> spheres: array<vec4<f32>, CHUNK_SIZE>;
var<workgroup> alphas: array<f32, CHUNK_SIZE>;
var<workgroup> taken_bits: array<atomic<u32>, CHUNK_SIZE / 32u>;
var<workgroup> left_out: atomic<u32>;
var<workgroup> lows: array<vec3<f32>, CHUNK_SIZE / STRETCH>;
var<workgroup> highs: array<vec3<f32>, CHUNK_SIZE / STRETCH>;
var<workgroup> faintest: array<f32, CHUNK_SIZE / STRETCH>;

// Compilers may assume that floats are finite, but not that bits are.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) < 0x7f800000u;
}

fn is_within(x: f32, low: f32, high: f32) -> bool {
    return is_finite(x) && x >= low && x <= high;
}

fn is_position(slot: vec3<f32>) -> bool {
    var is_near = true;
    for (var i = 0u; i < 3u; i += 1u) {
        is_near = is_near && is_within(slot[i], -MAX_COORDINATE, MAX_COORDINATE);
    }
    return is_near;
}

fn is_color(color: vec3<f32>, brightest: f32) -> bool {
    var is_one = true;
    for (var i = 0u; i < 3u; i += 1u) {
        is_one = is_one && is_within(color[i], 0.0, brightest);
    }
    return is_one;
}

// Whether the set may use the material.
fn is_of_set(material: u32) -> bool {
    let bits = load_params.materials[min(material / 128u, 3u)][(material / 32u) % 4u];
    return material < 512u && ((bits >> (material % 32u)) & 1u) == 1u;
}

// Number of casters that the set has now.
fn caster_count() -> u32 {
    let counted = min(host_counts[load_params.count_index], load_params.capacity);
    return select(load_params.capacity, counted, load_params.is_counted == 1u);
}

// `sphere`: around the caster, if the caster is valid.
fn add_caster(lane: u32, is_valid: bool, is_left_out: bool, sphere: vec4<f32>, alpha: f32) {
    spheres[lane] = select(vec4(0.0, 0.0, 0.0, -1.0), sphere, is_valid);
    alphas[lane] = select(1.0, alpha, is_valid);
    if is_valid {
        atomicOr(&taken_bits[lane / 32u], 1u << (lane % 32u));
    }
    if is_left_out {
        atomicAdd(&left_out, 1u);
    }
}

// Number of valid casters before the lane's own, and of all. Called by all lanes.
fn slot_in_group(lane: u32) -> vec2<u32> {
    workgroupBarrier(); // all spheres and bits before any is read
    var slot = vec2(0u);
    for (var word = 0u; word < CHUNK_SIZE / 32u; word += 1u) {
        let bits = atomicLoad(&taken_bits[word]);
        let below = select(0u, 0xffffffffu, word < lane / 32u)
            | select(0u, (1u << (lane % 32u)) - 1u, word == lane / 32u);
        slot += vec2(countOneBits(bits & below), countOneBits(bits));
    }
    return slot;
}

// Called by all lanes, after `slot_in_group`.
fn store_group(group: u32, lane: u32, count: u32) {
    var low = vec3(3e38);
    var high = vec3(-3e38);
    var faint = 1.0;
    if lane < CHUNK_SIZE / STRETCH {
        for (var i = 0u; i < STRETCH; i += 1u) {
            let sphere = spheres[lane * STRETCH + i];
            let is_there = sphere.w >= 0.0;
            low = select(low, min(low, sphere.xyz - sphere.w), is_there);
            high = select(high, max(high, sphere.xyz + sphere.w), is_there);
            faint = min(faint, alphas[lane * STRETCH + i]);
        }
        lows[lane] = low;
        highs[lane] = high;
        faintest[lane] = faint;
    }
    workgroupBarrier(); // all boxes before they are joined
    if lane == 0u {
        for (var i = 1u; i < CHUNK_SIZE / STRETCH; i += 1u) {
            low = min(low, lows[i]);
            high = max(high, highs[i]);
            faint = min(faint, faintest[i]);
        }
        host_groups.groups[load_params.first_group + group] = HostGroup(low, count, high, faint);
        atomicAdd(&host_groups.counters.taken, count);
        atomicAdd(&host_groups.counters.skipped, atomicLoad(&left_out));
    }
}
