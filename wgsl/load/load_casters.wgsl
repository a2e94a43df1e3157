// load: casters in the host's buffers -> records as if they had been uploaded, and a box around each group.
// One invocation per caster, a workgroup per group. Invalid casters are counted; valid ones are compacted,
// in order. CPU reference: `Caster::new` in src/records/caster.rs. Rust: src/stage/load.rs.

import package::bind::changed::{host_counters, host_groups};
import package::bind::read::host_counts;
import package::bind::stored::casters;
import package::bind::uniform::{load_params, materials};
import package::load::pack_caster::{packed_look, packed_place};
import package::records::dispatch::workgroup_number;
import package::records::host::{CHUNK_SIZE, Caster, FARTHEST_PLACE, HostGroup};
import package::records::material::{MAX_GAIN, SHAPE_QUAD, TRANSFER_GAIN};
import package::records::record::record_texel;
import choice::loader::load_caster;

const STRETCH: u32 = 16u; // spheres whose box an invocation computes

var<workgroup> spheres: array<vec4<f32>, CHUNK_SIZE>;
var<workgroup> alphas: array<f32, CHUNK_SIZE>;
var<workgroup> taken_bits: array<atomic<u32>, CHUNK_SIZE / 32u>;
var<workgroup> left_out: atomic<u32>;
var<workgroup> lows: array<vec3<f32>, CHUNK_SIZE / STRETCH>;
var<workgroup> highs: array<vec3<f32>, CHUNK_SIZE / STRETCH>;
var<workgroup> faintest: array<f32, CHUNK_SIZE / STRETCH>;

// Compilers may assume that floats are finite, but not so of bits.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) < 0x7f800000u;
}

fn is_within(x: f32, low: f32, high: f32) -> bool {
    return is_finite(x) && x >= low && x <= high;
}

fn is_usable(caster: Caster) -> bool {
    let bits = load_params.materials[min(caster.material / 128u, 3u)][(caster.material / 32u) % 4u];
    if caster.material >= 512u || ((bits >> (caster.material % 32u)) & 1u) == 0u {
        return false;
    }
    let brightest = select(1.0, MAX_GAIN, materials[caster.material].transfer == TRANSFER_GAIN);
    var usable = is_finite(caster.radius) && caster.radius > 0.0 && is_finite(caster.rotation);
    usable = usable && is_within(caster.color.a, 0.0, 1.0);
    for (var i = 0u; i < 3u; i += 1u) {
        usable = usable && is_within(caster.center[i], -FARTHEST_PLACE, FARTHEST_PLACE);
        usable = usable && is_within(caster.color[i], 0.0, brightest);
    }
    return usable;
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
    let counted = min(host_counts[load_params.count_index], load_params.capacity);
    let count = select(load_params.capacity, counted, load_params.is_counted == 1u);
    var caster: Caster;
    var taken = false;
    if index < count {
        caster = load_caster(index);
        taken = is_usable(caster);
        let is_there = (load_params.may_be_none == 0u) | (caster.radius != 0.0);
        if is_there && !taken {
            atomicAdd(&left_out, 1u);
        }
    }
    spheres[lane] = vec4(0.0, 0.0, 0.0, -1.0);
    alphas[lane] = 1.0;
    if taken {
        let is_quad = materials[caster.material].shape == SHAPE_QUAD;
        spheres[lane] = vec4(caster.center, caster.radius * select(1.0, load_params.quad_reach, is_quad));
        alphas[lane] = caster.color.a;
        atomicOr(&taken_bits[lane / 32u], 1u << (lane % 32u));
    }
    workgroupBarrier(); // all spheres and bits before any is read
    var before = 0u;
    var all = 0u;
    for (var word = 0u; word < CHUNK_SIZE / 32u; word += 1u) {
        let bits = atomicLoad(&taken_bits[word]);
        let below = select(0u, 0xffffffffu, word < lane / 32u) | select(0u, (1u << (lane % 32u)) - 1u, word == lane / 32u);
        before += countOneBits(bits & below);
        all += countOneBits(bits);
    }
    if taken {
        let texel = 2u * (load_params.first_caster + group * CHUNK_SIZE + before);
        textureStore(casters, record_texel(texel), packed_place(caster));
        textureStore(casters, record_texel(texel + 1u), packed_look(caster));
    }
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
    workgroupBarrier(); // all boxes before they are put together
    if lane == 0u {
        for (var i = 1u; i < CHUNK_SIZE / STRETCH; i += 1u) {
            low = min(low, lows[i]);
            high = max(high, highs[i]);
            faint = min(faint, faintest[i]);
        }
        host_groups[load_params.first_group + group] = HostGroup(low, all, high, faint);
        atomicAdd(&host_counters.taken, all);
        atomicAdd(&host_counters.skipped, atomicLoad(&left_out));
    }
}
