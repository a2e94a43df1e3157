//! Kernels for GPUs and kernels for software adapters give the same bits: on a GPU workgroups sort and bin,
//! an invocation has one texel, records are in buffers, and insertion uses workgroup and private memory; on
//! software adapters registers hold columns of texels, and records are in textures.
use super::{curve, parts};
use crate::common::{
    Tier, gpu,
    rounding::{FORMS, nearly_same, rounds_as_the_cpu},
    tiers,
};
use gobo::{
    gpu::RecordForm,
    model::Receiver,
    records::ViewMaps,
    stage::{
        bin::{DISC_SEGMENT, WIDE_DISC_SEGMENT},
        buckets::BUCKET_PAIRS,
        sort::Partition,
    },
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

fn maps(tier: Tier, scene: &Scene, columns: bool) -> (Vec<ViewMaps>, u64) {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| {
        config.tuning.columns = columns;
        config.tuning.loaded = columns;
        config.tuning.record_form =
            if columns { RecordForm::Textures } else { RecordForm::Buffers };
        config.tuning.partition = if columns { Partition::Serial } else { Partition::Wide };
        config.tuning.bucket_pairs = if columns { 0 } else { BUCKET_PAIRS };
    });
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    let frame = renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}"));
    (frame.maps, frame.counters.disordered)
}

pub(super) fn assert_forms_agree(name: &str, scene: &Scene) {
    tiers(Tier::Native).into_iter().for_each(|tier| assert_forms_agree_on(tier, name, scene));
}

fn assert_forms_agree_on(tier: Tier, name: &str, scene: &Scene) {
    let [one, columns] = [false, true].map(|columns| maps(tier, scene, columns));
    if rounds_as_the_cpu(&gpu(tier)) {
        parts::assert_same(&one.0, &columns.0, &format!("{name}, {tier:?}"));
    } else if let Err(apart) = nearly_same(&one.0, &columns.0, FORMS) {
        panic!("{name}, {tier:?}: {apart}");
    }
    assert_eq!(one.1, columns.1, "{name}, {tier:?}: disordered");
}

/// The comparison for GPUs sees what is more than rounding.
#[test]
fn other_maps_are_not_nearly_the_same() {
    let (_, mut scene) = parts::scenes().swap_remove(0);
    scene.shadow.receiver = Receiver::Nearest;
    let (found, _) = maps(Tier::Core, &scene, false);
    let changed = |texels: usize, light: f32, depth: f32| {
        let mut other = found.clone();
        for maps in &mut other {
            let some = maps.filter.iter_mut().zip(&mut maps.nearest).take(texels);
            some.for_each(|(filter, nearest)| {
                filter[1] -= light;
                *nearest -= depth;
            });
        }
        nearly_same(&other, &found, FORMS).is_ok()
    };
    // Texels of each map.
    let texels = found[0].filter.len();
    assert!(found.iter().all(|maps| maps.filter.len() == texels));
    let few = (FORMS * texels as f64) as usize;
    assert!(changed(texels, 9e-4, 1e-6) && changed(few, 0.1, 0.1));
    assert!(!changed(few + 1, 2e-3, 0.0) && !changed(few + 1, 0.0, 1e-5));
    assert!(!changed(few + 1, f32::NAN, 0.0) && nearly_same(&found[1..], &found, FORMS).is_err());
}

/// Maps of discs with segments of `length` pairs, and the number of segments.
fn maps_of_segments(tier: Tier, scene: &Scene, length: u32) -> (Vec<ViewMaps>, u64) {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| config.tuning.disc_segment = length);
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    let frame = renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}"));
    (frame.maps, frame.counters.segments)
}

/// Each segment rounds its sum to a step of 2^-16 in optical depth, and the map the product to a half float:
/// two neighbours below 1 are 2^-11 apart. Depths are the same.
#[test]
fn short_segments_of_discs_only_round() {
    const STEP: f32 = 1.0 / 2048.0;
    let (name, mut scene) = parts::long_tiles().into_iter().next().unwrap();
    scene.shadow.receiver = Receiver::Nearest;
    for tier in tiers(Tier::Native) {
        let [long, short] =
            [DISC_SEGMENT, WIDE_DISC_SEGMENT].map(|length| maps_of_segments(tier, &scene, length));
        assert!(short.1 > 4 && long.1 < 2, "{} and {} segments", long.1, short.1);
        for (long, short) in long.0.iter().zip(&short.0) {
            assert!(
                long.opaque == short.opaque && long.nearest == short.nearest,
                "{name}, {tier:?}"
            );
            let both = long.filter.as_flattened().iter().zip(short.filter.as_flattened());
            let apart = both.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart <= STEP, "{name}, {tier:?}: {apart}");
            assert!(long.filter.iter().any(|light| light[1] < 0.9), "{name}");
        }
    }
}

/// Pairs that do not fit are binned again in parts, or scattered.
#[test]
fn forms_agree_past_the_budget() {
    let (name, mut scene) = parts::scenes().swap_remove(1);
    scene.shadow.receiver = Receiver::Nearest;
    scene.shadow.pair_budget = 500;
    assert_forms_agree(name, &scene);
}

/// Segments of long tiles add to the sums of texels, which are in one buffer or one for each channel.
#[test]
fn forms_of_sums_agree() {
    // Flat discs: soft ones have longer segments on software adapters.
    let [_, (name, mut scene), _] = parts::long_tiles();
    scene.shadow.receiver = Receiver::Nearest;
    for &tier in Tier::BY_SUBGROUPS {
        assert_forms_agree_on(tier, name, &scene);
    }
}

#[test]
fn forms_of_curves_agree() {
    let mut scenes = parts::scenes();
    scenes.truncate(2);
    for (name, mut scene) in scenes {
        scene.shadow.receiver = Receiver::Curve;
        assert_forms_agree(name, &scene);
    }
}

#[test]
#[ignore = "each kernel twice: make test-all"]
fn forms_of_every_kind_agree() {
    for (name, mut scene) in parts::scenes() {
        for receiver in [Receiver::Nearest, Receiver::Curve] {
            scene.shadow.receiver = receiver;
            assert_forms_agree(name, &scene);
        }
    }
    for nodes in [4, 16] {
        assert_forms_agree("nodes", &curve::discs(nodes));
    }
}

/// Without curves: llvmpipe ends loops after 65,535 turns, which the loops over nodes reach in such tiles.
#[test]
#[ignore = "many casters: make test-all"]
fn forms_of_long_tiles_agree() {
    for (name, scene) in parts::long_tiles() {
        assert_forms_agree(name, &scene);
    }
}
