//! Bricks of grids in the picture.
use crate::common::{
    TIERS,
    grid_truth::Line,
    reference_picture, render,
    scenes::{empty, light, material, random_discs, triangle},
};
use gobo::{
    glam::{Affine3A, DVec3, EulerRot, IVec3, Quat, UVec2, UVec3, Vec3, Vec4},
    model::{Brick, Density, Grid, Light, LightKind, Material, Receiver, Shape, Transfer, Voxels},
    records::Picture,
};
use gobo_scene::Scene;

const BRICK: u32 = 0;
const DISC: u32 = 1;
const GLASS: u32 = 2;
const FLOOR: u32 = 3;

/// A ball with bumps, of `edge` voxels in a cube of 2 m around `middle`.
fn ball(edge: i32, middle: Vec3) -> Grid {
    let half = 0.5 * (edge - 1) as f32;
    let density = |voxel: IVec3| {
        let p = (voxel.as_vec3() - half) / half;
        let bumps = 0.15 * (9.0 * p.x).sin() * (7.0 * p.y + 1.0).cos() * (8.0 * p.z).cos();
        (2.0 * (0.9 + bumps - p.length())).clamp(0.0, 1.0)
    };
    Grid {
        world_from_index: Affine3A::from_translation(middle)
            * Affine3A::from_scale(Vec3::splat(1.0 / half))
            * Affine3A::from_translation(Vec3::splat(-half)),
        bricks: Brick::of_voxels(IVec3::ZERO, IVec3::splat(edge - 1), density),
        factor: 3.0,
        extinction: Vec3::new(1.0, 0.6, 0.3),
        material: BRICK,
        anisotropy: 0.4,
        ..Grid::default()
    }
}

/// A grid of `albedo` under a sun, in the dark.
fn scene_of(grid: Grid, albedo: Vec3) -> Scene {
    let brick =
        Material { shape: Shape::Brick, tint: albedo.extend(1.0), ..material(Transfer::Filter) };
    let glass = Material { tint: Vec4::new(0.9, 0.4, 0.3, 0.5), ..material(Transfer::Filter) };
    let materials = vec![brick, material(Transfer::Filter), glass, material(Transfer::Opaque)];
    let direction = Vec3::new(-0.7, -0.6, -0.3).normalize();
    let mut scene = empty(materials);
    scene.lights = vec![Light { intensity: 3.0, ..light(LightKind::Directional { direction }) }];
    scene.grids = vec![grid];
    scene.camera.eye = Vec3::new(0.5, 0.8, 3.2);
    scene.camera.size = UVec2::splat(60);
    scene.shadow.receiver = Receiver::Curve;
    (scene.shadow.nodes, scene.shadow.size, scene.shadow.bias) = (16, 256, Some(0.0));
    scene
}

/// Sum of the differences as a share of the sum, and the largest as a share of the largest value.
fn apart(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut sum, mut all, mut most, mut largest) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for (value, expected) in values {
        let difference = (value - expected).abs();
        (sum, all) = (sum + difference, all + expected);
        (most, largest) = (most.max(difference), largest.max(expected));
    }
    (sum / all, most / largest)
}

fn channels(picture: &Picture) -> impl Iterator<Item = f64> {
    picture.light.iter().flatten().map(|&value| f64::from(value))
}

fn assert_matches_reference(scene: &Scene) {
    let expected = reference_picture(scene);
    for tier in TIERS {
        let own = render(tier, scene).picture;
        let (mean, most) = apart(channels(&own).zip(channels(&expected)));
        println!("{tier:?}: mean {mean}, most {most}");
        assert!(mean < 1e-3 && most < 0.03, "{tier:?}: mean {mean}, most {most}");
    }
}

/// Two grids, one with a box of constant density, among discs, glass and a floor, in three lights.
fn stage() -> Scene {
    let mut grid = ball(21, Vec3::new(-0.3, 0.1, 0.0));
    let turn = Quat::from_euler(EulerRot::XYZ, 0.4, 0.8, -0.3);
    grid.world_from_index = Affine3A::from_quat(turn) * grid.world_from_index;
    let mut scene = scene_of(grid, Vec3::new(0.9, 0.8, 0.5));
    let size = UVec3::new(30, 9, 12);
    scene.grids.push(Grid {
        world_from_index: Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.05),
            Quat::from_rotation_y(0.5),
            Vec3::new(-1.0, -0.9, 0.6),
        ),
        bricks: vec![Brick::new(IVec3::ZERO, Density::Constant { size, density: 0.7 })],
        anisotropy: -0.3,
        ..Grid::default()
    });
    let lamp = Vec3::new(-1.5, 2.0, 1.5);
    let spot = LightKind::Spot { position: lamp, direction: -lamp.normalize(), angle: 1.0 };
    let inside = LightKind::Point { position: Vec3::new(-0.25, 0.2, 0.05) };
    scene.lights.push(Light { intensity: 14.0, color: Vec3::new(0.3, 0.6, 1.0), ..light(spot) });
    scene.lights.push(Light { intensity: 0.8, color: Vec3::new(1.0, 0.4, 0.1), ..light(inside) });
    scene.ambient = Vec3::new(0.05, 0.06, 0.08);
    scene.background = Vec3::new(0.1, 0.15, 0.2);
    scene.particles = random_discs(60, 3);
    scene.particles.iter_mut().for_each(|disc| disc.material = DISC);
    let glass = [(-1.2, -0.8), (1.4, -0.6), (0.1, 1.5)].map(|(x, y)| Vec3::new(x, y, 1.2));
    let floor = [(-9.0, 9.0), (9.0, 9.0), (0.0, -9.0)].map(|(x, z)| Vec3::new(x, -1.1, z));
    scene.triangles = vec![triangle(glass, GLASS), triangle(floor, FLOOR)];
    scene
}

#[test]
fn gpu_matches_reference() {
    let mut scene = stage();
    (scene.shadow.nodes, scene.shadow.size) = (8, 128);
    assert_matches_reference(&scene);
    // From inside, where most bricks are outside the picture; and by the nearest depth.
    scene.camera.eye = Vec3::new(-0.2, 0.15, 0.35);
    scene.camera.size = UVec2::new(40, 30);
    assert_matches_reference(&scene);
    scene.shadow.receiver = Receiver::Nearest;
    assert_matches_reference(&scene);
}

/// A hot, opaque body has the colour of its temperature.
#[test]
fn soot_glows_as_a_black_body() {
    let cube = |kelvin: f32| {
        let density = Density::Voxels(Voxels::new(|_| 40.0));
        let temperature = Some(Voxels::new(|_| kelvin));
        let bricks = vec![Brick { temperature, ..Brick::new(IVec3::ZERO, density) }];
        let world_from_index = Affine3A::from_translation(Vec3::splat(-4.0));
        let grid = Grid { bricks, world_from_index, emission: 0.5, ..Grid::default() };
        let mut scene = scene_of(grid, Vec3::ONE);
        scene.lights.clear();
        (scene.camera.eye, scene.camera.size) = (Vec3::new(0.0, 0.0, 9.0), UVec2::splat(8));
        scene
    };
    // By the table of the CIE's observer of 1931, as shares of red at 1500 K.
    for (kelvin, truth) in [
        (1500.0, [1.0, 0.133, 0.0]),
        (1850.0, [18.203, 4.013, 0.0]),
        (2700.0, [907.9, 377.3, 89.9]),
        (6500.0, [126_902.0, 119_717.0, 125_806.0]),
    ] {
        let scene = cube(kelvin);
        let mut pictures = vec![reference_picture(&scene)];
        pictures.extend(TIERS.map(|tier| render(tier, &scene).picture));
        for picture in &pictures {
            let found = Vec3::from(picture.light[4 * 8 + 4]);
            let expected = 0.5 * Vec3::from(truth);
            let apart = (found - expected).abs().max_element() / expected.max_element();
            assert!(apart < 0.03, "{kelvin} K: {found}, not {expected}");
        }
    }
}

/// Light that a grid sends along a line, by definition: at each of `STEPS` positions the transmittance up to
/// there, times the sun's light there, scattered four times.
fn marched(scene: &Scene, line: &Line) -> DVec3 {
    const STEPS: usize = 96;
    /// Part of the line that contains the grid [m].
    const RANGE: [f64; 2] = [1.5, 4.9];
    let grid = &scene.grids[0];
    let LightKind::Directional { direction } = scene.lights[0].kind else { panic!("a sun") };
    let sun = -direction.as_dvec3();
    let extinction = (grid.extinction * grid.factor).as_dvec3();
    let albedo = scene.materials[BRICK as usize].tint.truncate().as_dvec3();
    let passed = |integral: f64| (-extinction * integral).map(f64::exp);
    // Twice as many depths: those with odd numbers are between two steps.
    let depths = line.optical_depths(grid, RANGE.map(|way| way as f32), 2 * STEPS);
    let mut light = DVec3::ZERO;
    for step in 0..STEPS - 1 {
        let [from, to] = [2 * step, 2 * step + 2].map(|number| passed(depths[number]));
        if (from - to).max_element() < 1e-9 {
            continue;
        }
        let part = (2.0 * step as f64 + 1.5) / (2 * STEPS) as f64;
        let at = RANGE[0] + (RANGE[1] - RANGE[0]) * part;
        let toward = Line { start: line.start + line.way * at, way: sun };
        // Up to the middle of the path.
        let through = passed(toward.optical_depths(grid, [0.0, 8.0], 1)[0]);
        let cosine = sun.dot(line.way);
        let (mut arriving, mut before) = (DVec3::ZERO, DVec3::ZERO);
        for order in 0..4 {
            let half = 0.5_f64.powi(order);
            let g = f64::from(grid.anisotropy) * half;
            let spread = 1.0 + g * g - 2.0 * g * cosine;
            let phase = (1.0 - g * g) / (4.0 * std::f64::consts::PI * spread.powf(1.5));
            let kept = ((through - 1.0 / 1024.0) / (1.0 - 1.0 / 1024.0)).max(DVec3::ZERO);
            let found = kept.powf(half);
            arriving += (0.5 * albedo).powf(f64::from(order)) * (found - before) * phase;
            before = found;
        }
        light += (from - to) * arriving * albedo * f64::from(scene.lights[0].intensity);
    }
    light
}

/// Light is linear between points two voxels apart, where it falls by up to a third, and each third of a
/// ray's path through a brick has even density.
const INTERPOLATED: (f64, f64) = (0.016, 0.045);

/// No brick is visible: the light of a cloud of 4 x 4 x 4 bricks equals that of a march through its voxels.
#[test]
fn a_cloud_shades_itself() {
    const APART: u32 = 4;
    let scene = scene_of(ball(30, Vec3::ZERO), Vec3::new(0.95, 0.8, 0.4));
    let camera = &scene.camera;
    let eye = camera.eye.as_dvec3();
    let ahead = (camera.target.as_dvec3() - eye).normalize();
    let right = ahead.cross(DVec3::Y).normalize();
    let size = camera.size.y;
    let slope = (f64::from(camera.fov_y) * 0.5).tan() * 2.0 / f64::from(size);
    let mut expected = Vec::new();
    for y in (2..size).step_by(APART as usize) {
        for x in (2..size).step_by(APART as usize) {
            let aside = |at: u32| (f64::from(at) + 0.5 - 0.5 * f64::from(size)) * slope;
            let way = ahead + right * aside(x) - right.cross(ahead) * aside(y);
            let line = Line { start: eye, way: way.normalize() };
            expected.push(((y * size + x) as usize, marched(&scene, &line)));
        }
    }
    let agrees = |picture: &Picture| {
        let own = expected.iter().flat_map(|&(at, light)| {
            let own = picture.light[at].map(f64::from);
            own.into_iter().zip(light.to_array())
        });
        apart(own)
    };
    let mut pictures = vec![reference_picture(&scene)];
    pictures.extend(TIERS.map(|tier| render(tier, &scene).picture));
    for picture in &pictures {
        let (mean, most) = agrees(picture);
        println!("mean {mean}, most {most}");
        assert!(mean < INTERPOLATED.0 && most < INTERPOLATED.1, "mean {mean}, most {most}");
    }
}
