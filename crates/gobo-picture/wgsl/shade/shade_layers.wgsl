// shade, layers: translucent layers of each pixel of a band; one workgroup per tile that has translucent
// casters, one invocation per pixel. Light L behind the layers becomes colour + passed * L. A long tile takes
// several rounds, each of which continues the one before. CPU reference:
// crates/gobo-reference/src/shade/mod.rs. Rust: crates/gobo-picture/src/stage/shade.rs.

import package::accumulator::layers::{Waiting, color, far, finish, near, pane_count, passed, start};
import package::bind::picture_in::{band, layered_tiles, seen_pixels};
import package::bind::picture_out::{carried, layers};
import package::features::{HAS_REFRACTION, HAS_TRIANGLES, HAS_VOLUMES};
import package::records::record::record_texel;
import package::shade::band::{ROUND_LENGTH, tile_pixel};
import package::shade::bend::{aside, bent, bent_by, blur_square, entered};
import package::shade::camera::{camera, inside, reached, walked};
import package::shade::layer::{LAYERED_HEAD, LAYER_TEXELS};
import package::traversal::lane::LANES;
import choice::records::tile_at;
import choice::traversal::walk;

const CARRIED: u32 = 6u; // records of a pixel

fn go_on(index: u32) {
    let at = index * CARRIED;
    let front = carried[at];
    let behind = carried[at + 1u];
    color = bitcast<vec3<f32>>(front.xyz);
    walked = front.w;
    passed = bitcast<vec3<f32>>(behind.xyz);
    if HAS_TRIANGLES {
        let waiting = carried[at + 2u];
        near = Waiting(bitcast<f32>(waiting.x), waiting.y);
        far = Waiting(bitcast<f32>(waiting.z), waiting.w);
        pane_count = behind.w;
    }
    if HAS_VOLUMES {
        let fog = bitcast<vec4<f32>>(carried[at + 3u]);
        inside = fog.xyz;
        reached = fog.w;
    }
    if HAS_REFRACTION {
        let kept = bitcast<vec4<f32>>(carried[at + 4u]);
        let inside = bitcast<vec4<f32>>(carried[at + 5u]);
        aside = kept.xy;
        blur_square = kept.z;
        bent = inside.xyz;
        entered = inside.w;
    }
}

fn carry(index: u32) {
    let at = index * CARRIED;
    carried[at] = vec4(bitcast<vec3<u32>>(color), walked);
    carried[at + 1u] = vec4(bitcast<vec3<u32>>(passed), pane_count);
    if HAS_TRIANGLES {
        carried[at + 2u] = vec4(bitcast<u32>(near.depth), near.setup, bitcast<u32>(far.depth), far.setup);
    }
    if HAS_VOLUMES {
        carried[at + 3u] = bitcast<vec4<u32>>(vec4(inside, reached));
    }
    if HAS_REFRACTION {
        carried[at + 4u] = bitcast<vec4<u32>>(vec4(aside, blur_square, 0.0));
        carried[at + 5u] = bitcast<vec4<u32>>(vec4(bent, entered));
    }
}

@compute @workgroup_size(LANES)
fn shade_layers(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = camera();
    let at = tile_pixel(layered_tiles[LAYERED_HEAD + workgroup.x], lane, view.tiles_x);
    let tile = tile_at(at.tile);
    let first = tile.first + band.round * ROUND_LENGTH;
    let goes_on = first > tile.first;
    if goes_on && first >= tile.end {
        return;
    }
    let depth = bitcast<f32>(textureLoad(seen_pixels, record_texel(at.index), 0).x);
    start(view, at.pixel, at.index, depth);
    if goes_on {
        go_on(at.index);
    }
    let end = min(first + ROUND_LENGTH, tile.end);
    walk(view, first, end);
    if end < tile.end {
        carry(at.index);
        return;
    }
    finish(view);
    let texel = at.index * LAYER_TEXELS;
    textureStore(layers, record_texel(texel), vec4(bitcast<vec3<u32>>(color), walked));
    textureStore(layers, record_texel(texel + 1u), vec4(bitcast<vec3<u32>>(passed), 0u));
    if HAS_REFRACTION {
        let pixel = vec2<f32>(at.pixel) + 0.5;
        textureStore(layers, record_texel(texel + 4u), bent_by(view, pixel, depth));
    }
}
