// shade, composite: what is not solid over what is, and the whole to the screen. One workgroup per
// tile, four pixels per invocation. CPU twin: src/reference/shade/mod.rs. Host: src/stage/shade.rs.

import package::bind::changed::pixels;
import package::bind::read::partials;
import package::bind::sampled::{surfaces, tiles};
import package::bind::uniform::{picture_params, views};
import package::features::COUNT_COST;
import package::records::record::record_texel;
import package::records::tile::{interleaved, segment_count, tile_of};
import package::records::view::TILE_SIZE;
import package::shade::cost::walked;
import package::shade::fog::whole;
import package::shade::tone::{to_srgb, tone_mapped};
import package::state::layers::{asked_of, color, finish, lay, passed, start};
import package::walk::lane::{LANES, lane_texel, sum_index};
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn shade_composite(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile_id = interleaved(workgroup, workgroups);
    let tile = tile_of(textureLoad(tiles, record_texel(tile_id), 0));
    let view = views[0];
    let place = lane_texel(lane);
    let pixel = tile.place * TILE_SIZE + place;
    start(view, pixel);
    whole = true;
    if tile.merged == 0u {
        walk(view, tile.first, tile.end);
        finish(view);
    } else {
        let count = segment_count(tile);
        for (var k = 0u; k < 4u * count; k += 1u) {
            let i = k % 4u;
            let partial = partials[sum_index(tile.merged - 1u + k / 4u, place + vec2(0u, i))];
            walked += select(0u, partial.w & 0xffffu, i == 0u);
            asked_of[i] += partial.w >> 16u;
            let middle = unpack2x16float(partial.y);
            lay(
                i,
                vec3(unpack2x16float(partial.x), middle.x),
                vec3(middle.y, unpack2x16float(partial.z)),
            );
        }
    }
    let size = vec2<u32>(view.size);
    let words = picture_params.pixel_words;
    for (var i = 0u; i < 4u; i += 1u) {
        let at = pixel + vec2(0u, i);
        if all(at < size) {
            let surface = textureLoad(surfaces, at, 0).rgb;
            let light = color[i] + passed[i] * surface;
            let seen = light * picture_params.exposure;
            var shown = pack4x8unorm(vec4(to_srgb(tone_mapped(seen)), 1.0));
            if COUNT_COST {
                let cost = min(vec2(walked, asked_of[i]) + vec2<u32>(surface.rg), vec2(0xffffu));
                shown = cost.x | (cost.y << 16u);
            }
            // Pixels of one word keep the last that is written, without a branch on a uniform.
            let word = (at.y * size.x + at.x) * words;
            let half = min(light, vec3(65504.0));
            pixels[word + min(2u, words - 1u)] = pack2x16float(half.bb);
            pixels[word + min(1u, words - 1u)] = pack2x16float(half.rg);
            pixels[word] = shown;
        }
    }
}
