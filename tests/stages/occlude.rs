//! Opaque triangles: small ones are scattered to their few texels, larger ones go through tiles.
use crate::common::{
    TIERS, map_frame,
    scenes::{Chance, empty, light, material, triangle},
};
use gobo::{
    glam::Vec3,
    gpu::Tier,
    model::{LightKind, Transfer, Triangle},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference as reference;
use gobo_scene::Scene;

/// Light depths are `f32`; a few operations separate CPU reference and kernel.
const DEPTH: f32 = 2e-6;
/// Share of texels that rounding may decide, where a ray grazes an edge.
const GRAZED: f64 = 2e-4;

fn lit(triangles: Vec<Triangle>) -> Scene {
    let position = Vec3::new(3.0, 4.0, 2.5);
    let mut scene = empty(vec![material(Transfer::Opaque), material(Transfer::Cutout)]);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }),
        light(LightKind::Point { position: Vec3::new(0.1, 0.2, -0.1) }),
    ];
    scene.triangles = triangles;
    scene
}

/// `count` triangles about `size` long [m], of the materials in turn.
fn shards(count: u32, size: f32, materials: u32, seed: u64) -> Vec<Triangle> {
    let mut chance = Chance::new(seed);
    let one = |i| {
        let center = chance.vec3(-2.0, 2.0);
        let positions = [0; 3].map(|_| center + chance.vec3(-0.5, 0.5) * size);
        triangle(positions, i % materials)
    };
    (0..count).map(one).collect()
}

/// Share of the texels whose opaque depths differ.
fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    let depths = |maps: &[ViewMaps]| -> Vec<f32> {
        maps.iter().flat_map(|view| view.opaque.iter().copied()).collect()
    };
    let (a, b) = (depths(a), depths(b));
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > DEPTH).count();
    apart as f64 / a.len() as f64
}

fn assert_matches_reference(scene: &Scene, what: &str) {
    let (expected, _) = reference::render_maps(scene, &shadow_views(scene));
    let hit = expected.iter().flat_map(|view| &view.opaque).filter(|&&d| d < 1.0).count();
    assert!(hit > 1000, "{what}: {hit} texels are hit");
    for tier in TIERS {
        let apart = share_apart(&map_frame(tier, scene).maps, &expected);
        assert!(apart <= GRAZED, "{what}, {tier:?}: {apart}");
    }
}

#[test]
fn small_triangles_match_the_reference() {
    assert_matches_reference(&lit(shards(3000, 0.1, 1, 1)), "small");
}

#[test]
fn large_triangles_match_the_reference() {
    assert_matches_reference(&lit(shards(300, 2.0, 1, 2)), "large");
}

#[test]
fn small_and_large_triangles_match_the_reference() {
    let mut triangles = shards(2048, 0.1, 1, 3);
    triangles.extend(shards(64, 1.5, 1, 4));
    assert_matches_reference(&lit(triangles), "opaque");
    let mut triangles = shards(2048, 0.1, 1, 5);
    triangles.extend(shards(256, 0.3, 2, 6));
    assert_matches_reference(&lit(triangles), "with cutout ones");
}

/// A tenth of the triangles missing is more than rounding.
#[test]
fn missing_triangles_are_noticed() {
    for (count, size) in [(3000, 0.1), (300, 2.0)] {
        let mut scene = lit(shards(count, size, 1, 1));
        let (expected, _) = reference::render_maps(&scene, &shadow_views(&scene));
        scene.triangles.truncate(count as usize * 9 / 10);
        let apart = share_apart(&map_frame(Tier::Native, &scene).maps, &expected);
        assert!(apart > GRAZED, "{count} triangles: {apart}");
    }
}

/// Every texel of a wall made of small triangles is blocked, by one depth.
#[test]
fn a_fine_wall_has_no_holes() {
    const CELLS: i32 = 60;
    let corner = |x: i32, y: i32| {
        let at = |i: i32| i as f32 / CELLS as f32 * 4.0 - 2.0;
        Vec3::new(at(x), at(y), -1.5)
    };
    let cells = (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (x, y)));
    let triangles = cells.flat_map(|(x, y)| {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| corner(x + i, y + j));
        [triangle([a, b, c], 0), triangle([a, c, d], 0)]
    });
    let mut scene = lit(triangles.collect());
    let position = Vec3::new(0.0, 0.0, 2.0);
    scene.lights = vec![
        light(LightKind::Spot { position, direction: Vec3::NEG_Z, angle: 0.9 }),
        light(LightKind::Directional { direction: Vec3::NEG_Z }),
    ];
    for tier in TIERS {
        let frame = map_frame(tier, &scene);
        let spot = &frame.maps[0].opaque;
        let (least, most) = spot.iter().fold((1.0_f32, 0.0_f32), |(l, m), &d| (l.min(d), m.max(d)));
        assert!(most - least <= DEPTH && most < 1.0, "{tier:?}: {least}..{most}");
        let sun = &frame.maps[1];
        let inside = |i: usize| {
            let size = sun.view.size.x as usize;
            let middle = |v: usize| v.abs_diff(size / 2) < size / 8;
            middle(i % size) && middle(i / size)
        };
        let holes = (0..sun.opaque.len()).filter(|&i| inside(i) && sun.opaque[i] == 1.0).count();
        assert_eq!(holes, 0, "{tier:?}");
    }
}
