// shade, surfaces: what the camera sees of solid casters, lit through the shadow maps. One
// workgroup per tile, four pixels per invocation. CPU twin: src/reference/shade/mod.rs. Host:
// src/stage/shade.rs.

import package::bind::read::partials;
import package::bind::sampled::{casters, images, tiles};
import package::bind::stored::surfaces;
import package::bind::uniform::{materials, picture_params, views};
import package::features::{COUNT_COST, HAS_TEXTURES, HAS_TRIANGLES};
import package::hit::caster_hit::{triangle_uv, triangle_weights};
import package::hit::texture::sample_texture;
import package::records::light::cluster_lights;
import package::records::material::NO_TEXTURE;
import package::records::record::{TRIANGLE_BIT, record_texel};
import package::records::setup::setup_texel;
import package::records::tile::{interleaved, segment_count, tile_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::shade::air::air_at;
import package::shade::cost::{asked, walked};
import package::shade::receiver::set_receiver;
import package::shade::shading::{Surface, shade_solid, sky};
import package::shade::surface::{eye, triangle_surface, world_point};
import package::state::seen::{corner, nearest, seen, setup_of, start};
import package::walk::lane::{LANES, lane_texel, sum_index};
import choice::walk::walk;

fn shade(view: GpuView, pixel: vec2<f32>, depth: f32, id: u32, setup: u32) -> vec3<f32> {
    var surface: Surface;
    var emission: vec3<f32>;
    if HAS_TRIANGLES && (id & TRIANGLE_BIT) != 0u {
        let material = materials[setup_texel(setup, 4u).w];
        var albedo = material.tint.rgb;
        if HAS_TEXTURES && material.texture != NO_TEXTURE {
            let uv = triangle_uv(setup, triangle_weights(setup, pixel).xyz);
            albedo *= sample_texture(images, material.texture, material.texture_size, uv).rgb;
        }
        let triangle = id & ~TRIANGLE_BIT;
        set_receiver(material, setup_texel(setup, 6u).w);
        surface = triangle_surface(view, pixel, depth, triangle, setup, albedo, material.roughness);
        emission = material.emission;
    } else {
        let place = bitcast<vec4<f32>>(textureLoad(casters, record_texel(2u * id), 0));
        let look = textureLoad(casters, record_texel(2u * id + 1u), 0);
        let material = materials[look.z & 0xffffu];
        let albedo = material.tint.rgb * vec3(unpack2x16unorm(look.x), unpack2x16unorm(look.y).x);
        set_receiver(material, look.w);
        let point = world_point(view, pixel, depth);
        let to_eye = normalize(eye() - point);
        // Round, whatever way the disc faces.
        let aside = (point - place.xyz) / place.w;
        let normal = normalize(aside + to_eye * sqrt(max(1.0 - dot(aside, aside), 0.05)));
        let list = cluster_lights(pixel, depth);
        surface = Surface(point, normal, normal, to_eye, albedo, material.roughness, place.w, list);
        emission = material.emission;
    }
    return shade_solid(surface) + emission;
}

@compute @workgroup_size(LANES)
fn shade_surfaces(
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
    if tile.merged == 0u {
        walk(view, tile.first, tile.end);
    } else {
        let count = segment_count(tile);
        for (var k = 0u; k < 4u * count; k += 1u) {
            let i = k % 4u;
            let partial = partials[sum_index(tile.merged - 1u + k / 4u, place + vec2(0u, i))];
            walked += select(0u, partial.w, i == 0u);
            let depth = bitcast<f32>(partial.x);
            if depth < nearest[i] {
                nearest[i] = depth;
                seen[i] = partial.y;
                setup_of[i] = partial.z;
            }
        }
    }
    for (var i = 0u; i < 4u; i += 1u) {
        let at = corner + vec2(0.5, f32(i) + 0.5);
        if all(at < view.size) {
            asked = 0u;
            var color = sky(normalize(world_point(view, at, 1.0) - eye()));
            if nearest[i] < 1.0 {
                color = shade(view, at, nearest[i], seen[i], setup_of[i]);
            }
            if picture_params.air_slices > 0u {
                let before = air_at(at, nearest[i]);
                color = color * before.a + before.rgb;
            }
            if COUNT_COST {
                color = vec3(f32(walked), f32(asked), 0.0);
            }
            textureStore(surfaces, pixel + vec2(0u, i), vec4(color, nearest[i]));
        }
    }
}
