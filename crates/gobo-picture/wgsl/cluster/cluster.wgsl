// cluster: lists of lights for cells of the camera's frustum. CPU reference:
// crates/gobo-reference/src/cluster.rs. Rust: crates/gobo-picture/src/stage/cluster.rs.

import package::bind::picture_in::{cells, cluster_params, reaches};
import package::bind::picture_out::{cluster_counters, masks, offsets};
import package::records::light::ALL_LIGHTS;
import package::records::picture::REACH_TEXELS;
import package::records::record::{bounded, record_texel};

override WORKGROUP_SIZE: u32;

const UNIT: f32 = 8192.0; // fixed-point scale of offsets (in radii) and of normals

// Low and high end of a cell: slopes, or depths.
fn cell(index: u32) -> vec2<f32> {
    return textureLoad(cells, record_texel(index), 0).rg;
}

// Whether the whole box from `low` to `high` is beyond the plane: even its least product with the normal.
fn is_beyond(xy: u32, zw: u32, low: vec3<i32>, high: vec3<i32>) -> bool {
    let plane = (vec4<i32>(vec4(xy << 16u, xy, zw << 16u, zw))) >> vec4(16u);
    let nearest = select(high, low, plane.xyz >= vec3(0));
    let product = plane.xyz * nearest;
    return product.x + product.y + product.z > plane.w * i32(UNIT);
}

// Conservative test. The decision is in integers, so that devices that fuse operations decide alike.
fn reaches_box(light: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
    let sphere = bitcast<vec4<f32>>(textureLoad(reaches, record_texel(light * REACH_TEXELS), 0));
    if sphere.w == 0.0 {
        return true;
    }
    // The box in radii, from the light.
    let lo = clamp((low - sphere.xyz) * sphere.w, vec3(-2.0), vec3(2.0));
    let hi = clamp((high - sphere.xyz) * sphere.w, vec3(-2.0), vec3(2.0));
    let apart = vec3<i32>(max(max(lo, -hi), vec3(0.0)) * UNIT);
    let square = apart * apart;
    if square.x + square.y + square.z > i32(UNIT * UNIT) {
        return false;
    }
    let first = textureLoad(reaches, record_texel(light * REACH_TEXELS + 1u), 0);
    if all(first == vec4(0u)) {
        return true;
    }
    // The part of the box in the cube around the sphere.
    let a = vec3<i32>(floor(max(lo, vec3(-1.0)) * UNIT));
    let b = vec3<i32>(ceil(min(hi, vec3(1.0)) * UNIT));
    let second = textureLoad(reaches, record_texel(light * REACH_TEXELS + 2u), 0);
    let third = textureLoad(reaches, record_texel(light * REACH_TEXELS + 3u), 0);
    return !(is_beyond(first.x, first.y, a, b) || is_beyond(first.z, first.w, a, b)
        || is_beyond(second.x, second.y, a, b) || is_beyond(second.z, second.w, a, b)
        || is_beyond(third.x, third.y, a, b) || is_beyond(third.z, third.w, a, b));
}

// cluster, count: lights that reach each cluster, as bits, and their number. One invocation per cluster.
@compute @workgroup_size(WORKGROUP_SIZE)
fn cluster_count(@builtin(global_invocation_id) id: vec3<u32>) {
    let cluster = id.x;
    if cluster >= cluster_params.cluster_count {
        return;
    }
    let width = cluster_params.cells.x;
    let height = cluster_params.cells.y;
    let x = cell(cluster % width);
    let y = cell(width + cluster / width % height);
    let z = cell(width + height + cluster / (width * height));
    let low = vec3(min(x.x * z.x, x.x * z.y), min(y.x * z.x, y.x * z.y), z.x);
    let high = vec3(max(x.y * z.x, x.y * z.y), max(y.y * z.x, y.y * z.y), z.y);
    var count = 0u;
    let word_count = bounded(cluster_params.word_count, textureDimensions(masks));
    let light_count = bounded(cluster_params.light_count, textureDimensions(reaches));
    for (var word = 0u; word < word_count; word += 1u) {
        let first = word * 32u;
        let end = min(light_count - first, 32u);
        var bits = 0u;
        for (var i = 0u; i < end; i += 1u) {
            bits |= select(0u, 1u << i, reaches_box(first + i, low, high));
        }
        textureStore(masks, record_texel(cluster * cluster_params.word_count + word), vec4(bits));
        count += countOneBits(bits);
    }
    offsets[cluster] = count;
}

var<workgroup> sums: array<u32, WORKGROUP_SIZE>;

// cluster, scan: exclusive prefix sum of the clusters' light counts, in place; ALL_LIGHTS for clusters whose
// list does not fit. One workgroup: every invocation adds up some consecutive clusters, and their sums are
// scanned in workgroup memory.
@compute @workgroup_size(WORKGROUP_SIZE)
fn cluster_scan(@builtin(local_invocation_index) lane: u32) {
    let stretch = (cluster_params.cluster_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let first = min(lane * stretch, cluster_params.cluster_count);
    let end = min(first + stretch, cluster_params.cluster_count);
    var sum = 0u;
    var longest = 0u;
    for (var cluster = first; cluster < end; cluster += 1u) {
        sum += offsets[cluster];
        longest = max(longest, offsets[cluster]);
    }
    sums[lane] = sum;
    workgroupBarrier(); // every sum before any is read
    var offset = 0u;
    for (var before = 0u; before < lane; before += 1u) {
        offset += sums[before];
    }
    var overflowed = 0u;
    for (var cluster = first; cluster < end; cluster += 1u) {
        let count = offsets[cluster];
        let fits = offset + count <= cluster_params.capacity;
        offsets[cluster] = select(ALL_LIGHTS, offset, fits);
        overflowed += select(1u, 0u, fits);
        offset += count;
    }
    atomicAdd(&cluster_counters.overflowed, overflowed);
    atomicMax(&cluster_counters.longest, longest);
    if lane == WORKGROUP_SIZE - 1u {
        atomicStore(&cluster_counters.needed, offset);
    }
}
