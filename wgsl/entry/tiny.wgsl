// accumulate, tiny: particles of at most 2x2 texels, added straight to the sums. One invocation per
// footprint; workgroups stride over the chunks, so few that the invocations in flight on one texel cannot
// wrap its sum. CPU reference: crates/gobo-reference/src/accumulate.rs. Rust: src/stage/accumulate.rs.

import package::bind::changed::counters;
import package::bind::read::chunks;
import package::bind::sampled::rects;
import package::bind::uniform::{project_params, views};
import package::records::batch::Chunk;
import package::records::footprint::load_footprint;
import package::records::record::record_texel;
import package::records::tile::{is_scattered, scatter_texel};
import package::sums::scatter::scatter;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn accumulate_tiny(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    var scattered = 0u;
    for (var i = workgroup.x; i < project_params.chunk_count; i += workgroups.x) {
        scattered += scatter_particle(chunks[i], lane);
    }
    if scattered > 0u {
        atomicAdd(&counters.scattered, scattered);
    }
}

// Number of particles that were scattered: one or none.
fn scatter_particle(chunk: Chunk, lane: u32) -> u32 {
    let index = chunk.first_footprint + lane;
    let rect = textureLoad(rects, record_texel(index), 0).rg;
    if lane >= chunk.count || !is_scattered(rect) {
        return 0u;
    }
    let view = views[chunk.view];
    let footprint = load_footprint(index);
    let first = vec2<i32>(scatter_texel(footprint.bounds.xy));
    for (var i = 0; i < 4; i += 1) {
        let texel = first + vec2(i & 1, i >> 1u);
        if all(texel >= vec2(0)) && all(texel < vec2<i32>(view.size)) {
            scatter(view, footprint, vec2<u32>(texel));
        }
    }
    return 1u;
}
