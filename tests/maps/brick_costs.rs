//! Cost of grids: empty space costs nothing, and neither does a still grid; light taken by a grid smaller
//! than a texel.
use super::bricks::{BRICK, WALL, lump, scene_of};
use crate::common::{TIERS, Tier, gpu, grid_truth::Line, map_frame, scenes::hold_view};
use gobo::{
    glam::{Affine3A, DVec3, IVec3, Quat, UVec2, UVec3, Vec3},
    model::{Brick, Density, Grid, LightKind},
    records::Bricks,
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_reference::render_maps;
use gobo_scene::Scene;

const DOWN: LightKind = LightKind::Directional { direction: Vec3::NEG_Z };

/// The same bricks in bounds of at least twice the volume, in a map that shows these: they are as large as
/// before, have as many voxels, and meet as many tiles. So each texel walks the same path. The same bounds
/// full of thin smoke take more.
#[test]
fn empty_space_costs_nothing() {
    let grid = |bricks: Vec<Brick>| {
        let mut scene = scene_of(DOWN, Grid { bricks, ..lump() });
        hold_view(&mut scene, WALL);
        scene.shadow.size = 512;
        scene
    };
    let far = IVec3::new(90, 0, 0);
    let speck = Brick::new(far, Density::Constant { size: UVec3::ONE, density: 1e-3 });
    let own = lump().bricks;
    let wide = own.iter().cloned().chain([speck]).collect();
    let full = Brick::of_voxels(IVec3::new(-11, -8, -9), far + 9, |_| 1e-3);
    let scenes = [own, wide, full].map(grid);
    let extent = |scene: &Scene| {
        let bounds = scene.grids[0].bounds();
        (bounds.max - bounds.min).element_product()
    };
    assert!(extent(&scenes[1]) > 2.0 * extent(&scenes[0]));
    let [own, wide, full] = [0, 1, 2].map(|i| Bricks::new(&scenes[i].grids, UVec2::splat(64)));
    for (own, wide) in own.particles.iter().zip(&wide.particles) {
        assert!(own.center.distance(wide.center) < 1e-4);
        assert!((own.radius - wide.radius).abs() < 1e-4);
    }
    assert!(own.voxels == wide.voxels && wide.particles.len() == own.particles.len() + 1);
    assert!(full.voxels.len() > 2 * own.voxels.len());
    for tier in TIERS {
        let pairs = [0, 1, 2].map(|i| {
            let counters = map_frame(tier, &scenes[i]).counters;
            (counters.pairs + counters.scattered) as f64
        });
        let [own, wide, full] = pairs;
        assert!(own > 100.0 && wide <= 1.1 * own && full > 1.5 * own, "{tier:?}: {pairs:?}");
    }
}

#[test]
fn a_still_grid_is_not_rendered_again() {
    let mut scene = scene_of(LightKind::Point { position: Vec3::new(2.4, 0.3, -0.2) }, lump());
    let options = RenderOptions { maps_only: true, keep: true, ..Default::default() };
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let mut views = |scene: &_| {
        let counters = renderer.render(scene, &options).unwrap().counters;
        (counters.views_rendered, counters.views_kept)
    };
    assert_eq!(views(&scene), (6, 0));
    assert_eq!(views(&scene), (0, 6));
    // A camera that moves renders no map of a grid.
    scene.camera.eye.x += 0.5;
    assert_eq!(views(&scene), (0, 6));
    scene.grids[0].world_from_index.translation.x += 0.01;
    assert!(views(&scene).0 > 0);
}

/// A puff of 3 x 3 x 3 voxels of a tenth of a texel, at 12 x 12 positions around a texel's centre: only some
/// of them show it, as texels are sampled at their centres, but its mean shadow is right.
#[test]
fn a_puff_below_a_texel_takes_its_light_on_the_mean() {
    const PLACES: i32 = 12;
    const LINES: i32 = 80;
    const TEXEL: f32 = 20.0 / 64.0;
    const EDGE: f32 = 0.1 * TEXEL;
    /// Edge of the square of positions outside of which it does not show [texels].
    const SQUARE: f32 = 0.6;
    let puff = |shift: Vec3| Grid {
        world_from_index: Affine3A::from_scale_rotation_translation(
            Vec3::splat(EDGE),
            Quat::IDENTITY,
            shift - Vec3::splat(EDGE),
        ),
        bricks: Brick::of_voxels(IVec3::ZERO, IVec3::splat(2), |_| 1.0),
        factor: 15.0,
        extinction: Vec3::ONE,
        material: BRICK,
        ..Grid::default()
    };
    let taken = |shift: Vec3| {
        let mut scene = scene_of(DOWN, puff(shift));
        hold_view(&mut scene, WALL);
        let maps = render_maps(&scene, &shadow_views(&scene)).0;
        let lost = maps[0].filter.iter().map(|filter| f64::from(1.0 - filter[0]));
        lost.sum::<f64>() * f64::from(TEXEL * TEXEL)
    };
    let places = (0..PLACES * PLACES).map(|i| [i % PLACES, i / PLACES].map(|n| n as f32 + 0.5));
    let around = |n: f32| (0.5 + SQUARE * (n / PLACES as f32 - 0.5)) * TEXEL;
    let all: Vec<f64> = places.map(|[x, y]| taken(Vec3::new(around(x), around(y), 0.0))).collect();
    // Share of a texel's positions.
    let share = f64::from(SQUARE * SQUARE) / all.len() as f64;
    let mean = all.iter().sum::<f64>() * share;
    // Light that it takes, by lines through 80 x 80 positions of a square around it.
    let grid = puff(Vec3::ZERO);
    let step = f64::from(6.0 * EDGE) / f64::from(LINES);
    let of_line = |i: i32| {
        let place = |n: i32| (f64::from(n) + 0.5) * step - f64::from(3.0 * EDGE);
        let start = DVec3::new(place(i % LINES), place(i / LINES), 5.0);
        let line = Line { start, way: DVec3::NEG_Z };
        // At the third of four depths.
        let depth = line.optical_depths(&grid, [0.0, 10.0], 4)[3];
        (1.0 - (-15.0 * depth).exp()) * step * step
    };
    let expected: f64 = (0..LINES * LINES).map(of_line).sum();
    let shown = all.iter().filter(|&&taken| taken > 0.0).count() as f64 * share;
    println!("mean {:.3} of what it takes; it shows in {shown:.2} of the places", mean / expected);
    assert!((mean / expected - 1.0).abs() < 0.05, "{mean} {expected}");
    assert!(shown < 0.3, "{shown}");
}
