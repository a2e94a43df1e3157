//! Occlusion culling: culled groups are hidden, and no bit of a map changes.
use crate::common::{
    Tier, renderer,
    scenes::{Chance, light, particle},
    tiers,
};
use gobo::{
    glam::{DVec3, Mat4, UVec2, Vec3, Vec4},
    model::{Bounds, Light, LightKind, Receiver},
    records::GpuView,
    shadows::cull::{OccluderPolygons, Occluders},
    view::light_views,
};
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene::Scene;

mod scenes;

use scenes::{cloud, crate_at, smoke_and_ground};

/// A quad of two triangles.
fn square(corner: Vec3, x: Vec3, y: Vec3) -> [[Vec3; 3]; 2] {
    let [a, b, c, d] = [corner, corner + x, corner + x + y, corner + y];
    [[a, b, c], [a, c, d]]
}

/// Flat squares, parallelograms and single triangles.
fn rectangles(chance: &mut Chance, count: usize) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for _ in 0..count {
        let size = 0.5 * 40_f32.powf(chance.unit());
        let (x, y) = (chance.vec3(-1.0, 1.0) * size, chance.vec3(-1.0, 1.0) * size);
        let both = square(chance.vec3(-4.0, 4.0) - (x + y) * 0.5, x, y);
        triangles.extend_from_slice(&both[..1 + chance.below(2)]);
    }
    triangles
}

fn occluders(triangles: &[[Vec3; 3]], view: &GpuView) -> Occluders {
    Occluders::new(&OccluderPolygons::new(triangles.iter().copied().map(Some)), view)
}

fn random_light(chance: &mut Chance) -> Light {
    let position = chance.vec3(-12.0, 12.0);
    let direction = (chance.vec3(-1.0, 1.0) + Vec3::splat(1e-3)).normalize();
    match chance.below(3) {
        0 => light(LightKind::Directional { direction }),
        1 => {
            let direction = (chance.vec3(-2.0, 2.0) - position).normalize();
            let spot = LightKind::Spot { position, direction, angle: chance.within(0.3, 2.6) };
            Light { near: Some(0.1), far: Some(60.0), ..light(spot) }
        }
        _ => Light { near: Some(0.05), far: Some(60.0), ..light(LightKind::Point { position }) },
    }
}

/// Whether a triangle is between `point` and the light (Möller and Trumbore 1997).
fn is_behind(triangles: &[[Vec3; 3]], view: &GpuView, point: DVec3) -> bool {
    let world_from_view = view.view_from_world.as_dmat4().inverse();
    let eye = if view.perspective > 0.0 {
        world_from_view.w_axis.truncate()
    } else {
        point + world_from_view.z_axis.truncate() * 1e3
    };
    let ray = point - eye;
    triangles.iter().any(|triangle| {
        let [a, b, c] = triangle.map(Vec3::as_dvec3);
        let (ab, ac) = (b - a, c - a);
        let across = ray.cross(ac);
        let per_volume = 1.0 / ab.dot(across);
        let from = eye - a;
        let u = from.dot(across) * per_volume;
        let turned = from.cross(ab);
        let v = ray.dot(turned) * per_volume;
        let along = ac.dot(turned) * per_volume;
        // The diagonal of a square belongs to both.
        let inside = u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9;
        inside && along > 0.0 && along < 1.0
    })
}

/// Checks points of each box, and of the enlargement by `project` at its border.
#[test]
fn what_is_hidden_is_behind_opaque_triangles() {
    let mut chance = Chance::new(11);
    let (mut hidden, mut seen, mut whole) = (0, 0, 0);
    for _ in 0..150 {
        let count = 1 + chance.below(30);
        let triangles = rectangles(&mut chance, count);
        let around = Bounds::EMPTY.with_sphere(Vec3::ZERO, 20.0);
        let size = [64, 256, 1024][chance.below(3)];
        for view in light_views(0, &random_light(&mut chance), size, None, &around).unwrap() {
            let view = view.to_gpu(0, UVec2::ZERO, 0);
            let occluders = occluders(&triangles, &view);
            for _ in 0..100 {
                let (min, edge) = (chance.vec3(-10.0, 10.0), chance.vec3(0.0, 1.0));
                let edge = edge * [0.02, 0.3, 4.0][chance.below(3)];
                let bounds = Bounds { min, max: min + edge };
                let is_triangles = chance.below(2) == 0;
                let within = (8..30).map(|_| min + edge * chance.vec3(0.0, 1.0));
                let points: Vec<Vec3> = bounds.corners().into_iter().chain(within).collect();
                let grown = points.iter().map(|&point| {
                    let depth = -view.view_from_world.transform_point3(point).z;
                    let texel = if view.perspective > 0.0 { depth } else { 1.0 } / view.scale;
                    let away = chance.vec3(-1.0, 1.0).normalize() * texel;
                    (point + away).as_dvec3()
                });
                let is_behind =
                    |points: &[DVec3]| points.iter().all(|&p| is_behind(&triangles, &view, p));
                let grown: Vec<DVec3> = grown.collect();
                let behind = is_behind(&grown);
                if occluders.hide(&bounds, is_triangles) {
                    assert!(behind, "{bounds:?} in {view:?} behind {triangles:?}");
                    hidden += 1;
                } else if behind {
                    seen += 1;
                }
                whole += usize::from(behind);
            }
        }
    }
    eprintln!("{hidden} of {whole} hidden, {seen} are not found");
    // Most boxes are behind several surfaces, or cross a surface's or the map's border.
    assert!(hidden > 1000, "{hidden} hidden of {whole} behind something");
}

fn sun_view(size: u32) -> GpuView {
    let sun = light(LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize() });
    let around = Bounds::EMPTY.with_sphere(Vec3::ZERO, 10.0);
    light_views(0, &sun, size, None, &around).unwrap()[0].to_gpu(0, UVec2::ZERO, 0)
}

fn ground(edge: f32) -> [[Vec3; 3]; 2] {
    square(Vec3::new(-edge, 0.0, -edge) * 0.5, Vec3::X * edge, Vec3::Z * edge)
}

#[test]
fn what_cannot_be_judged_is_not_hidden() {
    let view = sun_view(512);
    let below = Bounds::EMPTY.with_sphere(Vec3::NEG_Y * 3.0, 0.5);
    let occluders = |view: &GpuView| occluders(&ground(12.0), view);
    let sound = occluders(&view);
    for triangles in [false, true] {
        assert!(sound.hide(&below, triangles));
        let (nan, one) = (f32::NAN, Vec3::ONE);
        for bounds in [
            Bounds::EMPTY,
            Bounds { min: below.min.with_y(nan), ..below },
            Bounds { max: below.max.with_x(nan), ..below },
            Bounds { min: Vec3::NAN, max: Vec3::NAN },
            Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY },
            Bounds { min: below.min.with_y(f32::NEG_INFINITY), ..below },
            Bounds { min: one * -3e38, max: one * 3e38 },
            Bounds { min: below.min.with_y(-1e6), ..below },
            Bounds { min: one * -1e14, max: -one },
            Bounds { min: below.max, max: below.min },
            // The ground's own box, one that touches it, and one that crosses it.
            Bounds { min: Vec3::new(-6.0, 0.0, -6.0), max: Vec3::new(6.0, 0.0, 6.0) },
            Bounds { max: below.max.with_y(0.0), ..below },
            Bounds { max: below.max.with_y(1e-6), ..below },
        ] {
            assert!(!sound.hide(&bounds, triangles), "{bounds:?}");
        }
        for broken in [
            GpuView { view_from_world: Mat4::NAN, ..view },
            GpuView { view_from_world: Mat4::from_scale(Vec3::splat(0.5)), ..view },
            GpuView { far: view.near, ..view },
            GpuView { far: f32::NAN, ..view },
            GpuView { scale: 0.0, ..view },
            GpuView { scale: f32::NAN, ..view },
        ] {
            assert!(!occluders(&broken).hide(&below, triangles), "{broken:?}");
        }
    }
}

#[test]
fn surfaces_that_are_not_drawn_whole_hide_nothing() {
    let view = sun_view(512);
    let below = Bounds::EMPTY.with_sphere(Vec3::NEG_Y * 3.0, 0.5);
    let hides = |triangles: &[[Vec3; 3]]| occluders(triangles, &view).hide(&below, false);
    let [first, second] = ground(12.0);
    assert!(hides(&[first, second]));
    assert!(hides(&[second, first]));
    assert!(hides(&[[first[1], first[2], first[0]], [second[2], second[1], second[0]]]));
    // Each triangle alone leaves half of the box uncovered.
    assert!(!hides(&[first]) && !hides(&[second]));
    // With a hair's breadth between them, texels may fall through the gap.
    let apart = second.map(|corner| corner + Vec3::new(-1e-6, 0.0, 1e-6));
    assert!(!hides(&[first, apart]));
    // Folded along the diagonal, the pair is not planar.
    let folded = [first[0], first[2], second[2] + Vec3::Y];
    assert!(!hides(&[first, folded]));
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(!hides(&ground(12.0).map(|t| [t[0].with_y(bad), t[1], t[2]])));
    }
    assert!(!hides(&ground(12.0).map(|t| [t[0], t[0], t[2]])));
    // A polygon through the near plane.
    let high = ground(12.0).map(|t| t.map(|c| if c.x > 0.0 { c.with_y(40.0) } else { c }));
    assert!(!hides(&high));
    // More polygons than are examined, with the largest among them.
    let mut many: Vec<[Vec3; 3]> = rectangles(&mut Chance::new(3), 2000)
        .iter()
        .map(|t| t.map(|corner| corner * 0.05 + Vec3::Y * 5.0))
        .collect();
    many.splice(1501..1501, [first, second]);
    assert!(hides(&many));
}

fn renderers() -> impl Iterator<Item = Renderer> {
    tiers(Tier::Core).into_iter().map(renderer)
}

fn rendered(renderer: &mut Renderer, scene: &Scene, hide: bool) -> Frame {
    frame(renderer, scene, hide, true)
}

fn frame(renderer: &mut Renderer, scene: &Scene, hide: bool, maps_only: bool) -> Frame {
    renderer.configure(|config| config.toggles.hide = hide);
    let options = RenderOptions { maps: true, keep: true, maps_only, ..RenderOptions::default() };
    renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// Number of hidden casters; maps must equal those without culling.
fn hidden(renderer: &mut Renderer, scene: &Scene) -> u64 {
    renderer.forget();
    let with = rendered(renderer, scene, true);
    renderer.forget();
    let without = rendered(renderer, scene, false);
    assert_eq!(without.counters.hidden, 0);
    let (few, all) = (&with.counters, &without.counters);
    assert_eq!(few.culled, all.culled + few.hidden);
    assert!(few.pairs <= all.pairs);
    assert_eq!(with.maps.len(), without.maps.len());
    for (a, b) in with.maps.iter().zip(&without.maps) {
        assert!(a.filter == b.filter, "filters of {:?}", a.view);
        assert!(a.nearest == b.nearest, "nearest depths of {:?}", a.view);
        assert!(a.opaque == b.opaque, "opaque depths of {:?}", a.view);
        assert!(a.curve == b.curve, "curves of {:?}", a.view);
        assert!(a.colored == b.colored, "coloured depths of {:?}", a.view);
    }
    few.hidden
}

#[test]
fn smoke_below_a_ground_is_hidden() {
    for (mut renderer, is_first) in renderers().zip([true, false]) {
        let mut scene = smoke_and_ground();
        // Sun, spot, and the bulb's face downwards.
        assert_eq!(hidden(&mut renderer, &scene), 3 * 150);
        let [with, without] = [true, false].map(|hide| {
            renderer.forget();
            frame(&mut renderer, &scene, hide, false).picture.rgb
        });
        assert!(!with.is_empty() && with == without);
        // Culling does not depend on the tier.
        if !is_first {
            continue;
        }
        // Curves depend on the number of pairs.
        scene.shadow.receiver = Receiver::Curve;
        assert_eq!(hidden(&mut renderer, &scene), 0);
        scene.shadow.receiver = Receiver::Nearest;
        // More casters than a segment holds, elsewhere and above.
        let many = |at| cloud(&mut Chance::new(6), at, 2000, 0);
        let mut crowded = scene.clone();
        crowded.particles.extend(many(Vec3::new(4.5, 1.0, 4.5)));
        // Some of the few share a group with visible particles.
        assert!(hidden(&mut renderer, &crowded) > 2 * 150);
        scene.particles.extend(many(Vec3::Y));
        assert_eq!(hidden(&mut renderer, &scene), 0);
    }
}

/// Opaque and dithered boxes below the ground and beside it, near and far, and tiny ones.
#[test]
fn opaque_casters_below_a_ground_are_hidden() {
    // Each tier tests half of the kernels.
    let modes = [
        [(1, false, false, Receiver::Nearest), (2, true, true, Receiver::Nearest)],
        [(3, true, false, Receiver::Nearest), (4, false, false, Receiver::Curve)],
    ];
    for (mut renderer, modes) in renderers().zip(modes) {
        for (seed, soften, colored, receiver) in modes {
            let mut chance = Chance::new(seed);
            let mut scene = smoke_and_ground();
            scene.shadow.size = 256;
            scene.shadow.soften = soften;
            scene.shadow.colored = colored;
            scene.shadow.receiver = receiver;
            for id in 1..60 {
                let center = chance.vec3(-1.0, 1.0) * Vec3::new(8.0, 3.0, 8.0);
                let edge = 0.01 * 100_f32.powf(chance.unit());
                let material = 1 + chance.below(2) as u32;
                scene.triangles.extend(crate_at(center, edge, material, id));
            }
            scene.particles.extend(cloud(&mut chance, Vec3::NEG_Y, 100, 2));
            scene.particles.extend(cloud(&mut chance, Vec3::Y, 100, 2));
            let hidden = hidden(&mut renderer, &scene);
            assert!(hidden > 10 * 12 * 3, "{hidden}");
        }
    }
}

/// A volume's faces behind the ground end at its depth, and still count.
#[test]
fn a_volume_is_never_hidden() {
    let mut scene = smoke_and_ground();
    scene.triangles.extend(crate_at(Vec3::NEG_Y * 2.0, 1.0, 3, 1));
    let mut renderer = renderers().next().expect("there are tiers");
    assert_eq!(hidden(&mut renderer, &scene), 3 * 150);
    // One face opaque, the others a volume.
    scene.particles.clear();
    assert_eq!(hidden(&mut renderer, &scene), 0);
}

/// A map is kept while only hidden casters move, and is rendered when they appear.
#[test]
fn maps_stay_while_only_what_is_hidden_moves() {
    let mut renderer = renderers().next().expect("there are tiers");
    let mut scene = smoke_and_ground();
    // Fixes the bounds of the scene.
    let far = Vec3::new(7.0, 5.0, 7.0);
    scene.particles.extend([far, -far].map(|center| particle(center, 0.1, Vec4::ONE)));
    let rendered_views = |renderer: &mut Renderer, scene: &Scene| {
        let frame = rendered(renderer, scene, true);
        (frame.counters.views_rendered, frame)
    };
    let all = scene.lights.iter().map(Light::view_count).sum::<usize>() as u64;
    assert_eq!(rendered_views(&mut renderer, &scene).0, all);
    let shift = |scene: &mut Scene, by: Vec3| {
        scene.particles[200..350].iter_mut().for_each(|particle| particle.center += by);
    };
    shift(&mut scene, Vec3::NEG_Y * 0.1);
    assert!(rendered_views(&mut renderer, &scene).0 < all - 2, "those below it are in some face");
    shift(&mut scene, Vec3::Y * 2.5);
    let (count, frame) = rendered_views(&mut renderer, &scene);
    assert!(count >= 3, "{count}");
    let fresh = rendered(&mut renderers().next().expect("there are tiers"), &scene, false);
    let same = frame.maps.iter().zip(&fresh.maps).all(|(a, b)| a.filter == b.filter);
    assert!(same, "it is the map of what came out");
    // Without the ground everything is visible.
    scene.triangles[0].positions[1].y = 3.0;
    let (count, _) = rendered_views(&mut renderer, &scene);
    assert!(count >= 3, "{count}");
}
