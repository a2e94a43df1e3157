//! Softening with handmade inputs and poisoned outputs: each texel of the views is written, and no other.
use super::maps_by_hand::{
    GROUPS, Inputs, NODES, Written, assert_curves, assert_filters, odd_view_buffer, poisoned,
    random_maps,
};
use crate::{
    common::{TIERS, gpu, windows},
    stages::by_hand::run_all,
};
use gobo::{
    gpu::Resources,
    records::ViewMaps,
    stage::{
        features::Features,
        soften::{self as stage, SoftenParams, run_layers},
    },
    wgpu::{BufferUsages, TextureFormat as Format},
};
use gobo_reference::curve::soften::soften_curves;

/// Windows of the patterns [texels].
const WINDOWS: [u32; 2] = [2, 8];

/// Filters and depths in 64 bits, curves of the reference.
fn softened(maps: &[ViewMaps; 2], window: u32) -> [ViewMaps; 2] {
    maps.clone().map(|mut soft| {
        let sharp = soft.clone();
        soften_curves(&mut soft, window);
        for at in 0..sharp.filter.len() {
            let (light, nearest, opaque) = windows::softened(&sharp, at, window as i32 / 2);
            soft.filter[at] = light.as_vec3().to_array();
            (soft.nearest[at], soft.opaque[at]) = (nearest, opaque);
        }
        soft
    })
}

#[test]
fn every_texel_of_the_views_is_softened_and_no_other() {
    for (tier, window) in TIERS.into_iter().zip(WINDOWS) {
        let gpu = gpu(tier);
        let maps = random_maps(u64::from(window));
        let inputs = Inputs::new(&gpu, &maps);
        let views = odd_view_buffer(&gpu);
        let params = SoftenParams { radius: (window / 2) as i32, ..SoftenParams::default() };
        let params = gpu.upload("soften_params", &[params], BufferUsages::UNIFORM);
        let rows = poisoned::<4>(&gpu, "rows", Format::Rgba32Float, 1);
        let filters = poisoned::<2>(&gpu, "soft_filters", Format::Rgba16Float, 1);
        let [nearests, opaques] = ["soft_nearests", "soft_opaques"]
            .map(|name| poisoned::<1>(&gpu, name, Format::R32Float, 1));
        let shared = Resources::new().with("views", &views).with("soften_params", &params);
        let resources = shared
            .clone()
            .with("filters", &inputs.filters)
            .with("nearests", &inputs.nearests)
            .with("opaques", &inputs.opaques)
            .with("colored", &inputs.opaques)
            .with("rows", &rows)
            .with("soft_filters", &filters)
            .with("soft_nearests", &nearests)
            .with("soft_opaques", &opaques);
        let none = Features::NONE.constants();
        let kernels = [(&stage::ROWS, GROUPS), (&stage::COLUMNS, GROUPS)];
        run_all(&gpu, tier, &none, &resources, &kernels);
        let expected = softened(&maps, window);
        let what = format!("{tier:?}, {window}");
        assert_filters(&gpu, &what, [&filters, &nearests], &expected);
        let mut found = Written::<1>::new(&gpu, &format!("{what}: Z"), &opaques);
        for (view, maps) in expected.iter().enumerate() {
            for (i, &depth) in maps.opaque.iter().enumerate() {
                assert_eq!(found.take(view, i, 0), [depth.to_bits()], "{what}: {view}, {i}");
            }
        }
        found.assert_rest();
        let mut sums = Written::<4>::new(&gpu, &format!("{what}: rows"), &rows);
        sums.take_all();
        sums.assert_rest();

        let rows =
            poisoned::<4>(&gpu, "curve_rows", Format::Rgba32Float, run_layers(false, NODES as u32));
        let curves = poisoned::<4>(&gpu, "soft_curves", Format::Rgba32Uint, NODES as u32 / 2);
        let resources = shared
            .with("rows", &rows)
            .with("colored", &inputs.opaques)
            .with("raw_curves", &inputs.curves)
            .with("curves", &curves);
        let four = Features { nodes: NODES as u32, ..Features::NONE }.constants();
        let kernels = [(&stage::ROWS, GROUPS), (&stage::CURVE_COLUMNS, GROUPS)];
        run_all(&gpu, tier, &four, &resources, &kernels);
        let mut sums = Written::<4>::new(&gpu, &format!("{what}: rows of curves"), &rows);
        sums.take_all();
        sums.assert_rest();
        assert_curves(&gpu, &what, &curves, &expected, 0.0);
        assert_ne!(maps[0].filter, expected[0].filter, "{what}: nothing was softened");
    }
}
