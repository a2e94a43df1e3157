//! Bricks of grids: CPU reference and both tiers against closed forms and a march in 64 bits.
use super::brute_force::assert_agrees;
use crate::common::{
    brute_force::render,
    compare::{Tolerance, compare_maps},
    grid_truth::{Line, index_from_world},
    scenes::{Chance, empty, light, material, random_discs, triangle},
};
use gobo::{
    glam::{Affine3A, DVec2, DVec3, EulerRot, IVec3, Quat, UVec3, Vec3, Vec4},
    internals::{reference::render_maps, view::shadow_views},
    model::{Brick, Density, Grid, LightKind, Material, Shape, Transfer, Voxels},
    scene::Scene,
};

/// What the filter's halves round below 1, and 1e-4.
const TOLERANCE: Tolerance = Tolerance { filter: 1e-4 + 1.0 / 4096.0, depth: 1e-5, undecided: 0.0 };
const EDGED: Tolerance = Tolerance { undecided: 0.25, ..TOLERANCE };

const BRICK: u32 = 0;
const DISC: u32 = 1;
const GLASS: u32 = 2;
const WALL: u32 = 3;

fn kinds() -> [LightKind; 4] {
    let position = Vec3::new(3.0, 4.0, 2.5);
    [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 },
        LightKind::Point { position: Vec3::new(2.4, 0.3, -0.2) },
        LightKind::Point { position: Vec3::new(0.13, 0.21, -0.17) },
    ]
}

fn scene_of(kind: LightKind, grid: Grid) -> Scene {
    let brick = Material { shape: Shape::Brick, ..material(Transfer::Filter) };
    let glass = Material { tint: Vec4::new(0.9, 0.4, 0.3, 0.5), ..material(Transfer::Filter) };
    let materials = vec![brick, material(Transfer::Filter), glass, material(Transfer::Opaque)];
    Scene { lights: vec![light(kind)], grids: vec![grid], ..empty(materials) }
}

/// A lump of 21 x 17 x 19 random voxels around the origin, many of them empty, scaled by unlike factors and rotated.
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

/// The line through each texel of an orthographic view, and its transmittance in all maps.
fn each_texel(scene: &Scene, check: impl Fn(&Line, f32, [f64; 2], [f32; 3])) {
    let view = &shadow_views(scene)[0];
    let mut all = render_maps(scene, std::slice::from_ref(view)).0;
    for tier in crate::common::TIERS {
        all.extend(crate::common::map_frame(tier, scene).maps);
    }
    let world_from_view = view.view_from_world.as_dmat4().inverse();
    for maps in all {
        for (i, &filter) in (0..).zip(&maps.filter) {
            let texel = DVec2::new(f64::from(i % view.size.x), f64::from(i / view.size.x)) + 0.5;
            let at = (texel - view.size.as_dvec2() * 0.5) / f64::from(view.scale);
            let start = world_from_view.transform_point3(DVec3::new(at.x, -at.y, 0.0));
            let line = Line { start, way: world_from_view.transform_vector3(DVec3::NEG_Z) };
            check(&line, view.scale, [f64::from(view.near), f64::from(view.far)], filter);
        }
    }
}

/// Beer and Lambert: a box of constant density, as one brick and as bricks of voxels within it.
#[test]
fn a_homogeneous_box() {
    let size = UVec3::new(24, 16, 40);
    let whole = Brick { origin: IVec3::ZERO, density: Density::Constant { size, density: 0.75 } };
    let mut parts = Vec::new();
    for z in 0..size.z / 8 {
        for y in 0..size.y / 8 {
            for x in 0..size.x / 8 {
                let density = Density::Voxels(Voxels::new(|_| 0.75));
                parts.push(Brick { origin: UVec3::new(x, y, z).as_ivec3() * 8, density });
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

/// Beer and Lambert: a ball of voxels whose density is 1 up to its surface, where the last voxels are given the share
/// of the ray that is inside. Along a line of voxels the integral is their sum.
#[test]
fn a_ball_of_voxels() {
    const RADIUS: f32 = 13.0;
    let density = |voxel: IVec3| {
        let aside = voxel.truncate().as_vec2().length_squared();
        let half = (RADIUS * RADIUS - aside).max(0.0).sqrt();
        // Share of the voxel's stretch of the line that is inside.
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
    };
    let mut scene = scene_of(LightKind::Directional { direction: Vec3::NEG_Z }, grid.clone());
    crate::common::scenes::hold_view(&mut scene, WALL);
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
            // The shares are halves.
            let error = (f64::from(filter[channel]) - expected).abs();
            assert!(error <= 2.0 * TOLERANCE.filter, "{filter:?} instead of {expected} at {place}");
        }
    });
    assert!(middle.get() > 3 * 400, "{middle:?}");
}
