//! Softening of dithered shadows: kernels against the CPU reference, and the CPU reference against the exact
//! grey.
use crate::common::{
    TIERS, map_frame,
    scenes::{empty, flat_view, light, material, pane, particle},
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Pattern, Profile, Transfer, dither::window},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::{MapTexel, receive, render_maps};
use gobo_scene::Scene;

const PLAIN: Vec4 = Vec4::new(0.0, 0.0, 0.0, 0.37);

fn dithered(pattern: Pattern) -> Material {
    Material { pattern, profile: Profile::Flat, ..material(Transfer::Dither) }
}

/// Three panes of 37% in a row, dithered or exact.
fn panes(material: Material, count: u32) -> Scene {
    let mut scene = empty(vec![Material { tint: PLAIN, ..material }]);
    for id in 0..count {
        let faces = pane(0.2 + 0.1 * id as f32, 100.0, 0);
        scene.triangles.extend(faces.map(|face| gobo::model::Triangle { id, ..face }));
    }
    scene
}

fn maps(scene: &Scene) -> ViewMaps {
    render_maps(scene, &[flat_view(128, 1.0)]).0.remove(0)
}

/// Light at depth 0.9.
fn light_below(maps: &ViewMaps) -> Vec<f32> {
    let texels = maps.filter.iter().zip(&maps.nearest).zip(&maps.opaque);
    let light = |((&filter, &nearest), &opaque)| {
        receive(0.9, &MapTexel { filter: Vec3::from(filter), nearest, opaque }, 1e-3).x
    };
    texels.map(light).collect()
}

fn rms(light: &[f32], exact: f32) -> f32 {
    (light.iter().map(|l| (l - exact).powi(2)).sum::<f32>() / light.len() as f32).sqrt()
}

#[test]
fn softened_shadows_approach_the_exact_filter() {
    for pattern in Pattern::ALL {
        for count in [1, 2] {
            let mut scene = panes(dithered(pattern), count);
            let exact = (1.0 - PLAIN.w).powi(count as i32);
            let before = rms(&light_below(&maps(&scene)), exact);
            scene.shadow.soften = true;
            let after = rms(&light_below(&maps(&scene)), exact);
            assert!(before > 0.4, "{pattern:?}: {before}");
            assert!(after < 0.3 * before, "{pattern:?} {count}: {before} to {after}");
        }
    }
}

/// Over one window, an ordered pattern has exactly the coverage of its level.
#[test]
fn ordered_patterns_become_exact() {
    for pattern in Pattern::ALL {
        let Some(levels) = pattern.levels() else { continue };
        let mut scene = panes(dithered(pattern), 1);
        scene.materials[0].tint.w = 0.25;
        scene.shadow.soften = true;
        let light = light_below(&maps(&scene));
        let edge = window(&scene.materials) as usize / 2;
        let (size, inside) = (128, edge..128 - edge);
        for y in inside.clone() {
            for x in inside.clone() {
                let error = (light[y * size + x] - 0.75).abs();
                let most =
                    if pattern == Pattern::Checkerboard { 1.0 / levels as f32 } else { 1e-3 };
                assert!(error <= most, "{pattern:?} {x} {y}: {error}");
            }
        }
    }
}

#[test]
fn whole_surfaces_keep_their_depths_and_edges() {
    let mut scene = panes(dithered(Pattern::Bayer8), 1);
    scene.materials.push(material(Transfer::Opaque));
    scene.triangles.extend(pane(0.6, 20.0, 1));
    let hard = maps(&scene);
    scene.shadow.soften = true;
    let soft = maps(&scene);
    let middle = 64 * 128 + 64;
    assert!((soft.opaque[middle] - 0.6).abs() < 1e-6, "{}", soft.opaque[middle]);
    assert!((soft.nearest[middle] - 0.2).abs() < 1e-6);
    assert_eq!(soft.opaque[0], 1.0);
    // Without dithered casters nothing changes.
    scene.triangles.retain(|face| face.material == 1);
    scene.shadow.soften = false;
    let plain = maps(&scene);
    scene.shadow.soften = true;
    let same = maps(&scene);
    assert!(plain.opaque == same.opaque && plain.filter == same.filter);
    assert!(plain.opaque != hard.opaque);
}

#[test]
fn gpu_matches_reference() {
    for pattern in [Pattern::Bayer4, Pattern::Blue, Pattern::Hashed] {
        let mut scene = empty(vec![
            dithered(pattern),
            Material { tint: Vec4::new(0.2, 0.9, 0.4, 0.5), ..material(Transfer::Filter) },
            material(Transfer::Opaque),
        ]);
        scene.lights = vec![
            light(LightKind::Directional { direction: Vec3::NEG_Z }),
            light(LightKind::Point { position: Vec3::new(0.2, 0.3, 2.0) }),
        ];
        scene.lights[1].size = Some(48);
        for i in 0..6 {
            let center = Vec3::new(i as f32 * 0.4 - 1.0, 0.1, -1.0 - 0.2 * i as f32);
            let color = Vec4::new(0.5, 0.5, 0.5, 0.2 + 0.1 * i as f32);
            scene.particles.push(particle(center, 0.7, color));
            scene.particles[i].id = i as u32;
        }
        scene.triangles.extend(pane(0.25, 0.8, 1));
        scene.triangles.extend(pane(0.5, 0.6, 2));
        scene.shadow.soften = true;
        let expected = render_maps(&scene, &shadow_views(&scene)).0;
        for tier in TIERS {
            let actual = map_frame(tier, &scene).maps;
            for (a, b) in actual.iter().zip(&expected) {
                let apart = (0..a.filter.len())
                    .filter(|&i| {
                        let light = (0..3).all(|c| (a.filter[i][c] - b.filter[i][c]).abs() < 2e-3);
                        let nearest = (a.nearest[i] - b.nearest[i]).abs() < 2e-6;
                        !(light && nearest && (a.opaque[i] - b.opaque[i]).abs() < 2e-6)
                    })
                    .count();
                // Texels within a window of a disc's edge depend on it.
                assert!(apart as f32 <= 0.002 * a.filter.len() as f32, "{pattern:?} {apart}");
            }
        }
        scene.shadow.soften = false;
        let hard = map_frame(TIERS[0], &scene).maps;
        assert!(hard[0].opaque != expected[0].opaque);
    }
}
