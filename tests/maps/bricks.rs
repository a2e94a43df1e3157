//! Bricks of grids: CPU reference and both tiers against closed forms and a march in 64 bits.
use super::{brute_force::assert_agrees, forms::assert_forms_agree};
use crate::common::{
    TIERS,
    brute_force::render,
    compare::{Tolerance, assert_maps_agree, compare_maps},
    grid_truth::{Line, index_from_world},
    map_frame, map_frame_scattered,
    scenes::{Chance, empty, hold_view, light, material, random_discs, triangle},
};
use gobo::{
    glam::{Affine3A, DVec3, EulerRot, IVec3, Quat, UVec2, UVec3, Vec3, Vec4},
    model::{
        Brick, Density, Grid, LightKind, Material, Projection, Receiver, Shape, Transfer, View,
        Voxels, pcg,
    },
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Rounding of the filter's half floats below 1, on some adapters towards 0, and 1e-4.
const TOLERANCE: Tolerance = Tolerance { filter: 1e-4 + 1.0 / 2048.0, depth: 1e-5, undecided: 0.0 };
/// With sums in fixed point, for a few dozen bricks per texel.
const SUMMED: Tolerance = Tolerance { filter: 2e-3, ..TOLERANCE };
const EDGED: Tolerance = Tolerance { undecided: 0.25, ..TOLERANCE };

pub(super) const BRICK: u32 = 0;
pub(super) const DISC: u32 = 1;
const GLASS: u32 = 2;
pub(super) const WALL: u32 = 3;

pub(super) fn kinds() -> [LightKind; 4] {
    let position = Vec3::new(3.0, 4.0, 2.5);
    [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 },
        LightKind::Point { position: Vec3::new(2.4, 0.3, -0.2) },
        LightKind::Point { position: Vec3::new(0.13, 0.21, -0.17) },
    ]
}

pub(super) fn scene_of(kind: LightKind, grid: Grid) -> Scene {
    let brick = Material { shape: Shape::Brick, ..material(Transfer::Filter) };
    let glass = Material { tint: Vec4::new(0.9, 0.4, 0.3, 0.5), ..material(Transfer::Filter) };
    let materials = vec![brick, material(Transfer::Filter), glass, material(Transfer::Opaque)];
    Scene { lights: vec![light(kind)], grids: vec![grid], ..empty(materials) }
}

/// A lump of 21 x 17 x 19 random voxels around the origin, many of them empty, scaled by different factors
/// and rotated.
pub(super) fn lump() -> Grid {
    let (min, max) = (IVec3::new(-11, -8, -9), IVec3::new(9, 8, 9));
    let mut chance = Chance::new(5);
    let value = |_: IVec3| (chance.unit() - 0.3).max(0.0);
    let size = max - min + 1;
    let count = (size.x * size.y * size.z) as usize;
    let values: Vec<f32> = std::iter::repeat_n(IVec3::ZERO, count).map(value).collect();
    let density = |voxel: IVec3| {
        let place = voxel - min;
        values[((place.z * size.y + place.y) * size.x + place.x) as usize]
    };
    Grid {
        world_from_index: Affine3A::from_scale_rotation_translation(
            Vec3::new(0.09, 0.13, 0.07),
            Quat::from_euler(EulerRot::XYZ, 0.5, -0.8, 0.3),
            Vec3::new(0.05, -0.1, 0.02),
        ),
        bricks: Brick::of_voxels(min, max, density),
        factor: 2.0,
        extinction: Vec3::new(1.0, 0.5, 0.15),
        material: BRICK,
        ..Grid::default()
    }
}

#[test]
fn a_lump_of_random_voxels() {
    for kind in kinds() {
        assert_agrees(&scene_of(kind, lump()), TOLERANCE);
    }
}

#[test]
fn a_lump_among_discs_glass_and_walls() {
    for kind in kinds() {
        let mut scene = scene_of(kind, lump());
        scene.particles = random_discs(60, 3);
        for disc in &mut scene.particles {
            (disc.material, disc.radius) = (DISC, disc.radius.max(0.03));
            if let LightKind::Point { position } = kind {
                let way = disc.center - position;
                let least = 3.0 * disc.radius + 0.3;
                disc.center = position + way.normalize_or(Vec3::X) * way.length().max(least);
            }
        }
        let mut chance = Chance::new(4);
        for i in 0..8 {
            let center = chance.vec3(-1.2, 1.2);
            let corners = [0; 3].map(|_| center + chance.vec3(-0.6, 0.6));
            scene.triangles.push(triangle(corners, if i % 2 == 0 { GLASS } else { WALL }));
        }
        assert_agrees(&scene, EDGED);
    }
}

#[test]
fn a_changed_voxel_is_noticed() {
    let scene = scene_of(kinds()[1], lump());
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    let mut other = scene.clone();
    let middle = other.grids[0].bricks.iter_mut().find(|brick| brick.origin == IVec3::ZERO);
    let Some(Brick { density: Density::Voxels(voxels), .. }) = middle else { panic!("no brick") };
    let at = UVec3::splat(3);
    let old = voxels.clone();
    *voxels = Voxels::new(|place| old.at(place) + if place == at { 1.0 } else { 0.0 });
    let (maps, _) = render_maps(&other, std::slice::from_ref(view));
    assert!(compare_maps(&expected, &maps[0], TOLERANCE).is_err());
    let (maps, _) = render_maps(&scene, std::slice::from_ref(view));
    compare_maps(&expected, &maps[0], TOLERANCE).unwrap();
}

/// The line through a texel of a view; a way is a metre along the axis.
fn texel_line(view: &View, texel: u32) -> Line {
    let world_from_view = view.view_from_world.as_dmat4().inverse();
    let texel = UVec2::new(texel % view.size.x, texel / view.size.x).as_dvec2() + 0.5;
    let aside = (texel - view.size.as_dvec2() * 0.5) / f64::from(view.scale);
    let aside = DVec3::new(aside.x, -aside.y, 0.0);
    let (start, way) = match view.projection {
        Projection::Orthographic => (aside, DVec3::NEG_Z),
        Projection::Perspective => (DVec3::ZERO, aside + DVec3::NEG_Z),
    };
    Line {
        start: world_from_view.transform_point3(start),
        way: world_from_view.transform_vector3(way),
    }
}

/// The line through each texel of an orthographic view, and its transmittance in all maps.
fn each_texel(scene: &Scene, check: impl Fn(&Line, f32, [f64; 2], [f32; 3])) {
    let view = &shadow_views(scene)[0];
    let mut all = render_maps(scene, std::slice::from_ref(view)).0;
    for tier in TIERS {
        all.extend(map_frame(tier, scene).maps);
    }
    for maps in all {
        for (i, &filter) in (0..).zip(&maps.filter) {
            check(
                &texel_line(view, i),
                view.scale,
                [f64::from(view.near), f64::from(view.far)],
                filter,
            );
        }
    }
}

/// Value noise of three octaves in a ball, 0 at its surface.
fn cloud(edge: i32) -> Grid {
    let lattice = |p: IVec3| {
        let hash = p.to_array().into_iter().fold(7, |hash, x| pcg(hash ^ x.cast_unsigned()));
        (hash >> 8) as f32 / (1 << 24) as f32
    };
    let noise = |p: Vec3| {
        let (cell, part) = (p.floor(), p - p.floor());
        let smooth = part * part * (3.0 - 2.0 * part);
        (0..8).fold(0.0, |sum, i| {
            let corner = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
            let weight = Vec3::select(corner.cmpeq(IVec3::ONE), smooth, 1.0 - smooth);
            sum + weight.element_product() * lattice(cell.as_ivec3() + corner)
        })
    };
    let half = edge / 2;
    let density = |voxel: IVec3| {
        let p = voxel.as_vec3() / half as f32;
        let wisps: f32 = [3.0, 7.0, 15.0].map(|f| noise(p * f + 40.0) * 2.1 / f).iter().sum();
        (1.0 - p.length_squared() - wisps).clamp(0.0, 0.6)
    };
    Grid {
        world_from_index: Affine3A::from_scale(Vec3::splat(2.0 / edge as f32)),
        bricks: Brick::of_voxels(IVec3::splat(-half), IVec3::splat(half), density),
        factor: 4.0,
        extinction: Vec3::new(1.0, 0.6, 0.3),
        material: BRICK,
        ..Grid::default()
    }
}

/// Light at all depths of all texels.
#[test]
fn curves_of_a_cloud() {
    const DEPTHS: usize = 64;
    for kind in [kinds()[0], kinds()[1], kinds()[3]] {
        let mut scene = scene_of(kind, cloud(48));
        (scene.shadow.receiver, scene.shadow.nodes, scene.shadow.size) = (Receiver::Curve, 8, 32);
        let views = shadow_views(&scene);
        let mut all = vec![render_maps(&scene, &views).0];
        all.extend(TIERS.map(|tier| map_frame(tier, &scene).maps));
        let (mut sums, mut count) = (vec![0.0; all.len()], 0.0);
        for (index, view) in views.iter().enumerate() {
            for i in 0..view.size.x * view.size.y {
                let line = texel_line(view, i);
                let depths = line.optical_depths(&scene.grids[0], [view.near, view.far], DEPTHS);
                for (number, tau) in depths.into_iter().enumerate() {
                    let depth = (number as f32 + 0.5) / DEPTHS as f32;
                    let expected = (-tau * 4.0 * DVec3::new(1.0, 0.6, 0.3)).map(f64::exp);
                    count += 3.0;
                    for (sum, maps) in sums.iter_mut().zip(&all) {
                        let curve = maps[index].curve.as_ref().unwrap();
                        let light = curve.light_at(i as usize, depth).as_dvec3();
                        *sum += (light - expected).abs().element_sum();
                    }
                }
            }
        }
        for sum in sums {
            println!("{kind:?}: mean error of curves {:.5}", sum / count);
            assert!(sum / count <= 0.004, "{kind:?}: {}", sum / count);
        }
    }
}

/// Beer-Lambert law: a box of constant density, as one brick and as bricks with voxels.
#[test]
fn a_homogeneous_box() {
    let size = UVec3::new(24, 16, 40);
    let whole = Brick::new(IVec3::ZERO, Density::Constant { size, density: 0.75 });
    let mut parts = Vec::new();
    for z in 0..size.z / 8 {
        for y in 0..size.y / 8 {
            for x in 0..size.x / 8 {
                let density = Density::Voxels(Voxels::new(|_| 0.75));
                parts.push(Brick::new(UVec3::new(x, y, z).as_ivec3() * 8, density));
            }
        }
    }
    for bricks in [vec![whole], parts] {
        let grid = Grid {
            world_from_index: Affine3A::from_scale_rotation_translation(
                Vec3::new(0.05, 0.1, 0.06),
                Quat::from_rotation_y(0.4),
                Vec3::new(-0.6, -0.8, -1.2),
            ),
            bricks,
            factor: 1.5,
            extinction: Vec3::new(1.0, 0.5, 0.2),
            material: BRICK,
            ..Grid::default()
        };
        let scene = scene_of(kinds()[0], grid.clone());
        each_texel(&scene, |line, scale, ways, filter| {
            let edge = 0.05 / f64::from(scale);
            let chord = |grow| line.chord(&grid, DVec3::ZERO, size.as_dvec3(), grow, ways);
            if chord(edge) - chord(-edge) > 8.0 * edge {
                return;
            }
            for (channel, extinction) in [1.0, 0.5, 0.2].into_iter().enumerate() {
                let expected = (-0.75 * 1.5 * extinction * chord(0.0)).exp();
                let error = (f64::from(filter[channel]) - expected).abs();
                assert!(error <= TOLERANCE.filter, "{filter:?} instead of {expected}");
            }
        });
    }
}

/// Beer-Lambert law: a ball of voxels with density 1 up to its surface, where the last voxels get the share
/// of the ray that is inside. Along a line of voxels the integral is their sum.
#[test]
fn a_ball_of_voxels() {
    const RADIUS: f32 = 13.0;
    let density = |voxel: IVec3| {
        let aside = voxel.truncate().as_vec2().length_squared();
        let half = (RADIUS * RADIUS - aside).max(0.0).sqrt();
        // Share of the line's stretch in the voxel that is inside.
        let depth = voxel.z as f32;
        ((depth + 0.5).min(half) - (depth - 0.5).max(-half)).max(0.0)
    };
    let grid = Grid {
        // The centres of texels are those of voxels: the map's window is 20 m, see `hold_view`.
        world_from_index: Affine3A::from_scale_rotation_translation(
            Vec3::splat(20.0 / 64.0),
            Quat::IDENTITY,
            Vec3::new(10.0 / 64.0, 10.0 / 64.0, 0.0),
        ),
        bricks: Brick::of_voxels(IVec3::splat(-16), IVec3::splat(16), density),
        factor: 0.4,
        extinction: Vec3::new(1.0, 0.5, 0.2),
        material: BRICK,
        ..Grid::default()
    };
    let mut scene = scene_of(LightKind::Directional { direction: Vec3::NEG_Z }, grid.clone());
    hold_view(&mut scene, WALL);
    let index = index_from_world(&grid);
    let middle = std::cell::Cell::new(0);
    each_texel(&scene, |line, _, _, filter| {
        let place = index.transform_point3(line.start).truncate();
        assert!((place - place.round()).abs().max_element() < 1e-4, "{place}");
        let half = (f64::from(RADIUS).powi(2) - place.round().length_squared()).max(0.0).sqrt();
        let chord = 2.0 * half * 20.0 / 64.0;
        middle.set(middle.get() + usize::from(half > 0.0));
        for (channel, extinction) in [1.0, 0.5, 0.2].into_iter().enumerate() {
            let expected = (-0.4 * extinction * chord).exp();
            // The shares are half floats.
            let error = (f64::from(filter[channel]) - expected).abs();
            assert!(error <= 2.0 * TOLERANCE.filter, "{filter:?} instead of {expected} at {place}");
        }
    });
    assert!(middle.get() > 3 * 400, "{middle:?}");
}

/// Bricks of a few texels are scattered to the sums, and so are those whose pairs do not fit.
#[test]
fn scattered_bricks() {
    let mut scene = scene_of(kinds()[0], lump());
    scene.grids[0].world_from_index.matrix3 *= 0.6;
    scene.grids[0].factor /= 0.6;
    hold_view(&mut scene, WALL);
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    for tier in TIERS {
        let frame = map_frame(tier, &scene);
        assert!(frame.counters.scattered > 5, "{tier:?}: {:?}", frame.counters);
        assert_maps_agree(&expected, &frame.maps[0], SUMMED);
    }
    let mut scene = scene_of(kinds()[1], lump());
    scene.shadow.pair_budget = 16;
    let expected = render(&scene, &shadow_views(&scene)[0]);
    for tier in TIERS {
        let frame = map_frame_scattered(tier, &scene);
        assert!(frame.counters.overflowed > 5, "{tier:?}: {:?}", frame.counters);
        assert_maps_agree(&expected, &frame.maps[0], SUMMED);
        assert_maps_agree(&expected, &map_frame(tier, &scene).maps[0], SUMMED);
    }
}

#[test]
fn forms_of_bricks_agree() {
    let mut scene = scene_of(kinds()[1], lump());
    assert_forms_agree("bricks", &scene);
    scene.shadow.receiver = Receiver::Curve;
    assert_forms_agree("curves of bricks", &scene);
}

/// A row of bricks on one tile, longer than a segment, each with eight cells: llvmpipe ends loops after
/// 65,535 turns, including those over cells.
#[test]
fn a_row_of_bricks() {
    const COUNT: i32 = 2500;
    let voxels = Voxels::new(|place| if place.x % 2 == 0 { 1.0 } else { 0.5 });
    let brick = |i| Brick::new(IVec3::Z * 8 * i, Density::Voxels(voxels.clone()));
    let grid = Grid {
        world_from_index: Affine3A::from_scale(Vec3::new(1.0, 1.0, 1e-3)),
        bricks: (0..COUNT).map(brick).collect(),
        factor: 0.1,
        extinction: Vec3::new(1.0, 0.5, 0.2),
        material: BRICK,
        ..Grid::default()
    };
    let mut scene = scene_of(LightKind::Directional { direction: Vec3::NEG_Z }, grid);
    scene.shadow.size = 16;
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        scene.shadow.receiver = receiver;
        let view = &shadow_views(&scene)[0];
        let length = 8e-3 * f64::from(COUNT);
        for tier in TIERS {
            let maps = &map_frame(tier, &scene).maps[0];
            let mut inside = 0;
            for (i, filter) in (0..).zip(&maps.filter) {
                let x = texel_line(view, i).start.truncate();
                if x.min_element() < 0.0 || x.max_element() > 8.0 {
                    continue;
                }
                inside += 1;
                // Between voxels of density 1 and 1/2 along x.
                let density = 1.0 - 0.5 * (1.0 - ((x.x % 2.0) - 1.0).abs());
                let expected = (-0.1 * density * length * DVec3::new(1.0, 0.5, 0.2)).map(f64::exp);
                let error = (Vec3::from_array(*filter).as_dvec3() - expected).abs().max_element();
                assert!(error <= SUMMED.filter, "{receiver:?} {tier:?}: {filter:?} {expected}");
            }
            assert!(inside > 16, "{inside}");
        }
    }
}
