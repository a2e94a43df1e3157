// mask, shrink: of each 2 x 2 pixels one, in turns the nearest and the farthest, so that of two surfaces that
// meet there both are among four neighbours. CPU twin: src/reference/mask.rs. Host: src/stage/mask.rs.

import package::bind::sampled::mask_surfaces;
import package::bind::stored::new_surfaces;
import package::bind::uniform::mask_params;

@compute @workgroup_size(8, 8)
fn mask_shrink(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    let last = textureDimensions(mask_surfaces) - 1u;
    let is_near = ((id.x + id.y) & 1u) == 0u;
    var chosen = vec4(0u);
    var best = 0.0;
    for (var i = 0u; i < 4u; i += 1u) {
        let offset = min(id.xy * 2u + vec2(i & 1u, i >> 1u), last) - id.xy * 2u;
        let texel = textureLoad(mask_surfaces, id.xy * 2u + offset, 0);
        let depth = bitcast<f32>(texel.x);
        // What is nothing is no surface that is far.
        let rank = select(select(depth, 1.0 - depth, is_near), -1.0, depth >= 1.0);
        let is_better = i == 0u || rank > best;
        let own = vec4(texel.xyz, texel.w | (offset.x << 3u) | (offset.y << 4u));
        chosen = select(chosen, own, is_better);
        best = select(best, rank, is_better);
    }
    textureStore(new_surfaces, id.xy, chosen);
}
