//! Frustum culling: the result contains everything visible.
use crate::common::scenes::{Chance, light};
use gobo::{
    glam::{Mat4, UVec2, Vec2, Vec3, Vec4},
    model::{Bounds, Light, LightKind, Material, Particle, Shape, Triangle, View},
    records::{CasterRecord, GpuMaterial, GpuView, TileRect, TriangleRecord},
    shadows::cull::{Frustum, GroupTree, order, widened},
    view::light_views,
};
use gobo_reference::project::{ProjectParams, project_caster, project_triangle};
use std::{collections::BTreeSet, f32::consts::SQRT_2, time::Instant};

/// Shapes of different extents.
pub(super) const SHAPES: [Shape; 3] = [Shape::Disc, Shape::Quad, Shape::Puff];

fn gpu_view(view: &View) -> GpuView {
    view.to_gpu(0, UVec2::ZERO, 0)
}

/// Views of all kinds, in all directions; some narrow, some almost flat, some far from the origin.
pub(super) fn views(chance: &mut Chance, count: usize) -> Vec<GpuView> {
    let all = |chance: &mut Chance| -> Vec<View> {
        let position = chance.vec3(-30.0, 30.0);
        let direction = (chance.vec3(-1.0, 1.0) + Vec3::splat(1e-3)).normalize();
        let kind = match chance.below(3) {
            0 => LightKind::Directional { direction },
            1 => LightKind::Spot { position, direction, angle: chance.within(0.02, 3.0) },
            _ => LightKind::Point { position },
        };
        let (near, far) = match chance.below(3) {
            0 => (None, None),
            1 => (Some(0.01), Some(chance.within(1.0, 20.0))),
            _ => (Some(5.0), Some(chance.within(5.01, 60.0))),
        };
        let part = Bounds::EMPTY.with_sphere(chance.vec3(-10.0, 10.0), chance.within(0.1, 10.0));
        let size = [16, 64, 200, 1024][chance.below(4)];
        light_views(0, &Light { near, far, ..light(kind) }, size, None, &part).unwrap()
    };
    std::iter::repeat_with(|| all(chance)).flatten().take(count).map(|v| gpu_view(&v)).collect()
}

pub(super) fn particle(chance: &mut Chance) -> Particle {
    let center = match chance.below(40) {
        0 => chance.vec3(-1e7, 1e7),
        1 => Vec3::ZERO,
        _ => chance.vec3(-20.0, 20.0),
    };
    let radius = match chance.below(40) {
        0 => 1e-7,
        1 => chance.within(0.0, 1e6),
        _ => 0.002 * 1000_f32.powf(chance.unit()),
    };
    Particle {
        center,
        radius,
        color: Vec4::ONE,
        rotation: 0.0,
        material: chance.below(SHAPES.len()) as u32,
        id: 0,
    }
}

pub(super) fn materials() -> Vec<Material> {
    SHAPES.iter().map(|&shape| Material { shape, ..Material::default() }).collect()
}

pub(super) const PARAMS: ProjectParams =
    ProjectParams { scatter: true, include_non_casters: false, by_distance: false };

/// Whether the projection finds a texel that the particle may touch.
fn touches(view: &GpuView, particle: &Particle) -> bool {
    let material = &materials()[particle.material as usize];
    let (caster, record) = (CasterRecord::new(particle, material), GpuMaterial::new(material, &[]));
    let projected = project_caster(view, 0, (&caster, 0), &record, None, PARAMS);
    projected.rect != TileRect::EMPTY
}

/// Bounds of a particle in its group's box, as in the pipeline.
pub(super) fn reach(particle: &Particle) -> Bounds {
    let reach = if particle.material == 1 { SQRT_2 } else { 1.0 };
    Bounds::EMPTY.with_sphere(particle.center, particle.radius * reach)
}

fn culled(tree: &GroupTree, view: &GpuView) -> BTreeSet<u32> {
    let mut visible = Vec::new();
    tree.cull(&Frustum::new(view), &mut visible);
    let set: BTreeSet<u32> = visible.iter().copied().collect();
    assert_eq!(set.len(), visible.len(), "each once");
    set
}

/// Groups of one caster, so that no neighbour conceals a frustum that is too narrow.
#[test]
fn no_visible_particle_is_culled() {
    let mut chance = Chance::new(1);
    let particles: Vec<Particle> = (0..2000).map(|_| particle(&mut chance)).collect();
    let tree = GroupTree::new(&particles.iter().map(reach).collect::<Vec<_>>());
    let (mut seen, mut kept, mut all) = (0, 0, 0);
    for view in views(&mut chance, 300) {
        let visible = culled(&tree, &view);
        for (group, particle) in (0..).zip(&particles) {
            if touches(&view, particle) {
                assert!(visible.contains(&group), "{particle:?} in {view:?}");
                seen += 1;
            }
        }
        kept += visible.len();
        all += particles.len();
    }
    // The result is hardly larger than the visible set.
    assert!(seen * 20 > all, "the views see something: {seen} of {all}");
    assert!(kept < seen + seen / 4 + all / 50, "{kept} kept, {seen} seen, {all} in all");
}

/// Small particles within two texels of the window's border or of the first and last depth.
#[test]
fn no_particle_on_the_border_is_culled() {
    let mut chance = Chance::new(8);
    let (mut seen, mut outside) = (0, 0);
    for view in views(&mut chance, 1000) {
        let frustum = Frustum::new(&view);
        let world_from_view = view.view_from_world.inverse();
        let borders = |chance: &mut Chance, size: f32| match chance.below(3) {
            0 => chance.within(-2.0, 2.0),
            1 => size + chance.within(-2.0, 2.0),
            _ => chance.within(0.0, size),
        };
        for _ in 0..50 {
            let texel =
                Vec2::new(borders(&mut chance, view.size.x), borders(&mut chance, view.size.y));
            let per_metre = |distance: f32| {
                if view.perspective > 0.0 { view.scale / distance } else { view.scale }
            };
            let at = [view.near, view.far, chance.within(view.near, view.far)][chance.below(3)];
            let distance = at + chance.within(-2.0, 2.0) / per_metre(at.max(view.near));
            let plane = (texel - view.size * 0.5) / per_metre(distance);
            let center = world_from_view.transform_point3(Vec3::new(plane.x, -plane.y, -distance));
            let radius = [1e-6, 0.3, 0.7, 1.5][chance.below(4)] / per_metre(distance);
            let particle = Particle { center, radius, ..particle(&mut chance) };
            let sees = frustum.sees(&widened(&reach(&particle)).expect("it is finite"));
            if touches(&view, &particle) {
                assert!(sees, "{particle:?} in {view:?}");
                seen += 1;
            }
            outside += usize::from(!sees);
        }
    }
    assert!(seen > 10_000 && outside > 1_000, "{seen} seen, {outside} outside");
}

#[test]
fn no_visible_triangle_is_culled() {
    let mut chance = Chance::new(2);
    let triangles: Vec<Triangle> = (0..1000)
        .map(|i| {
            let (corner, size) = (chance.vec3(-20.0, 20.0), 0.01 * 3000_f32.powf(chance.unit()));
            let positions = [0; 3].map(|_| corner + chance.vec3(-size, size));
            Triangle { id: i, ..crate::common::scenes::triangle(positions, 0) }
        })
        .collect();
    let around =
        |t: &Triangle| t.positions.iter().fold(Bounds::EMPTY, |b, &p| b.with_sphere(p, 0.0));
    let tree = GroupTree::new(&triangles.iter().map(around).collect::<Vec<_>>());
    let mut seen = 0;
    for view in views(&mut chance, 300) {
        let visible = culled(&tree, &view);
        for (group, triangle) in (0..).zip(&triangles) {
            let record = TriangleRecord::new(triangle);
            let (projected, setup) = project_triangle(&view, 0, &record, 0, 0, PARAMS);
            // Beyond the far plane only volumes count, and they are listed at any distance.
            let is_within = setup.depths.min_element() <= 1.0;
            if projected.rect != TileRect::EMPTY && is_within {
                assert!(visible.contains(&group), "{triangle:?} in {view:?}");
                seen += 1;
            }
        }
    }
    assert!(seen > 10_000, "{seen}");
}

/// Visible boxes by brute force.
fn linear(bounds: &[Bounds], view: &GpuView) -> BTreeSet<u32> {
    let frustum = Frustum::new(view);
    let sees = |bounds: &Bounds| {
        let has_nan = bounds.min.is_nan() || bounds.max.is_nan();
        let is_empty = bounds.min.cmpgt(bounds.max).any() && !has_nan;
        !is_empty && widened(bounds).is_none_or(|bounds| frustum.sees(&bounds))
    };
    (0..).zip(bounds).filter(|(_, bounds)| sees(bounds)).map(|(group, _)| group).collect()
}

fn random_boxes(chance: &mut Chance, count: usize) -> Vec<Bounds> {
    let one = |chance: &mut Chance| {
        let (a, size) = (chance.vec3(-20.0, 20.0), chance.vec3(0.0, 2.0));
        let normal = Bounds { min: a, max: a + size };
        match chance.below(16) {
            0 => Bounds::EMPTY,
            1 => Bounds { min: Vec3::new(f32::NAN, 0.0, 0.0), max: Vec3::ONE },
            2 => Bounds { min: Vec3::ZERO, max: Vec3::new(1.0, f32::NAN, 1.0) },
            3 => Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY },
            4 => Bounds { min: Vec3::splat(-3e38), max: Vec3::splat(3e38) },
            5 => Bounds { min: Vec3::splat(-1e14), max: a },
            6 => Bounds { min: a, max: a },
            7 => Bounds { min: Vec3::ZERO, max: Vec3::ZERO },
            _ => normal,
        }
    };
    (0..count).map(|_| one(chance)).collect()
}

#[test]
fn the_tree_yields_what_brute_force_does() {
    let mut chance = Chance::new(3);
    for count in [0, 1, 2, 3, 17, 1000] {
        let mut bounds = random_boxes(&mut chance, count);
        let mut tree = GroupTree::new(&bounds);
        let mut cut_short = count < 17;
        for (i, view) in views(&mut chance, 60).iter().enumerate() {
            let visible = culled(&tree, view);
            // A tree also tests unions of boxes; it may only find fewer boxes than a linear test by testing
            // the boxes themselves.
            assert_eq!(visible, linear(&bounds, view), "{count} groups, {view:?}");
            cut_short |= visible.len() < count / 2;
            // Some move, a little or not at all, and some change their kind.
            if i % 4 == 0 {
                let moved = random_boxes(&mut chance, count);
                for (bounds, moved) in bounds.iter_mut().zip(moved) {
                    if chance.below(8) == 0 {
                        *bounds = moved;
                    }
                }
                tree.refit(&bounds);
            }
        }
        assert!(cut_short);
    }
    let nothing = vec![Bounds::EMPTY; 5];
    assert!(culled(&GroupTree::new(&nothing), &views(&mut chance, 1)[0]).is_empty());
    let same = vec![Bounds { min: Vec3::ONE, max: Vec3::ONE }; 3000];
    let seen = culled(&GroupTree::new(&same), &wide_view());
    assert_eq!(seen.len(), same.len());
}

/// A view of 200 m around the origin.
fn wide_view() -> GpuView {
    let sun = light(LightKind::Directional { direction: Vec3::NEG_Y });
    gpu_view(
        &light_views(0, &sun, 256, None, &Bounds::EMPTY.with_sphere(Vec3::ZERO, 100.0)).unwrap()[0],
    )
}

#[test]
fn a_view_that_cannot_be_judged_sees_all() {
    let bounds = random_boxes(&mut Chance::new(4), 100);
    let tree = GroupTree::new(&bounds);
    let with_bounds = bounds.iter().filter(|b| !b.min.cmpgt(b.max).any()).count();
    let sound = wide_view();
    let broken = [
        GpuView { view_from_world: Mat4::NAN, ..sound },
        GpuView { view_from_world: Mat4::from_scale(Vec3::splat(0.5)), ..sound },
        GpuView { far: sound.near, ..sound },
        GpuView { far: f32::NAN, ..sound },
        GpuView { scale: 0.0, ..sound },
    ];
    for view in broken {
        assert_eq!(culled(&tree, &view).len(), with_bounds, "{view:?}");
    }
}

#[test]
fn depths_outside_the_range_are_culled() {
    // Looks down from y = far; one texel is added to the range.
    let view = wide_view();
    let at = |y: f32| Bounds::EMPTY.with_sphere(Vec3::new(0.0, y, 0.0), 0.5);
    let (top, texel) = (view.view_from_world.inverse().w_axis.y - view.near, 1.0 / view.scale);
    let bounds = [
        at(top + 0.4),
        at(top + 0.6 + texel),
        at(top - view.far - 0.4),
        at(top - view.far - 0.6 - texel),
    ];
    assert_eq!(culled(&GroupTree::new(&bounds), &view), BTreeSet::from([0, 2]));
}

#[test]
fn a_tree_is_built_anew_when_it_has_degraded() {
    let mut chance = Chance::new(5);
    let at = |center: Vec3| Bounds::EMPTY.with_sphere(center, 0.1);
    let mut centers: Vec<Vec3> = (0..2000).map(|_| chance.vec3(-20.0, 20.0)).collect();
    let boxes = |centers: &[Vec3]| centers.iter().map(|&c| at(c)).collect::<Vec<_>>();
    let mut tree = GroupTree::new(&boxes(&centers));
    for center in &mut centers {
        *center += Vec3::splat(5.0);
    }
    assert!(!tree.refit(&boxes(&centers)), "all move together");
    centers[7] = Vec3::splat(1e6);
    assert!(!tree.refit(&boxes(&centers)), "one flies away");
    chance.shuffle(&mut centers);
    assert!(tree.refit(&boxes(&centers)), "all change places");
    assert!(!tree.refit(&boxes(&centers)));
}

#[test]
fn groups_lie_together() {
    let mut chance = Chance::new(6);
    let mut points: Vec<Vec3> = (0..20_000).map(|_| chance.vec3(0.0, 10.0)).collect();
    points.extend([Vec3::splat(1e7), Vec3::splat(-1e7), Vec3::splat(f32::NAN), Vec3::INFINITY]);
    let order = order::morton(&points);
    assert_eq!(order.iter().collect::<BTreeSet<_>>().len(), points.len(), "a permutation");
    let box_of =
        |i: u32| (Bounds::EMPTY.with_sphere(points[order[i as usize] as usize], 0.01), false);
    let groups = order::cut(order.len() as u32, box_of, 32, 256);
    let mut next = 0;
    for group in &groups {
        assert!(group.start == next && group.len() <= 256 && !group.is_empty());
        next = group.end;
    }
    assert_eq!(next as usize, points.len());
    // 20,000 points of 10 m: 256 of them fill a cube of 2.3 m.
    let edges = groups.iter().map(|group| {
        let points =
            order[group.start as usize..group.end as usize].iter().map(|&i| points[i as usize]);
        let b = points.fold(Bounds::EMPTY, |b, p| b.with_sphere(p, 0.0));
        (b.max - b.min).max_element()
    });
    let small = edges.filter(|&edge| edge < 5.0).count();
    assert!(small * 10 > groups.len() * 9, "{small} of {}", groups.len());
    assert!(groups.len() < 3 * points.len() / 256, "{} groups", groups.len());
    let apart = [Vec3::ZERO, Vec3::ONE * 100.0].map(|p| Bounds::EMPTY.with_sphere(p, 1.0));
    for (count, first) in [(80, 40), (60, 9), (300, 250)] {
        let box_of = |i: u32| (apart[usize::from(i >= first)], false);
        assert_eq!(order::cut(count, box_of, 32, 256), [0..first, first..count]);
    }
    let starts = [true, false, true, true];
    let objects = |i: u32| (apart[0], starts[i as usize]);
    assert_eq!(order::cut(4, objects, 32, 256), [0..2, 2..3, 3..4]);
    assert_eq!(order::cut(0, objects, 32, 256), []);
}

/// A scene as large as the bench's, with a time bound that only a linear loop, or worse, breaks.
#[test]
fn the_tree_beats_a_loop() {
    let mut chance = Chance::new(7);
    let boxes: Vec<Bounds> = (0..100_000)
        .map(|_| Bounds::EMPTY.with_sphere(chance.vec3(-50.0, 50.0), chance.within(0.05, 0.3)))
        .collect();
    let tree = GroupTree::new(&boxes);
    let boxes: Vec<Bounds> = boxes.iter().filter_map(widened).collect();
    let spot = LightKind::Spot {
        position: Vec3::splat(45.0),
        direction: -Vec3::ONE.normalize(),
        angle: 0.27,
    };
    let spot = Light { near: Some(1.0), far: Some(130.0), ..light(spot) };
    let frustum =
        Frustum::new(&gpu_view(&light_views(0, &spot, 512, None, &Bounds::EMPTY).unwrap()[0]));
    let best = |work: &mut dyn FnMut() -> usize| {
        let run = |_| {
            let clock = Instant::now();
            let count = work();
            (clock.elapsed(), count)
        };
        (0..20).map(run).min().expect("it ran")
    };
    let mut visible = Vec::new();
    let (by_tree, count) = best(&mut || {
        visible.clear();
        tree.cull(&frustum, &mut visible);
        visible.len()
    });
    let (by_loop, same) = best(&mut || boxes.iter().filter(|bounds| frustum.sees(bounds)).count());
    assert_eq!(count, same);
    assert!((2_000..10_000).contains(&count), "{count}");
    eprintln!("tree {by_tree:?}, loop {by_loop:?}, {count} visible");
    assert!(by_tree * 2 < by_loop, "{by_tree:?}, {by_loop:?}");
}
