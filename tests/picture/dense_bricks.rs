//! Dense voxels: light falls within a single voxel.
use crate::common::{
    TIERS, reference_picture, render,
    scenes::{empty, light, material},
    tiers,
};
use gobo::{
    glam::{Affine3A, DAffine3, DVec3, IVec3, Mat3, UVec2, UVec3, Vec3},
    gpu::Tier,
    model::{Brick, Density, Grid, LightKind, Material, Receiver, Shape, Transfer},
    records::{Bricks, LATTICE_EDGE, Picture},
};
use gobo_scene::Scene;

/// First and last voxel of the box along each axis, of density 1.
const BOX: [i32; 2] = [3, 12];
/// Edge of a voxel [m].
const VOXEL: f32 = 0.1;
/// Extinction by channel.
const COLOR: DVec3 = DVec3::new(1.0, 0.5, 0.25);
/// Directions in which the sun shines, world space.
const SUN: Vec3 = Vec3::new(0.3, -1.0, 0.2);

/// A rotated box of 10^3 voxels with optical depth `depth` per voxel, under a sun. Its bricks begin at voxel
/// numbers that are multiples of 8, less `shift`.
fn stage(depth: f32, shift: i32) -> Scene {
    let body = Material { shape: Shape::Brick, ..material(Transfer::Filter) };
    let mut scene = empty(vec![body]);
    let shifted = IVec3::splat(shift);
    let [first, last] = BOX.map(|voxel| IVec3::splat(voxel) + shifted);
    scene.grids = vec![Grid {
        world_from_index: world_from_index() * Affine3A::from_translation(-shifted.as_vec3()),
        bricks: Brick::of_voxels(first, last, |_| 1.0),
        factor: depth / VOXEL,
        extinction: COLOR.as_vec3(),
        ..Grid::default()
    }];
    let direction = SUN.normalize();
    scene.lights = vec![light(LightKind::Directional { direction })];
    scene.camera.eye = Vec3::new(-0.6, 1.6, 3.0);
    scene.camera.target = Vec3::new(-0.6, 1.2, 0.0);
    scene.camera.fov_y = 40.0_f32.to_radians();
    scene.camera.size = UVec2::new(96, 60);
    scene.samples = 1;
    scene.shadow.receiver = Receiver::Curve;
    (scene.shadow.nodes, scene.shadow.size) = (8, 512);
    scene
}

fn world_from_index() -> Affine3A {
    Affine3A::from_translation(Vec3::new(-1.5, 0.5, -0.8))
        * Affine3A::from_rotation_y(30.0_f32.to_radians())
        * Affine3A::from_scale(Vec3::splat(VOXEL))
}

/// Density at a position in index space: trilinear between the box's voxels and the surrounding ones, which
/// are 0.
fn density(place: DVec3) -> f64 {
    let [first, last] = BOX.map(f64::from);
    let rises = place - (first - 1.0);
    let falls = last + 1.0 - place;
    rises.min(falls).clamp(DVec3::ZERO, DVec3::ONE).element_product()
}

/// Integral of density along a ray from a position, in steps of an eighth of a voxel, until it is surely
/// outside; `way`: a voxel's length.
fn shade(place: DVec3, way: DVec3) -> f64 {
    (0..160).map(|i| density(place + way * ((f64::from(i) + 0.5) / 8.0)) / 8.0).sum()
}

/// Light that the box sends along a ray from the eye, up to a factor: the absorption of each sixteenth of a
/// voxel, times the sun's light there, scattered four times (docs/grids.md).
fn marched(eye: DVec3, way: DVec3, sun: DVec3, depth: f64) -> DVec3 {
    const STEP: f64 = 1.0 / 16.0;
    let (mut left, mut sum) = (DVec3::ONE, DVec3::ZERO);
    for i in 0..1200 {
        let place = eye + way * ((f64::from(i) + 0.5) * STEP);
        let tau = density(place) * depth * STEP;
        if tau == 0.0 {
            continue;
        }
        let passed = (-COLOR * tau).map(f64::exp);
        let shadow = COLOR * shade(place, sun) * depth;
        let (mut arriving, mut before) = (DVec3::ZERO, DVec3::ZERO);
        for half in [1.0, 0.5, 0.25, 0.125] {
            let found = (-shadow * half).map(f64::exp);
            arriving += half * (found - before);
            before = found;
        }
        sum += left * (1.0 - passed) * arriving;
        left *= passed;
    }
    sum
}

/// Light at each pixel of a camera.
fn truth(scene: &Scene, depth: f64) -> Vec<DVec3> {
    let to_index = {
        let a = world_from_index();
        DAffine3::from_mat3_translation(Mat3::from(a.matrix3).as_dmat3(), a.translation.as_dvec3())
            .inverse()
    };
    let camera = &scene.camera;
    let eye = camera.eye.as_dvec3();
    let ahead = (camera.target.as_dvec3() - eye).normalize();
    let right = ahead.cross(DVec3::Y).normalize();
    let up = right.cross(ahead);
    let size = camera.size.as_dvec2();
    let slope = (f64::from(camera.fov_y) * 0.5).tan() * 2.0 / size.y;
    let start = to_index.transform_point3(eye);
    let sun = to_index.transform_vector3(-SUN.as_dvec3()).normalize();
    let pixels = (0..camera.size.y).flat_map(|y| (0..camera.size.x).map(move |x| (x, y)));
    let ray = |(x, y): (u32, u32)| {
        let [x, y] = [f64::from(x) + 0.5 - size.x * 0.5, f64::from(y) + 0.5 - size.y * 0.5];
        let way = ahead + right * (x * slope) - up * (y * slope);
        marched(start, to_index.transform_vector3(way).normalize(), sun, depth)
    };
    pixels.map(ray).collect()
}

/// Mean and largest difference of the box's pixels, as shares of the brightest; the brightness of the lamp is
/// fitted.
fn apart(picture: &Picture, truth: &[DVec3]) -> (f64, f64) {
    let seen: Vec<_> = picture
        .light
        .iter()
        .zip(truth)
        .filter(|(_, truth)| truth.max_element() > 1e-3)
        .map(|(own, truth)| (DVec3::from_array([own[0], own[1], own[2]].map(f64::from)), *truth))
        .collect();
    let product: f64 = seen.iter().map(|(own, truth)| own.dot(*truth)).sum();
    let square: f64 = seen.iter().map(|(_, truth)| truth.length_squared()).sum();
    let scale = product / square;
    let brightest = seen.iter().map(|(_, truth)| truth.max_element()).fold(0.0, f64::max);
    let differences = seen.iter().map(|(own, truth)| (*own / scale - *truth).abs() / brightest);
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for difference in differences {
        sum += difference.element_sum() / 3.0;
        most = most.max(difference.max_element());
    }
    (sum / seen.len() as f64, most)
}

/// Optical depth of a voxel, and tolerances of pictures in the mean and at most, as shares of the brightest:
/// light is linear within two thirds of a voxel, and maps store none below 1/1024.
const MUST: [(f32, f64, f64); 2] = [(0.5, 0.01, 0.03), (2.0, 0.02, 0.08)];

#[test]
fn dense_voxels_have_the_light_of_a_march() {
    for (depth, mean_must, most_must) in MUST {
        let scene = stage(depth, 0);
        let expected = truth(&scene, f64::from(depth));
        let mut pictures = vec![reference_picture(&scene)];
        pictures.extend(tiers(Tier::Native).into_iter().map(|tier| render(tier, &scene).picture));
        for picture in &pictures {
            let (mean, most) = apart(picture, &expected);
            assert!(mean < mean_must && most < most_must, "{depth}: mean {mean}, most {most}");
        }
    }
}

/// The division of a box into bricks hardly shows, neither at their faces nor elsewhere: shifted by half a
/// brick the box looks the same, as its points are at the same positions, except for the error of curves
/// behind other bricks. Rays go from one layer of bricks to the next above it while the camera looks down;
/// the second eye is just below the plane between the layers.
#[test]
fn bricks_hardly_show() {
    for (depth, height) in [(0.5, 1.6), (2.0, 1.6), (2.0, 1.695)] {
        let [one, other] = [0, 4].map(|shift| {
            let mut scene = stage(depth, shift);
            scene.camera.eye.y = height;
            scene
        });
        let mut pictures = vec![reference_picture(&other)];
        pictures.extend(tiers(Tier::Native).into_iter().map(|tier| render(tier, &other).picture));
        let expected: Vec<_> = reference_picture(&one)
            .light
            .iter()
            .map(|light| DVec3::from_array([light[0], light[1], light[2]].map(f64::from)))
            .collect();
        for picture in &pictures {
            let (mean, most) = apart(picture, &expected);
            assert!(mean < 0.002 && most < 0.03, "{depth}, {height}: mean {mean}, most {most}");
        }
    }
}

/// Kernels and CPU reference agree, also from inside, with two lamps, one of them in the box.
#[test]
fn kernels_match_reference() {
    let mut scene = stage(1.0, 0);
    // A part of the box, in two bricks.
    scene.grids[0].bricks =
        Brick::of_voxels(IVec3::new(3, 3, BOX[0]), IVec3::new(7, 7, BOX[1]), |_| 1.0);
    let lamp = |position| light(LightKind::Point { position });
    scene.lights.extend([lamp(Vec3::new(-0.6, 1.3, -0.6)), lamp(Vec3::new(-0.6, 2.0, 1.5))]);
    // A dense box of constant density beside it.
    scene.grids.push(Grid {
        world_from_index: Affine3A::from_translation(Vec3::new(0.4, 0.6, 0.0))
            * Affine3A::from_scale(Vec3::splat(VOXEL)),
        bricks: vec![Brick::new(
            IVec3::ZERO,
            Density::Constant { size: UVec3::new(3, 10, 5), density: 0.8 },
        )],
        factor: 10.0,
        ..Grid::default()
    });
    for eye in [scene.camera.eye, Vec3::new(-0.5, 1.2, -0.1)] {
        scene.camera.eye = eye;
        let expected = reference_picture(&scene);
        let brightest = expected.light.iter().flatten().copied().fold(0.0, f32::max);
        for tier in TIERS {
            let own = render(tier, &scene).picture;
            let values = own.light.iter().flatten().zip(expected.light.iter().flatten());
            let most = values.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / brightest;
            assert!(most < 0.01, "{tier:?}: most {most}");
        }
    }
}

/// Thin grids keep their coarse lattices, dense grids have fine ones while there is room.
#[test]
fn lattices_are_as_fine_as_their_grids_want() {
    let edge = |grid: Grid| {
        let bricks = Bricks::new(&[grid], UVec2::new(64, 64));
        bricks.grids().next().map(|(_, grid)| grid.lattice_edge)
    };
    let of_depth = |depth| stage(depth, 0).grids.swap_remove(0);
    assert_eq!(edge(of_depth(0.2)), Some(LATTICE_EDGE));
    assert_eq!(edge(of_depth(0.3)), Some(13));
    let crowd = |count| {
        let grid = of_depth(1.0);
        let bricks = grid.bricks.iter().cycle().take(count).cloned().collect();
        edge(Grid { bricks, ..grid })
    };
    assert_eq!([crowd(900), crowd(2500), crowd(5000)], [Some(13), Some(9), Some(LATTICE_EDGE)]);
}
