//! Grids that change, and invalid grids.
use super::bricks::{DISC, kinds, lump, scene_of};
use crate::common::{Tier, gpu};
use gobo::{
    glam::Vec3,
    model::{Density, Transfer, Voxels},
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

/// Changes of a grid are uploaded: the maps equal those of a new upload.
#[test]
fn a_changed_grid_is_uploaded() {
    let first = scene_of(kinds()[1], lump());
    let mut changes = vec![first.clone(); 4];
    changes[0].grids[0].extinction = Vec3::new(0.1, 0.8, 1.3);
    changes[1].grids[0].world_from_index.translation.x += 0.1;
    let brick = &mut changes[2].grids[0].bricks[5];
    brick.density = Density::Voxels(Voxels::new(|place| place.x as f32 * 0.1));
    changes[3].grids[0].bricks.truncate(9);
    let options = RenderOptions { maps: true, maps_only: true, keep: true, ..Default::default() };
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    for scene in changes {
        let before = renderer.render(&first, &options).unwrap();
        let after = renderer.render(&scene, &options).unwrap();
        let new = Renderer::on(gpu(Tier::Native)).unwrap().render(&scene, &options).unwrap();
        assert_eq!(after.maps[0].filter, new.maps[0].filter);
        assert_eq!(after.maps[0].nearest, new.maps[0].nearest);
        assert_ne!(after.maps[0].filter, before.maps[0].filter);
    }
}

#[test]
fn grids_that_cannot_be_used_are_named() {
    let problem = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene_of(kinds()[0], lump());
        change(&mut scene);
        let gpu = gpu(Tier::Native);
        let views = shadow_views(&scene);
        let mut shadows = crate::common::shadows(&gpu);
        let error = shadows.prepare(&scene.casters(), &views, &scene.shadow).err();
        error.map_or_else(String::new, |error| error.to_string())
    };
    let set_density = |scene: &mut Scene, density: f32| {
        scene.grids[0].bricks[1].density = Density::Voxels(Voxels::new(|_| density));
    };
    type Change<'a> = &'a dyn Fn(&mut Scene);
    let cases: [(Change<'_>, &str); 9] = [
        (&|_| (), ""),
        (&|scene| set_density(scene, f32::NAN), "grid 0 cannot be used: its densities"),
        (&|scene| set_density(scene, -0.5), "its densities"),
        (&|scene| set_density(scene, 7e4), "its densities"),
        (&|scene| scene.grids[0].world_from_index.matrix3.x_axis *= 0.0, "its transform"),
        (&|scene| scene.grids[0].factor = f32::INFINITY, "its factor"),
        (&|scene| scene.grids[0].extinction.y = -1.0, "its extinction"),
        (&|scene| scene.grids[0].material = DISC, "its material must have the shape `Brick`"),
        (&|scene| scene.materials[0].transfer = Transfer::Opaque, "its material must filter"),
    ];
    for (change, expected) in cases {
        let problem = problem(change);
        assert!(
            problem.contains(expected) && problem.is_empty() == expected.is_empty(),
            "{problem}"
        );
    }
}
