//! Queues in which lavapipe collects discs change no bit of a map; nor do columns of four texels instead of
//! eight, or pairs sorted and binned by workgroups, as on GPUs.
use super::pipeline::lights;
use crate::common::{
    gpu,
    rounding::{FORMS, nearly_same, rounds_as_the_cpu},
    scenes::{empty, material, random_discs, triangle},
};
use gobo::{
    glam::Vec3,
    gpu::Tier,
    model::{Receiver, Transfer, Triangle},
    stage::sort::Partition,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

fn scene() -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter), material(Transfer::Opaque)]);
    scene.lights = lights();
    scene
}

fn opaque() -> Triangle {
    triangle([Vec3::new(-1.0, 0.1, -1.5), Vec3::new(1.5, 0.0, -0.5), Vec3::Z], 1)
}

/// `count` discs, with radii multiplied by `size` and opacities by `opacity`.
fn assert_same(renderer: &mut Renderer, scene: &mut Scene, count: usize, size: f32, opacity: f32) {
    scene.particles = random_discs(count, 5);
    for particle in &mut scene.particles {
        particle.radius *= size;
        particle.color.w *= opacity;
    }
    let mut maps = |(queued, columns)| {
        renderer.configure(|config| {
            // Queues have a disc for each of eight lanes.
            config.toggles.queued = queued && config.tuning.queued;
            config.tuning.columns = columns;
            config.tuning.partition = if columns { Partition::Serial } else { Partition::Wide };
        });
        let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
        renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}")).maps
    };
    let is_software = rounds_as_the_cpu(&gpu(Tier::Native));
    let in_a_queue = maps((true, true));
    for form in [(false, true), (false, false)] {
        for (a, b) in in_a_queue.iter().zip(&maps(form)) {
            let same = a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque;
            let [a, b] = [a, b].map(std::slice::from_ref);
            let same = same || (!is_software && nearly_same(a, b, FORMS).is_ok());
            assert!(same, "{count} discs of opacity {opacity}, {form:?}");
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

/// Mean difference of light, over depths and channels, between nodes that texels share and each texel's own.
const SHARED: f64 = 2e-3;

/// Crowded tiles of curves, in orthographic and perspective views: black texels, tiles of several segments,
/// and pairs that do not fit. Texels with few hits have a node for each.
#[test]
fn a_queue_of_discs_ends_nodes_together() {
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let mut scene = scene();
    scene.shadow.size = 64;
    scene.shadow.receiver = Receiver::Curve;
    scene.triangles.push(opaque());
    let cases = [
        (300, 0.5, 0.5, 1 << 24),
        (6_000, 0.2, 0.05, 1 << 24),
        (12_000, 1.0, 0.05, 1 << 24),
        (6_000, 0.5, 1.0, 1 << 12),
    ];
    for (count, size, opacity, budget) in cases {
        scene.shadow.pair_budget = budget;
        scene.particles = random_discs(count, 5);
        for particle in &mut scene.particles {
            particle.radius *= size;
            particle.color.w *= opacity;
        }
        let mut maps = |queued| {
            renderer.configure(|config| config.toggles.queued = queued && config.tuning.queued);
            let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
            renderer.render(&scene, &options).unwrap_or_else(|error| panic!("{error}")).maps
        };
        let (mut few, mut sum, mut samples) = (0, 0.0, 0);
        for (a, b) in maps(true).iter().zip(&maps(false)) {
            let what = format!("{count} discs of opacity {opacity}");
            assert!(a.opaque == b.opaque, "{what}: opaque");
            let pairs = a.nearest.iter().zip(&b.nearest);
            let apart: Vec<_> =
                pairs.enumerate().filter(|(_, (a, b))| (**a - **b).abs() > 1e-6).take(9).collect();
            assert!(apart.is_empty(), "{what}: nearest {apart:?}");
            let pairs = a.filter.iter().zip(&b.filter);
            let apart: Vec<_> = pairs
                .enumerate()
                .filter(|(_, (a, b))| (0..3).any(|i| (a[i] - b[i]).abs() > 1e-3))
                .take(4)
                .collect();
            assert!(apart.is_empty(), "{what}: filter {apart:?}");
            let (a, b) = (a.curve.as_ref().unwrap(), b.curve.as_ref().unwrap());
            for texel in 0..b.texel_count() {
                let steps = b.ramps(texel).filter(|(start, end, _)| start == end).count();
                let is_exact = steps == b.ramps(texel).count() && steps < b.nodes;
                few += usize::from(is_exact);
                let mut last = Vec3::ONE;
                for z in (0..100).map(|i| (i as f32 + 0.5) / 100.0) {
                    let (light, own) = (a.light_at(texel, z), b.light_at(texel, z));
                    let apart = (light - own).abs();
                    // Depths are rounded.
                    let most = b.light_at(texel, z - 2.0 / 65535.0) + 1e-3;
                    let least = b.light_at(texel, z + 2.0 / 65535.0) - 1e-3;
                    let is_near = light.cmple(most).all() && light.cmpge(least).all();
                    assert!(
                        !is_exact || is_near,
                        "{what}, {texel} at {z}: {light} {own}, {:?} {:?}",
                        a.ramps(texel).collect::<Vec<_>>(),
                        b.ramps(texel).collect::<Vec<_>>()
                    );
                    assert!(light.cmple(last + 1e-6).all(), "{what}: light grows at {z}");
                    last = light;
                    sum += f64::from(apart.element_sum());
                    samples += 3;
                }
            }
        }
        let mean = sum / f64::from(samples);
        println!("{count} discs of opacity {opacity}: {mean}, {few} texels of few hits");
        assert!(mean < SHARED && few > 0, "{count} discs of opacity {opacity}: {mean}, {few}");
    }
}
