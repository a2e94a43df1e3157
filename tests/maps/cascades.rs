//! Cascades: their splits, their stability, and their seams.
use crate::{
    common::{
        Tier, map_frame,
        scenes::{Chance, material, particle},
        tiers,
    },
    maps::lights::{GLASS, STONE, ground, light_at, maps, moved, roof},
};
use gobo::{
    glam::{IVec2, Vec3, Vec4},
    model::{Cascades, Material, Profile, Transfer, View, ViewRole},
    records::ViewMaps,
    view::{shadow_views, splits},
};

#[test]
fn splits_are_even_by_ratios_and_between() {
    let of = |lambda| splits(&Cascades { count: 3, lambda, ..Cascades::default() }, 1000.0);
    let close = |found: Vec<f32>, expected: [f32; 3]| {
        let apart = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-5 * b;
        assert!(!found.iter().zip(&expected).any(apart), "{found:?}, not {expected:?}");
    };
    // The range starts at a thousandth: 1 m.
    close(of(0.0), [334.0, 667.0, 1000.0]);
    close(of(1.0), [10.0, 100.0, 1000.0]);
    close(of(0.5), [172.0, 383.5, 1000.0]);
    assert_eq!(splits(&Cascades { count: 1, ..Cascades::default() }, 7.0), [7.0]);
}

/// Texels by which the window of a cascade moved between two camera positions.
fn shift(a: &View, b: &View) -> IVec2 {
    let by = (b.view_from_world.w_axis - a.view_from_world.w_axis) * a.scale;
    let whole = by.round();
    // A thousandth of a texel is invisible.
    assert!((by - whole).abs().max_element() < 1e-3, "{} moved by {by} texels", a.name);
    assert_eq!((a.scale, a.near, a.far, a.size), (b.scale, b.near, b.far, b.size));
    assert_eq!(a.view_from_world.row(2), b.view_from_world.row(2), "depths stay");
    IVec2::new(whole.x as i32, -whole.y as i32)
}

/// Texels that both maps contain: index in `a`, index in `b`.
fn common_texels(size: u32, by: IVec2) -> impl Iterator<Item = (usize, usize)> {
    let size = size as i32;
    (0..size * size).filter_map(move |i| {
        let (x, y) = (i % size + by.x, i / size + by.y);
        let inside = (0..size).contains(&x) && (0..size).contains(&y);
        inside.then_some((i as usize, (y * size + x) as usize))
    })
}

/// Texels are powers of two and casters are on a grid: every sum is exact, so that maps differ only by a
/// shift of whole texels.
#[test]
fn camera_motion_shifts_maps_bit_for_bit() {
    let cascades = Cascades { count: 2, lambda: 0.0, fade: 0.0, range: Some(10.7) };
    let mut scene = ground(cascades, Vec3::NEG_Y);
    let soft = Material { profile: Profile::Soft, ..material(Transfer::Smoke) };
    scene.materials.push(soft);
    let mut chance = Chance::new(3);
    let mut grid = |low: f32, high: f32| (chance.within(low, high) * 64.0).round() / 64.0;
    for id in 0..60 {
        let center = Vec3::new(grid(-20.0, 20.0), grid(0.5, 4.0), grid(-30.0, 10.0));
        let color = Vec4::new(grid(0.0, 1.0), grid(0.0, 1.0), grid(0.0, 1.0), grid(0.1, 0.9));
        let disc = particle(center, grid(0.75, 2.0), color);
        scene.particles.push(gobo::model::Particle { material: 2, id, ..disc });
        let half = Vec3::new(grid(0.2, 1.5), 0.0, grid(0.2, 1.5));
        let at = Vec3::new(grid(-20.0, 20.0), grid(0.5, 4.0), grid(-30.0, 10.0));
        scene.triangles.extend(moved(roof(0.0, half, id % 2), at));
    }
    let mut last = maps(&scene);
    for map in &last {
        assert_eq!(map.view.scale.log2().fract(), 0.0, "texels are not powers of two");
    }
    let (mut moves, mut texels) = (0, 0);
    let mut compare = |last: &[ViewMaps], now: &[ViewMaps]| {
        for (a, b) in last.iter().zip(now) {
            let by = shift(&a.view, &b.view);
            moves += u32::from(by != IVec2::ZERO);
            for (i, j) in common_texels(128, by) {
                assert_eq!(a.filter[i], b.filter[j], "{} {by} {i}", a.view.name);
                assert_eq!(a.nearest[i].to_bits(), b.nearest[j].to_bits(), "{i}");
                assert_eq!(a.opaque[i].to_bits(), b.opaque[j].to_bits(), "{i}");
                texels += u32::from(a.filter[i][0] < 1.0 && a.nearest[i] < 1.0);
            }
        }
    };
    for step in 1..10 {
        let by = Vec3::new(0.031, 0.007, -0.053) * step as f32;
        scene.camera.eye += by;
        scene.camera.target += by;
        let now = maps(&scene);
        compare(&last, &now);
        last = now;
    }
    for tier in tiers(Tier::Core) {
        let before = map_frame(tier, &scene).maps;
        let mut ahead = scene.clone();
        ahead.camera.eye.z -= 0.7;
        ahead.camera.target.z -= 0.7;
        compare(&before, &map_frame(tier, &ahead).maps);
    }
    assert!(moves > 10 && texels > 10_000, "{moves} moves, {texels} texels");
}

/// For any light, step and rotation, windows keep their size and move by whole texels, and maps differ only
/// by rounding.
#[test]
fn camera_motion_makes_no_shimmer() {
    let mut scene = ground(Cascades::default(), Vec3::new(-0.4, -1.0, -0.3));
    let mut chance = Chance::new(5);
    scene.materials.push(Material { profile: Profile::Soft, ..material(Transfer::Smoke) });
    for id in 0..300 {
        let center = Vec3::new(chance.within(-9.0, 9.0), 2.0, chance.within(-30.0, 5.0));
        let disc = particle(center, chance.within(0.3, 1.0), Vec4::new(0.2, 0.5, 0.9, 0.5));
        scene.particles.push(gobo::model::Particle { material: 2, id, ..disc });
    }
    let mut last = maps(&scene);
    let mut moves = 0;
    for _ in 0..6 {
        scene.camera.eye += chance.vec3(-0.2, 0.2);
        scene.camera.target += chance.vec3(-0.9, 0.9);
        let now = maps(&scene);
        for (a, b) in last.iter().zip(&now) {
            let by = shift(&a.view, &b.view);
            moves += u32::from(by != IVec2::ZERO);
            // Far from the origin, positions are rounded by some 1e-3 of a texel; soft discs of two texels or
            // more change by less than 1% over that.
            let apart = common_texels(128, by).filter(|&(i, j)| {
                let filters = a.filter[i].iter().zip(&b.filter[j]);
                filters.clone().any(|(a, b)| (a - b).abs() > 0.01)
            });
            assert!(apart.count() <= 8, "{}", a.view.name);
        }
        last = now;
    }
    assert!(moves > 6, "{moves}");
}

/// A window as large as the scene need not move, and near cascades are finer.
#[test]
fn cascades_grow_up_to_the_scene() {
    let views = shadow_views(&ground(Cascades::default(), Vec3::NEG_Y));
    let scales: Vec<f32> = views.iter().map(|view| view.scale).collect();
    assert!(scales.windows(2).all(|pair| pair[0] > 1.5 * pair[1]), "{scales:?}");
    for (index, view) in views.iter().enumerate() {
        assert!(
            matches!(view.role, ViewRole::Window { index: i, count: 4, .. } if i as usize == index)
        );
    }
    let names: Vec<_> = views.iter().map(|view| view.name).collect();
    assert_eq!(names, ["0", "1", "2", "3"]);
    let far = Cascades { range: Some(1e5), ..Cascades::default() };
    let last = shadow_views(&ground(far, Vec3::NEG_Y)).pop().unwrap();
    // The scene is 204 m wide with its margins; windows grow by a quarter of an octave.
    assert!(last.size.x as f32 / last.scale < 1.001 * 224.0, "wider than the scene");
}

/// A pane far above and outside the camera's view darkens all cascades.
#[test]
fn casters_fall_into_every_cascade_they_touch() {
    let mut scene = ground(Cascades::default(), Vec3::NEG_Y);
    scene.triangles.extend(roof(80.0, Vec3::splat(100.0), GLASS));
    for map in maps(&scene) {
        let glass = [1.0, 0.5, 0.25];
        let is_whole = |i: &usize| {
            let filter = map.filter[*i];
            map.opaque[*i] < 1.0 && filter.iter().zip(glass).all(|(f, g)| (f - g).abs() < 1e-3)
        };
        let whole = (0..map.filter.len()).filter(is_whole).count();
        let seen = map.opaque.iter().filter(|&&z| z < 1.0).count();
        assert!(whole == seen && seen > 128 * 64, "{}: {whole} of {seen}", map.view.name);
    }
}

/// Points along the ground, from the camera to far beyond the range.
fn walk() -> Vec<Vec3> {
    (0..600).map(|i| Vec3::new(0.3, 0.0, -0.15 * i as f32)).collect()
}

#[test]
fn cascades_meet_without_a_seam() {
    let mut scene = ground(Cascades { range: Some(30.0), ..Cascades::default() }, Vec3::NEG_Y);
    scene.triangles.extend(roof(5.0, Vec3::splat(100.0), GLASS));
    let lights = light_at(&scene, &walk());
    let seen = walk().iter().filter(|p| p.z > -29.0).count();
    for (point, light) in walk().iter().zip(&lights).take(seen) {
        let error = (*light - Vec3::new(1.0, 0.5, 0.25)).abs().max_element();
        assert!(error < 1e-3, "{light} at {point}");
    }
    assert_eq!(light_at(&scene, &[Vec3::new(0.0, 0.0, -89.0)]), [Vec3::ONE], "beyond the range");
    // At the end of the last cascade, light returns in small steps.
    let steps = lights.windows(2).map(|pair| (pair[1] - pair[0]).abs().max_element());
    assert!(steps.fold(0.0, f32::max) < 0.1);
}

/// An edge that is sharper near than far: where the maps are blended, so is its width.
#[test]
fn cascades_fade_into_each_other() {
    let steepest = |fade| {
        let cascades = Cascades { fade, lambda: 0.5, range: Some(60.0), count: 3 };
        let mut scene = ground(cascades, Vec3::NEG_Y);
        scene.shadow.size = 32;
        // Its edge is parallel to the line of points, about half a texel off.
        let pane = moved(roof(5.0, Vec3::new(50.0, 0.0, 100.0), STONE), Vec3::X * 50.2);
        scene.triangles.extend(pane);
        let lights = light_at(&scene, &walk()[10..380]);
        let steps = lights.windows(2).map(|pair| (pair[1] - pair[0]).abs().max_element());
        steps.fold(0.0, f32::max)
    };
    let (hard, soft) = (steepest(0.0), steepest(0.4));
    assert!(hard > 0.1 && soft < 0.25 * hard, "steps of {hard} and {soft}");
}
