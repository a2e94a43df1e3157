//! Volumes that overlap each other and contain other casters, by depth: the faces and hits of a ray in one
//! order.
use crate::{
    common::scenes::material,
    maps::{
        curve::curved,
        volumes::{FOG, SUN, all_maps, ball, cuboid, floor, fog, meet, ray, spot, stage},
    },
};
use gobo::{
    glam::{DVec3, Vec3, Vec4},
    model::{LightKind, Material, Transfer},
    records::ViewMaps,
};
use gobo_scene::Scene;

/// Second fog.
const SMOG: u32 = 2;
const PANE: u32 = 3;
/// Colour of the pane, of opacity 1.
const RED: DVec3 = DVec3::new(0.9, 0.3, 0.2);
/// Light behind the ball and the pane in the box, at most exp(-2.8), has one or two of the eight ramps.
const WORST: f64 = 0.2;
/// Under the sun it would be 0.0011 without a common order.
const MEAN: f64 = 9e-4;
/// Rounding of a stored channel.
const ROUNDING: f64 = 2e-3;

/// An upright box with a ball in its top, and a pane through both.
fn scene(kind: LightKind) -> Scene {
    let mut scene = stage(kind);
    let smog = Material {
        attenuation_color: Vec3::new(0.9, 0.4, 0.3),
        attenuation_distance: 1.0,
        ..fog()
    };
    let pane = Material { tint: RED.as_vec3().extend(1.0), ..material(Transfer::Filter) };
    scene.materials.extend([smog, pane]);
    scene.triangles.extend(cuboid(Vec3::new(-1.6, -1.2, -3.0), Vec3::new(1.7, 1.4, 3.0), FOG));
    let mut top = ball(2, Vec3::new(0.2, 0.1, 2.6), 1.1);
    top.iter_mut().for_each(|triangle| triangle.material = SMOG);
    scene.triangles.extend(top);
    scene.triangles.extend(floor(2.1, PANE));
    curved(scene, 8)
}

fn absorbed(scene: &Scene, material: u32, metres: f64) -> DVec3 {
    let material = &scene.materials[material as usize];
    material.attenuation_color.as_dvec3().powf(metres / f64::from(material.attenuation_distance))
}

/// Light left on a ray at a distance; `None` next to an edge.
fn truth(scene: &Scene, start: DVec3, way: DVec3) -> Option<impl Fn(f64) -> DVec3> {
    let bodies = [FOG, SMOG].map(|material| (material, meet(scene, material, start, way)));
    let (panes, pane_edge) = meet(scene, PANE, start, way);
    let is_clear = pane_edge > 0.02 && bodies.iter().all(|(_, (_, edge))| *edge > 0.02);
    is_clear.then_some(move |end: f64| {
        let panes = panes.iter().filter(|t| **t < end).count();
        bodies.iter().fold(RED.powf(panes as f64), |light, (material, (faces, _))| {
            let inside = faces.chunks(2).map(|pair| pair[1].min(end) - pair[0].min(end));
            light * absorbed(scene, *material, inside.sum())
        })
    })
}

fn light_at(maps: &ViewMaps, texel: usize, depth: f64) -> DVec3 {
    maps.curve.as_ref().unwrap().light_at(texel, depth as f32).as_dvec3()
}

#[test]
fn a_ball_in_the_top_of_a_box() {
    for kind in [SUN, spot()] {
        let scene = scene(kind);
        for (maps, counters) in all_maps(&scene) {
            assert_eq!(counters.unordered, 0);
            let maps = &maps[0];
            let (mut sum, mut count, mut worst) = (0.0, 0, 0.0_f64);
            for texel in 0..maps.filter.len() {
                let (start, way) = ray(maps, texel);
                let Some(light) = truth(&scene, start, way) else { continue };
                let axis = maps.view.direction().as_dvec3();
                let far = f64::from(maps.view.far - maps.view.near) / way.dot(axis);
                let mut before = DVec3::ONE;
                let has_pane = |from: f64, to: f64| {
                    meet(&scene, PANE, start, way).0.iter().any(|t| (from..to).contains(t))
                };
                for step in 0..100 {
                    let depth = (f64::from(step) + 0.5) / 100.0;
                    let found = light_at(maps, texel, depth);
                    assert!(
                        (found - before).max_element() <= ROUNDING,
                        "{texel} brightens at {depth}"
                    );
                    before = found;
                    let way_there = depth * far;
                    if has_pane(way_there - 0.02, way_there + 0.02) {
                        continue;
                    }
                    let wrong = (found - light(depth * far)).abs().max_element();
                    (sum, count, worst) = (sum + wrong, count + 1, wrong.max(worst));
                }
            }
            let mean = sum / f64::from(count);
            assert!(count > 150_000 && mean <= MEAN && worst <= WORST, "{count} {mean} {worst}");
        }
    }
}

/// Glass that contains many faint casters loses no light between them.
#[test]
fn thin_steps_of_a_volume_add_up() {
    let mut scene = stage(SUN);
    scene.shadow.size = 16;
    let faint = Material { tint: Vec4::new(0.5, 0.5, 0.5, 1e-4), ..material(Transfer::Filter) };
    scene.materials.push(faint);
    scene.materials[FOG as usize].attenuation_distance = 500.0;
    scene.triangles.extend(cuboid(Vec3::new(-3.1, -3.3, -4.0), Vec3::new(3.3, 3.7, 4.0), FOG));
    for i in 0..1500 {
        scene.triangles.extend(floor(4.0 - 8.0 * (i as f32 + 0.5) / 1500.0, SMOG));
    }
    let scene = curved(scene, 8);
    for (maps, _) in all_maps(&scene) {
        let maps = &maps[0];
        let texel = maps.filter.len() / 2 + 8;
        let (start, way) = ray(maps, texel);
        let far = f64::from(maps.view.far - maps.view.near);
        let (faces, _) = meet(&scene, FOG, start, way);
        for step in 1..50 {
            let depth = f64::from(step) / 50.0;
            let inside = (depth * far).clamp(faces[0], faces[1]) - faces[0];
            let panes = (DVec3::splat(1.0 - 0.5e-4)).powf(1500.0 * inside / 8.0);
            let wrong =
                (light_at(maps, texel, depth) - absorbed(&scene, FOG, inside) * panes).abs();
            assert!(wrong.max_element() <= 0.01, "{depth}: {wrong}");
        }
    }
}
