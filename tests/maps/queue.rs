//! Queues that lavapipe collects discs in change no bit of a map, nor do columns of four texels instead of eight, and
//! pairs sorted and binned by workgroups, as on GPUs.
use super::pipeline::lights;
use crate::common::{
    gpu,
    scenes::{empty, material, random_discs, triangle},
};
use gobo::{
    glam::Vec3,
    internals::{gpu::Tier, stage::sort::Shape},
    model::{Receiver, Transfer, Triangle},
    render::{RenderOptions, Renderer},
    scene::Scene,
};

fn scene() -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter), material(Transfer::Opaque)]);
    scene.lights = lights();
    scene
}

fn opaque() -> Triangle {
    triangle([Vec3::new(-1.0, 0.1, -1.5), Vec3::new(1.5, 0.0, -0.5), Vec3::Z], 1)
}

/// `count` discs, of radii times `size` and opacities times `opacity`.
fn assert_same(renderer: &mut Renderer, scene: &mut Scene, count: usize, size: f32, opacity: f32) {
    scene.particles = random_discs(count, 5);
    for particle in &mut scene.particles {
        particle.radius *= size;
        particle.color.w *= opacity;
    }
    let mut maps = |(queued, columns)| {
        renderer.configure(|config| {
            // Queues have a disc for each of eight lanes.
            config.toggles.queued = queued && config.profile.queued;
            config.profile.columns = columns;
            config.profile.shape = if columns { Shape::Serial } else { Shape::Wide };
        });
        let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
        renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}")).maps
    };
    let in_a_queue = maps((true, true));
    for form in [(false, true), (false, false)] {
        for (a, b) in in_a_queue.iter().zip(&maps(form)) {
            let same = a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque;
            assert!(same && a.curve == b.curve, "{count} discs of opacity {opacity}, {form:?}");
        }
    }
}

/// Sparse and crowded tiles, with and without opaque casters, in orthographic and perspective views; black
/// texels end a walk early.
#[test]
fn a_queue_of_discs_changes_no_bit() {
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let mut scene = scene();
    scene.shadow.size = 80;
    let cases = [
        (300, 1.0, 1.0, false),
        (20_000, 0.3, 0.05, false),
        (20_000, 0.3, 0.05, true),
        (5_000, 1.0, 1.0, true),
    ];
    for (count, size, opacity, has_opaque) in cases {
        scene.triangles = has_opaque.then(opaque).into_iter().collect();
        assert_same(&mut renderer, &mut scene, count, size, opacity);
    }
}

/// Crowded tiles of curves, in orthographic and perspective views: texels of few hits at the discs' rims, black ones,
/// tiles of several segments, and pairs that do not fit.
#[test]
fn a_queue_of_discs_changes_no_curve() {
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let mut scene = scene();
    scene.shadow.size = 64;
    scene.shadow.receiver = Receiver::Curve;
    scene.triangles.push(opaque());
    let cases =
        [(6_000, 0.2, 0.05, 1 << 24), (12_000, 1.0, 0.05, 1 << 24), (6_000, 0.5, 1.0, 1 << 12)];
    for (count, size, opacity, budget) in cases {
        scene.shadow.pair_budget = budget;
        assert_same(&mut renderer, &mut scene, count, size, opacity);
    }
}
