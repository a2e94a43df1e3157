//! Coloured dithering: kernels against the CPU reference, all paths alike, and unbiased per channel.
use crate::common::{
    TIERS, map_frame, render,
    scenes::{Chance, empty, light, material, pane, particle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    gpu::Tier,
    model::{LightKind, Material, Particle, Pattern, Profile, Receiver, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_picture::Frame;
use gobo_reference as reference;
use gobo_scene::Scene;

/// Share of texels that rounding may decide, where a ray grazes an edge or an opacity equals a threshold; a
/// softened texel reads a whole window.
const GRAZED: f64 = 1e-3;
const GRAZED_SOFT: f64 = 0.02;

fn glass(pattern: Pattern, tint: Vec4) -> Material {
    Material { pattern, tint, profile: Profile::Flat, ..material(Transfer::Dither) }
}

/// Coloured panes, discs and puffs, gel and a wall.
fn mixture(pattern: Pattern) -> Scene {
    let mut scene = empty(vec![
        glass(pattern, Vec4::new(0.9, 0.4, 0.1, 0.7)),
        Material { shape: Shape::Puff, ..glass(pattern, Vec4::new(0.2, 0.5, 0.9, 0.8)) },
        Material { tint: Vec4::new(0.2, 0.9, 0.4, 0.5), ..material(Transfer::Filter) },
        material(Transfer::Opaque),
    ]);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
        light(LightKind::Point { position: Vec3::new(0.2, 0.3, 3.0) }),
    ];
    scene.lights[1].size = Some(48);
    scene.ambient = Vec3::splat(0.2);
    let mut chance = Chance::new(3);
    for id in 0..150 {
        let color = chance.vec3(0.2, 1.0).extend(chance.unit());
        let (center, radius) = (chance.vec3(-1.5, 1.5), chance.within(0.05, 0.4));
        let material = [0, 1, 2][chance.below(3)];
        scene.particles.push(Particle { material, id, ..particle(center, radius, color) });
    }
    scene.triangles.extend(pane(0.05, 0.8, 0));
    scene.triangles.extend(pane(0.2, 2.5, 3));
    scene.shadow.colored = true;
    scene
}

fn cpu(scene: &Scene) -> Vec<ViewMaps> {
    reference::render_maps(scene, &shadow_views(scene)).0
}

fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    let (mut apart, mut count) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.colored.len(), b.colored.len());
        for i in 0..a.filter.len() {
            let light = (0..3).all(|c| (a.filter[i][c] - b.filter[i][c]).abs() < 2e-3);
            let near = |a: f32, b: f32| (a - b).abs() < 2e-6;
            let depths = near(a.nearest[i], b.nearest[i]) && near(a.opaque[i], b.opaque[i]);
            let channels =
                a.colored.is_empty() || (0..3).all(|c| near(a.colored[i][c], b.colored[i][c]));
            apart += usize::from(!(light && depths && channels));
            count += 1;
        }
    }
    f64::from(apart as u32) / f64::from(count)
}

#[test]
fn gpu_matches_reference() {
    let cases = [
        (Pattern::Bayer4, false, GRAZED),
        (Pattern::Hashed, false, GRAZED),
        (Pattern::Blue, true, GRAZED_SOFT),
        (Pattern::Hashed, true, GRAZED_SOFT),
    ];
    for (pattern, soften, most) in cases {
        let mut scene = mixture(pattern);
        scene.shadow.soften = soften;
        let expected = cpu(&scene);
        for tier in TIERS {
            let apart = share_apart(&map_frame(tier, &scene).maps, &expected);
            assert!(apart <= most, "{pattern:?} {tier:?} {soften}: {apart}");
        }
    }
    let other = cpu(&mixture(Pattern::Bayer8));
    assert!(share_apart(&other, &cpu(&mixture(Pattern::Bayer4))) > GRAZED);
}

#[test]
fn pictures_match_the_reference() {
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let mut scene = mixture(Pattern::Blue);
        scene.shadow.receiver = receiver;
        let views = shadow_views(&scene);
        let expected = reference::render_picture(&scene, &views, &cpu(&scene), &shadow_views).rgb;
        let mut grey = scene.clone();
        grey.shadow.colored = false;
        for tier in tiers(Tier::Native) {
            let apart = |scene: &Scene| {
                let actual = render(tier, scene).picture.rgb;
                let channels = expected.iter().flatten().zip(actual.iter().flatten());
                channels.filter(|(a, b)| a.abs_diff(**b) > 4).count() as f64
                    / (3 * expected.len()) as f64
            };
            assert!(apart(&scene) <= 3e-3, "{receiver:?} {tier:?}: {}", apart(&scene));
            assert!(apart(&grey) > 3e-3, "the check can fail");
        }
    }
}

#[test]
fn every_path_draws_the_same() {
    assert_paths_agree(TIERS[1]);
}

#[test]
#[ignore = "kernels of the other tier: make test-all"]
fn every_path_draws_the_same_on_the_other_tier() {
    assert_paths_agree(TIERS[0]);
}

/// Tiles and the overflow path.
fn assert_paths_agree(tier: Tier) {
    let mut scene = mixture(Pattern::Bayer8);
    scene.particles.iter_mut().for_each(|p| p.material %= 2);
    let mut overflowing = scene.clone();
    overflowing.shadow.pair_budget = 60;
    let bits = |frame: &Frame| -> Vec<u32> {
        let depths = frame.maps.iter().flat_map(|m| m.colored.as_flattened());
        depths.map(|z| z.to_bits()).collect()
    };
    let [whole, partly] = [&scene, &overflowing].map(|scene| map_frame(tier, scene));
    assert!(partly.counters.overflowed > 0);
    assert!(bits(&partly) == bits(&whole), "{tier:?}");
}

#[test]
#[ignore = "many casters: make test-all"]
fn segments_draw_what_the_reference_does() {
    let mut long = mixture(Pattern::Bayer8);
    long.particles.iter_mut().for_each(|p| p.material %= 2);
    // More pairs in a tile than a segment holds, far behind all others but fully visible.
    long.particles.extend((0..3000).map(|id| {
        let center = Vec3::new(0.0, 0.0, -0.5 - id as f32 * 1e-4);
        Particle { id, ..particle(center, 0.3, Vec4::new(0.5, 0.9, 0.2, 0.01)) }
    }));
    for tier in TIERS {
        let apart = share_apart(&map_frame(tier, &long).maps, &cpu(&long));
        assert!(apart <= GRAZED, "{tier:?}: {apart}");
    }
}

/// Each channel has its own transmittance, and two layers have the product.
#[test]
fn each_channel_lets_its_transmittance_through() {
    let tints = [Vec4::new(0.9, 0.4, 0.1, 0.7), Vec4::new(0.2, 0.5, 0.9, 0.8)];
    for pattern in Pattern::ALL {
        let mut scene = empty(tints.map(|tint| glass(pattern, tint)).to_vec());
        scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
        scene.shadow.colored = true;
        scene.shadow.size = 256;
        for id in 0..2 {
            // Half the edge of a window of 4 m, less its margin.
            let faces = pane(0.2 + 0.1 * id as f32, 1.96, id);
            scene.triangles.extend(faces.map(|face| gobo::model::Triangle { id: id + 9, ..face }));
        }
        let maps = map_frame(TIERS[1], &scene).maps.remove(0);
        for channel in 0..3 {
            let open = maps.colored.iter().filter(|z| z[channel] == 1.0).count() as f32;
            let share = open / maps.colored.len() as f32;
            let exact: f32 = tints.iter().map(|t| 1.0 - t.w * (1.0 - t[channel])).product();
            // Tolerance: a level of the coarsest pattern, and a map slightly larger than the panes.
            assert!((share - exact).abs() < 0.08, "{pattern:?} {channel}: {share} not {exact}");
        }
    }
}
