// cluster, emit: `clusters`, first two texels per cluster with start and length of its list, then the lists:
// indices of lights, ascending. One invocation per cluster. CPU reference:
// crates/gobo-reference/src/cluster.rs. Rust: crates/gobo-picture/src/stage/cluster.rs.

import package::bind::picture_in::{cluster_params, masks};
import package::bind::picture_out::{clusters, offsets};
import package::records::light::ALL_LIGHTS;
import package::records::record::{bounded, record_texel};

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn cluster_emit(@builtin(global_invocation_id) id: vec3<u32>) {
    let cluster = id.x;
    if cluster >= cluster_params.cluster_count {
        return;
    }
    let offset = offsets[cluster];
    let fits = offset != ALL_LIGHTS;
    let first = 2u * cluster_params.cluster_count + offset;
    var count = 0u;
    let word_count = bounded(cluster_params.word_count, textureDimensions(masks));
    for (var word = 0u; word < word_count; word += 1u) {
        var bits = textureLoad(masks, record_texel(cluster * cluster_params.word_count + word), 0).r;
        while fits && bits != 0u {
            let light = word * 32u + firstTrailingBit(bits);
            bits &= bits - 1u;
            textureStore(clusters, record_texel(first + count), vec4(light));
            count += 1u;
        }
    }
    textureStore(clusters, record_texel(2u * cluster), vec4(select(ALL_LIGHTS, first, fits)));
    textureStore(
        clusters,
        record_texel(2u * cluster + 1u),
        vec4(select(cluster_params.light_count, count, fits)),
    );
}
