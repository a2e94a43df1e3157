//! Curves of random hits against closed forms, their bound, and other projects' formats.
use crate::{
    common::scenes::Chance,
    curves::{Method, Rays, Sample},
    moments::Moments,
    rivals::{Fourier, Hit, exact},
};
use gobo::{
    glam::Vec3,
    records::curve::{DEPTHS, light_at},
};
use gobo_reference as reference;
use gobo_reference::curve::{
    MAX_NODES, Streaming,
    two_walks::{self, RayHit, RayModes},
};

/// Rounding of a stored depth and of a stored channel.
const DEPTH_ROUNDING: f32 = 0.5 / 65535.0;
pub(super) const LIGHT_ROUNDING: f32 = 0.5 / 4095.0 + 1.0 / 65535.0;

fn random_hits(count: usize, seed: u64) -> Vec<Hit> {
    let mut chance = Chance::new(seed);
    (0..count).map(|_| (chance.within(0.001, 0.999), chance.vec3(0.3, 1.0))).collect()
}

fn streamed(hits: &[Hit], nodes: u32) -> Vec<[u32; 2]> {
    let mut curve = Streaming::new(nodes, false);
    for &(depth, light) in hits {
        curve.insert(depth, depth, light);
    }
    curve.pack().collect()
}

/// Largest difference of a channel; light under 1/1024 is stored as 0.
fn apart(packed: &[[u32; 2]], hits: &[Hit], z: f32) -> f32 {
    let (is, should) = (light_at(packed, z, false), exact(hits, z));
    let channel = |i: usize| {
        let black = is[i] == 0.0 && should[i] < reference::resolve::BLACK + LIGHT_ROUNDING;
        if black { 0.0 } else { (is[i] - should[i]).abs() }
    };
    (0..3).map(channel).fold(0.0, f32::max)
}

/// Depths outside the rounding of all hits' depths.
fn clear_depths(hits: &[Hit]) -> impl Iterator<Item = f32> {
    let near = |z: f32| hits.iter().any(|hit| (hit.0 - z).abs() <= 2.0 * DEPTH_ROUNDING);
    (0..997).map(|i| (i as f32 + 0.5) / 997.0).filter(move |&z| !near(z))
}

#[test]
fn curves_beat_what_others_store() {
    for rays in Rays::ALL {
        let sample = Sample::new(rays);
        let (fourier, moments) = (sample.error(Method::Fourier), sample.error(Method::Moments));
        let share = match rays {
            Rays::Smoke => 0.7,
            Rays::Panes => 0.01,
            Rays::Puffs => 0.25,
        };
        for method in [Method::Curve(8), Method::TwoWalks(8)] {
            let error = sample.error(method);
            let (mean, high) = (error.mean, error.high);
            assert!(high < fourier.high, "{rays:?} {method:?}: {high} {fourier:?}");
            assert!(mean <= share * fourier.mean, "{rays:?} {method:?}: {mean} {fourier:?}");
            assert!(mean <= 0.25 * moments.mean, "{rays:?} {method:?}: {mean} {moments:?}");
        }
        // More nodes are better, and no number is exact: the comparison can fail.
        let of = |nodes| sample.error(Method::Curve(nodes)).mean;
        assert!(of(16) < of(8) && of(8) < of(4), "{rays:?}");
        assert!(sample.error(Method::Nearest).mean > 2.0 * fourier.mean, "{rays:?}");
    }
}

/// The competing methods are implemented correctly: they are exact where their papers claim it.
#[test]
fn rivals_are_honest() {
    let hits = random_hits(6, 3);
    let fourier = Fourier::new(&hits);
    // The integral over the whole range is the constant coefficient's.
    assert!((fourier.light_at(1.0) - exact(&hits, 1.0)).abs().max_element() < 1e-4);
    // Four moments bound a single step from both sides: 0 before it, all of it behind.
    let single = [(0.5, Vec3::splat(0.25))];
    let moments = Moments::new(&single, 4);
    assert!((moments.light_at(0.2) - Vec3::ONE).abs().max_element() < 0.01);
    assert!((moments.light_at(0.8) - Vec3::splat(0.25)).abs().max_element() < 0.01);
}

#[test]
fn exact_while_at_most_k_hits_in_any_order() {
    for nodes in [4, 8, 16] {
        for seed in 0..20 {
            let hits = random_hits(nodes as usize, seed);
            let packed = streamed(&hits, nodes);
            for z in clear_depths(&hits) {
                let apart = apart(&packed, &hits, z);
                assert!(apart <= LIGHT_ROUNDING, "{nodes} {seed} {z}: {apart}");
            }
        }
        // One hit more is not exact: the check can fail.
        let hits = random_hits(nodes as usize + 1, 7);
        let packed = streamed(&hits, nodes);
        assert!(clear_depths(&hits).any(|z| apart(&packed, &hits, z) > LIGHT_ROUNDING), "{nodes}");
    }
}

fn by_two_walks(hits: &[Hit], nodes: u32) -> Vec<[u32; 2]> {
    let hit = |&(depth, light): &Hit| RayHit {
        start: depth,
        end: depth,
        absorbed: Vec3::ONE - light,
        presence: 1.0,
    };
    let modes = RayModes { nodes, few: true, faint: false, grows: false, bodies: None };
    two_walks::curve(&hits.iter().map(hit).collect::<Vec<_>>(), modes).0
}

fn mixed(hits: &[Hit], chance: &mut Chance) -> Vec<Hit> {
    let mut mixed = hits.to_vec();
    for i in (1..mixed.len()).rev() {
        mixed.swap(i, chance.below(i + 1));
    }
    mixed
}

/// Up to K hits have a node each, in any order, and the order of nodes has no effect.
#[test]
fn two_walks_are_exact_in_any_order() {
    let mut chance = Chance::new(3);
    for nodes in [4, 8, MAX_NODES as u32] {
        for seed in 1..20 {
            let count = 1 + chance.below(nodes as usize);
            let hits = random_hits(count, seed);
            let mut packed = by_two_walks(&mixed(&hits, &mut chance), nodes);
            let clear: Vec<_> = clear_depths(&hits).collect();
            let light: Vec<_> = clear.iter().map(|&z| light_at(&packed, z, false)).collect();
            for &z in &clear {
                let apart = apart(&packed, &hits, z);
                assert!(apart <= 1e-3, "{count} hits in {nodes} nodes, {seed}, {z}: {apart}");
            }
            packed.reverse();
            for (&z, before) in clear.iter().zip(light) {
                assert!((light_at(&packed, z, false) - before).abs().max_element() < 1e-6);
            }
        }
        // One hit more is not exact: the check can fail.
        let hits = random_hits(nodes as usize + 1, 7);
        let packed = by_two_walks(&hits, nodes);
        assert!(clear_depths(&hits).any(|z| apart(&packed, &hits, z) > 1e-3), "{nodes}");
    }
}

/// For hits in order, the error is at most the light lost in one node, and light never grows.
#[test]
fn the_bound_of_two_walks_holds() {
    for (count, seed) in [(9, 1), (12, 2), (17, 3), (30, 3), (100, 4), (300, 5), (300, 6)] {
        let mut hits = random_hits(count, seed);
        for hit in &mut hits {
            hit.1 = hit.1.powf(8.0 / count as f32);
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        for nodes in [4, 8, MAX_NODES as u32] {
            let packed = by_two_walks(&hits, nodes);
            let behind = |i: usize| light_at(&packed[..i], 2.0, false);
            let loss = |i: usize| (behind(i) - behind(i + 1)).max_element();
            let bound = (0..packed.len()).map(loss).fold(0.0, f32::max);
            let mut before = Vec3::ONE;
            for z in clear_depths(&hits) {
                let off = apart(&packed, &hits, z);
                assert!(
                    off <= bound + 2.0 * LIGHT_ROUNDING,
                    "{count} {nodes} {z}: {off} > {bound}"
                );
                let light = light_at(&packed, z, false);
                assert!(light.cmple(before + 1e-6).all(), "{count} {nodes} {z}");
                before = light;
            }
        }
    }
}

/// For any merges, the error is at most the light lost in one node.
#[test]
fn the_bound_holds() {
    for (count, seed) in [(9, 1), (12, 2), (30, 3), (100, 4), (300, 5)] {
        let mut hits = random_hits(count, seed);
        for hit in &mut hits {
            hit.1 = hit.1.powf(8.0 / count as f32);
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        for nodes in [4, 8, MAX_NODES as u32] {
            let packed = streamed(&hits, nodes);
            // Light behind the last of the first i nodes.
            let behind = |i: usize| light_at(&packed[..i], 2.0, false);
            let loss = |i: usize| (behind(i) - behind(i + 1)).max_element();
            let bound = (0..packed.len()).map(loss).fold(0.0, f32::max);
            let worst = clear_depths(&hits).map(|z| apart(&packed, &hits, z)).fold(0.0, f32::max);
            assert!(worst <= bound + 2.0 * LIGHT_ROUNDING, "{count} {nodes}: {worst} > {bound}");
            assert!(worst > 0.0);
        }
    }
}

/// Overlapping steps and ramps, some of them late: at each depth the error is at most the light lost in the
/// node there and in the next.
#[test]
fn the_bound_holds_where_ramps_overlap() {
    let mut chance = Chance::new(31);
    let (mut depths, mut past_one) = (0, 0);
    for ray in 0..320 {
        let count = 9 + chance.below(120);
        let mut ramps: Vec<_> = (0..count)
            .map(|i| {
                let start = chance.within(0.001, 0.95);
                let length = [0.0, chance.within(0.0, 0.004), chance.within(0.0, 0.2)][i % 3];
                let light = chance.vec3(0.2, 1.0).powf(8.0 / count as f32);
                (start, (start + length).min(0.999), light)
            })
            .collect();
        let late = [0.0, 0.002, 0.05][ray % 3];
        let mut order: Vec<_> =
            (0..count).map(|i| (ramps[i].0 + chance.within(0.0, late), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        ramps = order.into_iter().map(|(_, i)| ramps[i]).collect();
        let nodes = [4, 8, 16][ray % 3];
        let mut curve = Streaming::new(nodes, false);
        ramps.iter().for_each(|&(start, end, light)| curve.insert(start, end, light));
        let packed: Vec<_> = curve.pack().collect();
        let behind = |i: usize| light_at(&packed[..i], 2.0, false);
        let loss = |i: usize| (behind(i) - behind((i + 1).min(packed.len()))).max_element();
        for z in (0..997).map(|i| (i as f32 + 0.5) / 997.0) {
            if ramps.iter().any(|&(start, ..)| (z - start).abs() <= 2.0 * DEPTH_ROUNDING) {
                continue;
            }
            let exact: Vec3 = ramps
                .iter()
                .map(|&(start, end, light)| {
                    let share = ((z - start) / (end - start).max(1e-9)).clamp(0.0, 1.0);
                    Vec3::ONE.lerp(light, share)
                })
                .product();
            let worst = (light_at(&packed, z, false) - exact).abs().max_element();
            // The depth's node, at or after whose start it is, and the next one; unused ones come first.
            let begun = |node: &[u32; 2]| ((node[0] >> 16) as f32) < z * DEPTHS;
            let next = packed.iter().take_while(|node| begun(node)).count();
            let around = [next.checked_sub(1).map_or(0.0, loss), loss(next)];
            depths += 1;
            past_one += usize::from(worst > around[0].max(around[1]) + 2.0 * LIGHT_ROUNDING);
            let both = around[0] + around[1];
            assert!(worst <= both + 2.0 * LIGHT_ROUNDING, "ray {ray}, {z}: {worst} > {both}");
        }
    }
    println!("{past_one} of {depths} depths are off by more than the light lost in one node");
    assert!(past_one > 0, "one node bounds them all: the page says too much");
}

#[test]
fn light_never_grows_with_depth() {
    let mut hits = random_hits(200, 9);
    hits.iter_mut().for_each(|hit| hit.1 = hit.1.powf(0.05));
    let packed = streamed(&hits, 8);
    let mut before = Vec3::ONE;
    for i in 0..=2000 {
        let light = light_at(&packed, i as f32 / 2000.0, false);
        assert!(light.cmple(before + 1e-6).all(), "{i}");
        before = light;
    }
}

#[test]
fn a_curve_may_brighten() {
    let hits = [(0.2, Vec3::splat(4.0)), (0.5, Vec3::new(0.5, 2.0, 1.0)), (0.7, Vec3::splat(0.1))];
    let mut curve = Streaming::new(4, true);
    for (depth, light) in hits {
        curve.insert(depth, depth, light);
    }
    let packed: Vec<_> = curve.pack().collect();
    for z in [0.1, 0.3, 0.6, 0.9] {
        let (is, should) = (light_at(&packed, z, true), exact(&hits, z));
        // 20 octaves in 4,095 steps.
        assert!(((is - should) / should).abs().max_element() < 0.003, "{z}: {is} {should}");
    }
}
