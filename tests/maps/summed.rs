//! Sums for maps that are merged with others: made tile by tile, like filters, against the CPU reference.
use crate::common::{Tier, files::read, gpu, tiers};
use gobo::{
    model::Receiver,
    records::{SATURATED, ViewMaps},
};
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene::Scene;

/// Splats of many tiles, discs, puffs, fur and glass around an opaque ball. `splats`: their number.
fn clutter(splats: u32) -> Scene {
    let toml = format!(
        "[shadow]\nsize = 96\ndetail = false\n[[light]]\nkind = 'directional'\ndirection = [0.2, -1, 0.1]\n\
         [[light]]\nkind = 'spot'\nposition = [1, 4, 1]\ndirection = [-0.2, -1, -0.2]\nangle = 60\n\
         [[material]]\nname = 'smoke'\ntint = [0.9, 0.5, 0.3, 0.05]\n\
         [[material]]\nname = 'puff'\nshape = 'puff'\ntint = [0.2, 0.5, 0.9, 0.1]\n\
         [[material]]\nname = 'glass'\ntint = [0.3, 0.9, 0.4, 0.6]\n\
         [[material]]\nname = 'solid'\ntransfer = 'opaque'\n\
         [[splats]]\ncast = 'own'\nmaterial = 'smoke'\n\
         generate = {{ kind = 'cloud', count = {splats}, radius = 0.2, center = [0, 1, 0] }}\n\
         [[particles]]\nmaterial = 'smoke'\n\
         generate = {{ kind = 'cloud', count = 800, radius = 0.15, center = [0, 1, 0] }}\n\
         [[particles]]\nmaterial = 'puff'\n\
         generate = {{ kind = 'dust', count = 100, radius = 0.1, min = [-1, 0, -1], max = [1, 2, 1] }}\n\
         [[shape]]\nname = 'ball'\nkind = 'sphere'\nmaterial = 'glass'\nscale = [0.8, 0.8, 0.8]\n\
         [[shape]]\nkind = 'box'\nmaterial = 'solid'\ntranslation = [0, 1, 0]\nscale = [0.3, 0.3, 0.3]\n\
         [[strands]]\nmaterial = 'glass'\n\
         generate = {{ kind = 'fur', on = 'ball', count = 50, length = 0.2, radius = 0.02 }}\n"
    );
    let mut scene = read(&toml).unwrap_or_else(|error| panic!("{error}"));
    scene.shadow.receiver = Receiver::Nearest;
    scene
}

fn summed(mut renderer: Renderer, scene: &Scene) -> Frame {
    let options =
        RenderOptions { maps: true, maps_only: true, sums: true, ..RenderOptions::default() };
    renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// Logarithms differ by a step of 2^-16 per caster, on either side of the dither: at most `casters` on a ray.
fn assert_near(a: &[ViewMaps], b: &[ViewMaps], casters: u32) {
    assert_eq!((a.len(), b.len()), (2, 2));
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.sums.len(), b.sums.len());
        assert!(a.sums.iter().filter(|sum| sum[0] > 0).count() > a.sums.len() / 20);
        for (a, b) in a.sums.iter().zip(&b.sums) {
            for channel in 0..3 {
                let [a, b] = [a, b].map(|sum| sum[channel].min(SATURATED));
                assert!(a.abs_diff(b) <= casters, "{a}, not {b}");
            }
            let [a, b] = [a, b].map(|sum| f32::from_bits(1.0_f32.to_bits() - sum[3]));
            assert!((a - b).abs() < 1e-5, "{a}, not {b}");
        }
    }
}

#[test]
fn sums_are_made_in_tiles() {
    let scene = clutter(3000);
    let mut crowded = scene.clone();
    crowded.shadow.pair_budget = 5000;
    let reference = summed(Renderer::on_cpu(), &scene).maps;
    for tier in tiers(Tier::Native) {
        let frame = summed(Renderer::on(gpu(tier)).unwrap(), &scene);
        // Each tile of a caster took a workgroup when all casters were scattered.
        assert_eq!(frame.counters.overflowed, 0);
        assert!(frame.counters.segments > 0, "no tile of several segments");
        assert_near(&frame.maps, &reference, 64);
        // In parts of the tiles, or scattered, where the pairs do not fit.
        for parts in [true, false] {
            let mut renderer = Renderer::on(gpu(tier)).unwrap();
            renderer.configure(|config| config.toggles.parts = parts);
            let few = summed(renderer, &crowded);
            assert!(few.counters.overflowed > 0, "all pairs fit");
            for (few, all) in few.maps.iter().zip(&frame.maps) {
                let is_same = |(few, all): (&[u32; 4], &[u32; 4])| {
                    let is = |i: usize| few[i].min(SATURATED) == all[i].min(SATURATED);
                    is(0) && is(1) && is(2) && few[3] == all[3]
                };
                assert!(few.sums.iter().zip(&all.sums).all(is_same), "parts: {parts}");
            }
        }
    }
}
