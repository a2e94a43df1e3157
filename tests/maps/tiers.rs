//! Maps of the tiers compared: walks that cull by subgroup or not, and sums in buffers or textures, give the
//! same bits.
use super::{curve, parts};
use crate::common::{Tier, map_frame, map_frame_scattered};
use gobo::model::Receiver;
use gobo_scene::Scene;

fn assert_tiers_agree(name: &str, scene: &Scene) {
    let expected = map_frame(Tier::Native, scene);
    for &tier in Tier::ALL {
        let found = map_frame(tier, scene);
        let what = format!("{name}, {tier}");
        parts::assert_same(&found.maps, &expected.maps, &what);
        assert_eq!(found.counters.pairs, expected.counters.pairs, "{what}");
        assert_eq!(found.counters.disordered, expected.counters.disordered, "{what}");
    }
}

/// Casters whose pairs do not fit are added to the sums of texels.
fn assert_sums_agree(name: &str, scene: &Scene) {
    let mut scene = scene.clone();
    scene.shadow.receiver = Receiver::Nearest;
    scene.shadow.pair_budget = 7;
    let expected = map_frame_scattered(Tier::Native, &scene);
    assert!(expected.counters.overflowed > 0, "{name}");
    for &tier in Tier::ALL {
        let found = map_frame_scattered(tier, &scene);
        parts::assert_same(&found.maps, &expected.maps, &format!("{name}, {tier}, sums"));
    }
}

#[test]
fn tiers_give_the_same_bits() {
    let (name, mut scene) = parts::scenes().swap_remove(1);
    assert_tiers_agree(name, &scene);
    assert_sums_agree(name, &scene);
    scene.shadow.receiver = Receiver::Curve;
    assert_tiers_agree(name, &scene);
    let [(name, mut long), ..] = parts::long_tiles();
    long.shadow.receiver = Receiver::Nearest;
    assert_tiers_agree(name, &long);
}

#[test]
#[ignore = "kernels of every kind of caster on three tiers: make test-all"]
fn tiers_give_the_same_bits_of_every_kind() {
    for (name, mut scene) in parts::scenes().into_iter().chain(parts::long_tiles()) {
        assert_sums_agree(name, &scene);
        for receiver in [Receiver::Nearest, Receiver::Curve] {
            scene.shadow.receiver = receiver;
            assert_tiers_agree(name, &scene);
        }
        scene.shadow.colored = true;
        assert_tiers_agree(&format!("{name}, coloured"), &scene);
    }
    for nodes in [4, 16] {
        assert_tiers_agree("nodes", &curve::discs(nodes));
    }
}
