// bloom, up: a level with its share of all coarser ones. One invocation per texel. CPU reference:
// crates/gobo-reference/src/bloom.rs. Rust: crates/gobo-picture/src/stage/bloom.rs.

import package::bind::sampled::bloom_level;
import package::bind::stored::bloom_to;
import package::bloom::bloom_level::enlarged;

// Share of the coarser levels.
const BLOOM_SPREAD: f32 = 0.7;

@compute @workgroup_size(8, 8)
fn bloom_up(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(bloom_to)) {
        return;
    }
    let level = textureLoad(bloom_level, id.xy, 0).rgb;
    textureStore(bloom_to, id.xy, vec4(mix(level, enlarged(id.xy), BLOOM_SPREAD), 1.0));
}
