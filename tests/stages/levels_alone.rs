//! One level of blocks with handmade inputs, against explicit weights: several levels together would hide
//! errors.
use super::by_hand::{POISON, run_all};
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, empty, light},
};
use bytemuck::Zeroable as _;
use gobo::{
    glam::{IVec2, UVec2, Vec3},
    gpu::{Gpu, Resources},
    model::{LightKind, Source},
    records::{BLOCK_NODES, BLOCK_TEXELS, LightRecords, ROW, SKIRT, curve::light_at, level_size},
    stage::{
        features::Features,
        levels::{GROUP_SIZE, LevelParams, NEXT},
        light_points::PictureParams,
    },
    view::shadow_views,
    wgpu::{BufferUsages, Texture, TextureFormat},
};
use gobo_reference::curve::Streaming;

/// Edge of the map [texels]: blocks of the second level are cut at its border.
const SIZE: u32 = 44;
/// Depths of the only occluder of each block, and behind it.
const DEPTH: f32 = 0.5;
const BEHIND: f32 = 0.9;
/// Weights of children along an axis: a quadratic B-spline is the sum of four of half its width.
const SPLINE: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
/// Light has 12 bits: half a step, and that of the intermediate sum.
const STEP: f32 = 1.5 / 4095.0;

/// Records of four words, row by row, followed by poison.
fn records(gpu: &Gpu, name: &'static str, words: &[[u32; 4]], count: u32) -> Texture {
    let rows = count.div_ceil(ROW);
    let texture = gpu.texture(name, [ROW, rows], TextureFormat::Rgba32Uint);
    let mut all = words.to_vec();
    all.resize((rows * ROW) as usize, [POISON; 4]);
    gpu.write_texture(&texture, &all);
    texture
}

#[test]
fn a_block_is_the_spline_of_the_blocks_below() {
    let mut scene = empty(Vec::new());
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    (scene.lights[0].source, scene.lights[0].size) = (Some(Source::Sun { angle: 0.1 }), Some(SIZE));
    let models = shadow_views(&scene);
    let views = vec![models[0].to_gpu(0, UVec2::ZERO, 0)];
    let own = LightRecords::new(scene.lights.iter().enumerate(), &models, views, &scene.shadow);
    let [below, above] = [1, 2].map(|level| level_size(UVec2::splat(SIZE), level));
    let mut chance = Chance::new(5);
    let block = |_| {
        let mut curve = Streaming::new(BLOCK_NODES as u32, false);
        curve.insert(DEPTH, DEPTH, chance.vec3(0.0, 1.0));
        curve.pack().collect::<Vec<_>>()
    };
    let blocks: Vec<_> = (0..own.level_ends[0]).map(block).collect();
    let light_below = |at: IVec2| {
        let at = at.clamp(IVec2::ZERO, below.as_ivec2() - 1).as_uvec2() + SKIRT;
        light_at(&blocks[(at.y * (below.x + 2 * SKIRT) + at.x) as usize], BEHIND, false)
    };
    // Weighted mean of the 4 x 4 children.
    let mean = |at: UVec2, shares: [f32; 4]| -> Vec3 {
        let child = |i: usize| {
            let step = IVec2::new(i as i32 % 4, i as i32 / 4);
            light_below(2 * at.as_ivec2() - 1 + step) * shares[i % 4] * shares[i / 4]
        };
        (0..16).map(child).sum()
    };
    for tier in TIERS {
        let gpu = gpu(tier);
        let bytes = own.bytes();
        let words: Vec<[u32; 4]> = bytes
            .chunks(16)
            .map(|texel| {
                [0, 4, 8, 12].map(|i| u32::from_le_bytes(texel[i..i + 4].try_into().unwrap()))
            })
            .collect();
        let lights = records(&gpu, "lights", &words, words.len() as u32);
        let words: Vec<[u32; 4]> = blocks
            .iter()
            .flat_map(|nodes| nodes.chunks(2))
            .map(|two| [two[0][0], two[0][1], two[1][0], two[1][1]])
            .collect();
        let levels = records(&gpu, "levels", &words, words.len() as u32);
        let made = own.level_ends[1] - own.level_ends[0];
        let new_levels = records(&gpu, "new_levels", &[], made * BLOCK_TEXELS);
        let (light_count, first_area) = (own.lights.len() as u32, own.first_area());
        let picture = PictureParams { light_count, first_area, ..PictureParams::zeroed() };
        let picture = gpu.upload("picture_params", &[picture], BufferUsages::UNIFORM);
        let level = LevelParams { level: 2, first_block: own.level_ends[0], pad_0: 0, pad_1: 0 };
        let level = gpu.upload("level_params", &[level], BufferUsages::UNIFORM);
        let resources = Resources::new()
            .with("lights", &lights)
            .with("levels", &levels)
            .with("new_levels", &new_levels)
            .with("picture_params", &picture)
            .with("level_params", &level);
        let groups = (above + 2 * SKIRT).map(|edge| edge.div_ceil(GROUP_SIZE));
        let none = Features::NONE.constants();
        run_all(&gpu, tier, &none, &resources, &[(&NEXT, [groups.x, groups.y, 1])]);
        let found: Vec<[u32; 4]> = gpu.read_texture(&new_levels);
        let mut even_is_off = 0.0_f32;
        for at in (0..above.element_product()).map(|i| UVec2::new(i % above.x, i / above.x)) {
            let block = (at.y + SKIRT) * (above.x + 2 * SKIRT) + at.x + SKIRT;
            let texels = &found[(block * BLOCK_TEXELS) as usize..][..BLOCK_TEXELS as usize];
            let nodes: Vec<_> = texels.iter().flat_map(|&[a, b, c, d]| [[a, b], [c, d]]).collect();
            let (is, wanted) = (light_at(&nodes, BEHIND, false), mean(at, SPLINE));
            assert_eq!(light_at(&nodes, 0.9 * DEPTH, false), Vec3::ONE, "{tier:?} {at}");
            assert!((is - wanted).abs().max_element() <= STEP, "{tier:?} {at}: {is}, not {wanted}");
            even_is_off = even_is_off.max((is - mean(at, [0.25; 4])).abs().max_element());
        }
        assert!(even_is_off > 50.0 * STEP, "{tier:?}: even shares are as good, {even_is_off}");
    }
}
