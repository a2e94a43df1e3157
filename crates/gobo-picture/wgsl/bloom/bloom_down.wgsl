// bloom, down: the next level. One invocation per texel of it. CPU reference:
// crates/gobo-reference/src/bloom.rs. Rust: crates/gobo-picture/src/stage/bloom.rs.

import package::bind::stored::bloom_to;
import package::bind::sampled::bloom_from;
import package::bloom::bloom_level::from_level;

// Most light of a texel: levels are halves.
const MAX_BLOOM: f32 = 65504.0;

@compute @workgroup_size(8, 8)
fn bloom_down(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(bloom_to)) {
        return;
    }
    let last = vec2<i32>(textureDimensions(bloom_from)) - 1;
    let first = vec2<i32>(id.xy * 2u) - 1;
    var sum = vec3(0.0);
    for (var i = 0; i < 16; i += 1) {
        let step = vec2(i & 3, i >> 2u);
        let inner = select(vec2(1.0), vec2(3.0), step == clamp(step, vec2(1), vec2(2)));
        let texel = clamp(first + step, vec2(0), last);
        sum += min(from_level(texel), vec3(MAX_BLOOM)) * (inner.x * inner.y / 64.0);
    }
    textureStore(bloom_to, id.xy, vec4(sum, 1.0));
}
