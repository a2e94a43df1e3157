//! Invisible casters, and visible casters without shadows.
use crate::common::{
    Tier,
    scenes::{empty, light, material, particle, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Particle, Shape, Transfer},
    records::{Picture, ViewMaps},
    view::shadow_views,
};
use gobo_picture::Frame;
use gobo_reference::{render_maps, render_picture};
use gobo_scene::Scene;

/// A pane and a disc of each material over a large floor that sets the scene's bounds.
fn over_a_floor(proxies: Vec<Material>) -> Scene {
    let floor = Material { tint: Vec4::splat(0.8), ..material(Transfer::Opaque) };
    let mut scene = empty(vec![floor]);
    scene.ambient = Vec3::splat(0.2);
    scene.lights.push(light(LightKind::Directional { direction: Vec3::new(0.1, -1.0, 0.2) }));
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * 6.0;
    for positions in [
        [corner(-1.0, 0.0, -1.0), corner(-1.0, 0.0, 1.0), corner(1.0, 0.0, 1.0)],
        [corner(-1.0, 0.0, -1.0), corner(1.0, 0.0, 1.0), corner(1.0, 0.0, -1.0)],
        // Fixes the bounds of the scene.
        [corner(-1.0, 0.0, -1.0), corner(-1.0, 1.5, -1.0), corner(-1.0, 0.0, -0.99)],
    ] {
        scene.triangles.push(triangle(positions, 0));
    }
    for (proxy, i) in proxies.into_iter().zip(1u8..) {
        scene.materials.push(proxy);
        let at = |x: f32, z: f32| Vec3::new(x, f32::from(i), z);
        let material = u32::from(i);
        scene.triangles.push(triangle([at(-1.0, 0.5), at(0.0, 0.5), at(-0.5, 1.5)], material));
        let color = Vec4::new(0.9, 0.5, 0.2, 0.8);
        let center = Vec3::new(0.7, f32::from(i), 0.3);
        scene.particles.push(Particle { material, ..particle(center, 0.6, color) });
    }
    scene
}

fn kinds() -> Vec<Material> {
    let tint = Vec4::new(0.9, 0.3, 0.2, 0.7);
    [
        Transfer::Opaque,
        Transfer::Cutout,
        Transfer::Dither,
        Transfer::Filter,
        Transfer::Gain,
        Transfer::None,
    ]
    .map(|transfer| Material { tint, shape: Shape::Disc, ..material(transfer) })
    .to_vec()
}

/// Checks that the maps and the picture of `render` show exactly the right casters of several materials.
fn check(kinds: &[Material], render: &dyn Fn(&Scene) -> (Vec<ViewMaps>, Picture)) {
    let of = |visible: bool, casts: bool| {
        kinds.iter().map(|kind| Material { visible, casts, ..kind.clone() }).collect()
    };
    let sight = |proxies: Vec<Material>| {
        let mut scene = over_a_floor(proxies);
        scene.lights[0].casts = false;
        render(&scene).1.rgb
    };
    let shadow = |proxies: Vec<Material>| {
        let maps = render(&over_a_floor(proxies)).0.remove(0);
        (maps.filter, maps.nearest, maps.opaque)
    };
    let (no_shadow, no_sight) = (shadow(Vec::new()), sight(Vec::new()));
    let (its_shadow, its_sight) = (shadow(of(true, true)), sight(of(true, true)));
    let casts = kinds.iter().any(|kind| kind.transfer != Transfer::None);
    assert_eq!(its_shadow != no_shadow, casts);
    assert!(its_sight != no_sight);
    assert!(shadow(of(false, true)) == its_shadow, "casts unseen");
    assert!(sight(of(false, true)) == no_sight, "is unseen");
    assert!(shadow(of(true, false)) == no_shadow, "casts nothing");
    assert!(sight(of(true, false)) == its_sight, "is seen without casting");
    assert!(shadow(of(false, false)) == no_shadow, "is not there");
    assert!(sight(of(false, false)) == no_sight, "is nowhere");
}

#[test]
fn proxies_of_the_reference() {
    for kind in kinds() {
        check(&[kind], &|scene| {
            let views = shadow_views(scene);
            let (maps, _) = render_maps(scene, &views);
            let picture = render_picture(scene, &views, &maps, &shadow_views);
            (maps, picture)
        });
    }
}

#[test]
fn proxies_of_the_kernels() {
    for tier in tiers(Tier::Native) {
        check(&kinds(), &|scene| {
            let Frame { maps, picture, .. } = crate::common::render(tier, scene);
            (maps, picture)
        });
    }
}
