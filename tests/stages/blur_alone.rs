//! The blur with handmade inputs, in an atlas of poison: each texel of the views is written, and no other.
use super::{
    by_hand::run_all,
    maps_by_hand::{
        GROUPS, HALF, Inputs, NODES, Written, assert_curves, assert_filters, odd_view_buffer,
        odd_views, poisoned, random_maps,
    },
};
use crate::common::{TIERS, gpu, scenes::Chance};
use gobo::{
    glam::{UVec2, Vec3},
    gpu::{KernelDesc, Resources},
    model::BLUR_DEVIATIONS,
    records::ViewMaps,
    stage::{
        blur::{self as stage, BlurParams},
        features::Features,
    },
    wgpu::{BufferUsages, TextureFormat as Format},
};
use gobo_reference::{blur::blur, curve::Streaming};
use half::f16;

/// Random maps with curves of four layers, whose means are exact, and nothing opaque: beside an opaque
/// surface kernels use a separate window for each row.
fn layered(seed: u64) -> [ViewMaps; 2] {
    let mut chance = Chance::new(seed);
    random_maps(seed).map(|mut maps| {
        maps.opaque.fill(1.0);
        for nodes in maps.curve.as_mut().unwrap().packed.chunks_mut(NODES) {
            let mut layers = Streaming::new(NODES as u32, false);
            for depth in [0.2, 0.4, 0.6, 0.8] {
                if chance.below(3) > 0 {
                    layers.insert(depth, depth, chance.vec3(0.3, 1.0));
                }
            }
            nodes.iter_mut().zip(layers.pack()).for_each(|(node, packed)| *node = packed);
        }
        maps
    })
}

#[test]
fn every_texel_of_the_views_is_blurred_and_no_other() {
    for (tier, radius) in TIERS.into_iter().zip([1, 5]) {
        let gpu = gpu(tier);
        let maps = layered(7 + u64::from(radius));
        let Inputs { filters, nearests, opaques, curves } = Inputs::new(&gpu, &maps);
        let views = odd_view_buffer(&gpu);
        let scale = -0.5 * (BLUR_DEVIATIONS / radius as f32).powi(2);
        let params = BlurParams { radius: radius as i32, scale, ..BlurParams::default() };
        let params = gpu.upload("blur_params", &[params], BufferUsages::UNIFORM);
        let [near_rows, near_around, rows] = ["near_rows", "near_around", "rows"]
            .map(|name| poisoned::<4>(&gpu, name, Format::Rgba32Float, 1));
        let row_curves = poisoned::<4>(&gpu, "row_curves", Format::Rgba32Uint, NODES as u32 / 2);
        let resources = Resources::new()
            .with("views", &views)
            .with("blur_params", &params)
            .with("filters", &filters)
            .with("nearests", &nearests)
            .with("opaques", &opaques)
            .with("curves", &curves)
            .with("near_rows", &near_rows)
            .with("near_around", &near_around)
            .with("rows", &rows);
        let of = |from, to| resources.clone().with("raw_curves", from).with("curves", to);
        let four = Features { nodes: NODES as u32, ..Features::NONE }.constants();
        let run = |resources: &Resources, kernels: &[&'static KernelDesc]| {
            let kernels: Vec<_> = kernels.iter().map(|kernel| (*kernel, GROUPS)).collect();
            run_all(&gpu, tier, &four, resources, &kernels);
        };
        run(&resources, &[&stage::NEAR_ROWS, &stage::NEAR_COLUMNS, &stage::ROWS]);
        run(&of(&curves, &row_curves), &[&stage::CURVE_ROWS]);
        run(&of(&row_curves, &curves), &[&stage::CURVE_COLUMNS]);
        run(&resources, &[&stage::COLUMNS]);
        let what = format!("{tier:?}, {radius}");
        for (name, between) in [
            ("near_rows", &near_rows),
            ("near_around", &near_around),
            ("rows", &rows),
            ("row_curves", &row_curves),
        ] {
            let mut written = Written::<4>::new(&gpu, &format!("{what}: {name}"), between);
            written.take_all();
            written.assert_rest();
        }
        let expected = maps.clone().map(|mut maps| {
            blur(&mut maps, radius);
            maps
        });
        assert_filters(&gpu, &what, [&filters, &nearests], &expected);
        assert_curves(&gpu, &what, &curves, &expected, 0.0);
        assert_ne!(maps[0].filter, expected[0].filter, "{what}: nothing was blurred");
    }
}

/// Each texel of a smaller level is the mean in its own view; outside the views the level is poison.
#[test]
fn smaller_levels_hold_the_views_alone() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let maps = random_maps(3);
        let inputs = Inputs::new(&gpu, &maps);
        let views = odd_view_buffer(&gpu);
        let params = BlurParams { level: 1, ..BlurParams::default() };
        let params = gpu.upload("blur_params", &[params], BufferUsages::UNIFORM);
        // As large as the whole atlas, so that texels beside a level show too.
        let level = poisoned::<2>(&gpu, "filter_mip", Format::Rgba16Float, 1);
        let resources = Resources::new()
            .with("views", &views)
            .with("blur_params", &params)
            .with("filters", &inputs.filters)
            .with("filter_mip", &level);
        let none = Features::NONE.constants();
        run_all(&gpu, tier, &none, &resources, &[(&stage::FILTER_MIP, GROUPS)]);
        let words: Vec<[u32; 2]> = gpu.read_texture(&level);
        let poison = poisoned::<2>(&gpu, "poison", Format::Rgba16Float, 1);
        let mut expected: Vec<[u32; 2]> = gpu.read_texture(&poison);
        let (width, height) = (level.width(), level.height());
        for (view, maps) in maps.iter().enumerate() {
            let (size, own) = (maps.view.size, odd_views()[view]);
            let half = (size + 1) / 2;
            for at in (0..half.element_product()).map(|i| UVec2::new(i % half.x, i / half.x)) {
                let end = ((at + 1) * 2).min(size);
                let below = (2 * at.y..end.y)
                    .flat_map(|y| (2 * at.x..end.x).map(move |x| (y * size.x + x) as usize));
                let all: Vec<_> = below.map(|i| Vec3::from(maps.filter[i])).collect();
                let mean = all.iter().sum::<Vec3>() / all.len() as f32;
                let there = own.origin / 2 + at;
                let index = ((own.layer * height + there.y) * width + there.x) as usize;
                let [red_green, blue_alpha] = words[index];
                let bits = [red_green, red_green >> 16, blue_alpha].map(|bits| bits as u16);
                let found = Vec3::from_array(bits.map(|bits| f16::from_bits(bits).to_f32()));
                assert!((found - mean).abs().max_element() <= HALF, "{tier:?}: {found} at {at}");
                expected[index] = words[index];
            }
        }
        assert_eq!(words, expected, "{tier:?}: texels beside the levels");
    }
}
