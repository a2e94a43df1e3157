// bloom, apply: spreads a share of the picture's light. One invocation per pixel. CPU reference:
// crates/gobo-reference/src/bloom.rs. Rust: crates/gobo-picture/src/stage/bloom.rs.

import package::bind::changed::pixels;
import package::bind::sampled::composited;
import package::bind::stored::radiance;
import package::bind::uniform::picture_params;
import package::bloom::bloom_level::enlarged;
import package::shade::tone::on_screen;

@compute @workgroup_size(8, 8)
fn bloom_apply(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(composited);
    if any(id.xy >= size) {
        return;
    }
    let sharp = textureLoad(composited, id.xy, 0);
    let light = mix(sharp.rgb, enlarged(id.xy), picture_params.bloom);
    textureStore(radiance, id.xy, vec4(light, sharp.w));
    pixels[id.y * size.x + id.x] = on_screen(light);
}
