// Area lights and the levels of their shadow views: records of `lights`, behind the views. Rust:
// src/records/area.rs.

import package::bind::sampled::{levels, lights};
import package::bind::uniform::picture_params;
import package::records::light::{AREA_MASK, AREA_SHIFT, GpuLight};
import package::records::record::record_texel;
import package::records::view::GpuView;

struct GpuArea {
    right: vec3<f32>,   // half axes of a part of the source, world space [m]; for a sun, x is a slope
    kind: u32,
    up: vec3<f32>,
    first_leveled: u32, // index of the light's first view among the leveled views
}

const AREA_SPHERE: u32 = 0u;
const AREA_FLAT: u32 = 1u;
const AREA_SUN: u32 = 2u;
const MAX_AREAS: u32 = 64u;
const AREA_TEXELS: u32 = 2u;
const LEVELED_TEXELS: u32 = 4u;
const BLOCK_TEXELS: u32 = 2u;
const SKIRT: u32 = 3u; // blocks around a level

fn has_area(light: GpuLight) -> bool {
    return ((light.traits >> AREA_SHIFT) & AREA_MASK) != 0u;
}

fn area_of(light: GpuLight) -> GpuArea {
    let at = picture_params.first_area + (((light.traits >> AREA_SHIFT) & AREA_MASK) - 1u) * AREA_TEXELS;
    let right = textureLoad(lights, record_texel(at), 0);
    let up = textureLoad(lights, record_texel(at + 1u), 0);
    return GpuArea(bitcast<vec3<f32>>(right.xyz), right.w, bitcast<vec3<f32>>(up.xyz), up.w);
}

fn leveled_texel(leveled: u32, texel: u32) -> vec4<u32> {
    let first = picture_params.first_area + MAX_AREAS * AREA_TEXELS;
    return textureLoad(lights, record_texel(first + leveled * LEVELED_TEXELS + texel), 0);
}

// Index of the view, number of levels, and index of the first cube face.
fn leveled_view(leveled: u32) -> vec3<u32> {
    return leveled_texel(leveled, 3u).xyz;
}

// One level of a leveled view.
struct LevelMap {
    first: u32,      // first block, at the corner of the border
    size: vec2<i32>, // [blocks], without the border
    edge: f32,       // edge of a block [texels]
}

fn level_map(view: GpuView, leveled: u32, number: u32) -> LevelMap {
    let index = number - 1u;
    let first = leveled_texel(leveled, index / 4u)[index % 4u];
    let size = vec2<u32>(view.size) + (vec2(1u << number) - 1u);
    return LevelMap(first, vec2<i32>(size >> vec2(number)), f32(1u << number));
}

// Index of a block among all blocks; `at` counts from the map's first block and is clamped to the border.
fn block_number(map: LevelMap, at: vec2<i32>) -> u32 {
    let skirt = i32(SKIRT);
    let skirted = clamp(at, vec2(-skirt), map.size + (skirt - 1)) + skirt;
    return map.first + u32(skirted.y * (map.size.x + 2 * skirt) + skirted.x);
}

// Nodes of a block, a pair of its four.
fn block_nodes(block: u32, pair: u32) -> vec4<u32> {
    return textureLoad(levels, record_texel(block * BLOCK_TEXELS + pair), 0);
}
