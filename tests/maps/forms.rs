//! Kernels as on a GPU, where an invocation holds one texel, and workgroup and private memory what it inserts
//! into, beside those of software adapters, which hold columns of texels in registers: the same bits.
use super::{curve, parts};
use crate::common::{Tier, gpu, tiers};
use gobo::{
    internals::records::ViewMaps,
    model::Receiver,
    render::{RenderOptions, Renderer},
    scene::Scene,
};

fn maps(tier: Tier, scene: &Scene, columns: bool) -> (Vec<ViewMaps>, u64) {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| {
        (config.profile.columns, config.profile.unrolled) = (columns, columns);
    });
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    let frame = renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}"));
    (frame.maps, frame.counters.disordered)
}

pub(super) fn assert_forms_agree(name: &str, scene: &Scene) {
    for tier in tiers(Tier::Native) {
        let [one, columns] = [false, true].map(|columns| maps(tier, scene, columns));
        parts::assert_same(&one.0, &columns.0, &format!("{name}, {tier:?}"));
        assert_eq!(one.1, columns.1, "{name}, {tier:?}: disordered");
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
