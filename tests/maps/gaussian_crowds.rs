//! Hundreds of intersecting Gaussians: each one's loss at its end, and by rounding, adds up.
use super::gaussians::{kinds, medium, splats};
use crate::common::{
    TIERS, Tier,
    brute_force::render,
    compare::{ExpectedTexel, Tolerance, compare_maps},
    gpu,
    scenes::{Chance, empty, light, material, triangle},
};
use gobo::{
    glam::{Quat, Vec3},
    model::{Gaussian, LightKind, Material, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_reference::render_maps;
use gobo_scene::Scene;

const COUNT: u32 = 300;
const TOLERANCE: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.05 };

/// Needles, pancakes and balls.
#[derive(Clone, Copy)]
struct Crowd {
    /// Least and largest of their longest deviations [m].
    long: [f32; 2],
    /// Largest ratio of the longest to the shortest.
    aspect: f32,
    /// Least opacity; the largest is 1.
    faintest: f32,
}

/// From a fraction of a texel to a third of the cloud, faint to opaque.
const MIXED: Crowd = Crowd { long: [0.005, 0.6], aspect: 100.0, faintest: 0.01 };
/// Most of them over each texel.
const FAINT: Crowd = Crowd { long: [0.3, 0.4], aspect: 2.0, faintest: 0.003 };

impl Crowd {
    fn gaussians(self, seed: u64) -> Vec<Gaussian> {
        let mut chance = Chance::new(seed);
        let between = |[low, high]: [f32; 2], part: f32| low * (high / low).powf(part);
        let one = |id| {
            let long = between(self.long, chance.unit());
            let thin = long / between([1.0, self.aspect], chance.unit());
            let sigma = match chance.below(4) {
                0 => Vec3::new(long, thin, thin),
                1 => Vec3::new(long, thin, long),
                2 => Vec3::new(long, long * 0.5, long * 0.7),
                _ => Vec3::new(long, thin, (long * thin).sqrt()),
            };
            let axis = chance.vec3(-1.0, 1.0).normalize_or(Vec3::X);
            Gaussian {
                center: chance.vec3(-1.6, 1.6),
                rotation: Quat::from_axis_angle(axis, chance.within(0.0, 3.0)),
                sigma,
                color: chance.vec3(0.0, 1.0),
                opacity: between([self.faintest, 1.0], chance.unit()),
                id,
                ..Gaussian::default()
            }
        };
        (0..COUNT).map(one).collect()
    }

    fn scene(self, kind: LightKind, material: Material, size: u32, seed: u64) -> Scene {
        let mut scene = empty(vec![material]);
        scene.shadow.size = size;
        scene.lights.push(light(kind));
        scene.gaussians = self.gaussians(seed);
        scene
    }
}

fn truth(scene: &Scene) -> Vec<Vec<ExpectedTexel>> {
    shadow_views(scene).iter().map(|view| render(scene, view)).collect()
}

/// Maps of a tier; `queued`: whether its walks collect splats in a queue.
fn maps(tier: Tier, scene: &Scene, queued: bool) -> Vec<ViewMaps> {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| config.toggles.queued &= queued);
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}")).maps
}

fn assert_agree(truth: &[Vec<ExpectedTexel>], maps: &[ViewMaps], what: &str) {
    assert_eq!(truth.len(), maps.len(), "{what}");
    for (truth, maps) in truth.iter().zip(maps) {
        compare_maps(truth, maps, TOLERANCE).unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
    }
}

#[test]
fn crowds_of_gaussians_agree_with_64_bits() {
    let neutral = Material { neutral: true, ..splats(Transfer::Filter) };
    let materials = [(splats(Transfer::Filter), 64), (neutral, 64), (medium(1.5), 24)];
    for (number, crowd) in (0..).zip([MIXED, FAINT]) {
        for (i, (material, size)) in (0..).zip(&materials) {
            for (j, kind) in (0..).zip(kinds()) {
                let scene =
                    crowd.scene(kind, material.clone(), *size, 100 + 9 * number + 3 * i + j);
                let truth = truth(&scene);
                let what = format!("crowd {number}, material {i}, {kind:?}");
                assert_agree(&truth, &render_maps(&scene, &shadow_views(&scene)).0, &what);
                assert_agree(&truth, &maps(Tier::Native, &scene, true), &what);
            }
        }
    }
}

/// Kernels for splats alone, on both tiers, with and without an opaque caster among them.
#[test]
fn splats_agree_with_64_bits_in_every_walk() {
    for kind in kinds() {
        for blocked in [false, true] {
            let mut scene = MIXED.scene(kind, splats(Transfer::Filter), 32, 7);
            if blocked {
                scene.materials.push(material(Transfer::Opaque));
                let corners =
                    [Vec3::new(-0.9, 0.6, -0.5), Vec3::new(0.8, -0.7, 0.9), Vec3::splat(-0.8)];
                scene.triangles.push(triangle(corners, 1));
            }
            let truth = truth(&scene);
            for tier in TIERS {
                let walks = if tier == Tier::Native { &[true, false][..] } else { &[false] };
                for &queued in walks {
                    let what = format!("{tier:?}, {kind:?}, queued {queued}, blocked {blocked}");
                    assert_agree(&truth, &maps(tier, &scene, queued), &what);
                }
            }
        }
    }
}
