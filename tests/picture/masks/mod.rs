//! Shadow masks: look-up and half size, against the CPU reference and against their definition.
mod blur;
mod slots;

use crate::common::{
    TIERS, gpu,
    scenes::{empty, light, material, triangle},
};
use gobo::{
    Camera, Light, LightKind, Material, Transfer, Triangle,
    glam::{UVec2, Vec3, Vec4},
    model::MaskSettings,
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer, picture::debug::DebugMode};
use gobo_reference as reference;
use gobo_scene::Scene;

pub(super) const OFF: MaskSettings = MaskSettings {
    half: false,
    taps: 1,
    depth_scale: 0.0,
    anisotropic: false,
    sensitivity: 100.0,
    limit: 16,
};

fn sheet(corner: Vec3, right: Vec3, up: Vec3, material: u32) -> [Triangle; 2] {
    let far = corner + right + up;
    let normal = right.cross(up).normalize();
    let corners = [[corner, corner + right, far], [corner, far, corner + up]];
    corners.map(|p| Triangle { normals: [normal; 3], ..triangle(p, material) })
}

/// A ground at y = 0, a wall at z = -2, and a bar in front of them; a pane if `glass`.
pub(super) fn room(glass: bool) -> Scene {
    let mut scene = empty(vec![
        material(Transfer::Opaque),
        Material { tint: Vec4::new(0.9, 0.3, 0.1, 1.0), ..material(Transfer::Filter) },
    ]);
    scene.camera = Camera {
        eye: Vec3::new(0.3, 1.5, 5.0),
        target: Vec3::new(0.0, 0.6, 0.0),
        up: Vec3::Y,
        fov_y: 0.7,
        size: UVec2::new(96, 64),
    };
    scene.triangles.extend(sheet(Vec3::new(-9.0, 0.0, 9.0), Vec3::X * 18.0, Vec3::Z * -18.0, 0));
    scene.triangles.extend(sheet(Vec3::new(-9.0, 0.0, -2.0), Vec3::X * 18.0, Vec3::Y * 9.0, 0));
    // Above the picture.
    scene.triangles.extend(sheet(Vec3::new(-0.6, 3.0, -0.5), Vec3::X * 1.2, Vec3::Z * 0.7, 0));
    if glass {
        let corner = Vec3::new(-0.9, 2.9, 0.4);
        scene.triangles.extend(sheet(corner, Vec3::X * 2.0, Vec3::Z * 0.8, 1));
    }
    let sun = LightKind::Directional { direction: Vec3::new(-0.2, -1.0, -0.3) };
    let lamp = LightKind::Point { position: Vec3::new(0.8, 4.0, 1.0) };
    scene.lights = vec![
        Light { name: "sun".into(), size: Some(512), intensity: 2.0, ..light(sun) },
        Light { name: "lamp".into(), size: Some(256), intensity: 30.0, ..light(lamp) },
    ];
    scene
}

/// The masks, four bytes per pixel, layer by layer, and the light of the picture.
fn masks_of(scene: &Scene) -> (Vec<[u8; 4]>, Vec<[f32; 3]>) {
    let options =
        RenderOptions { light: true, debug: &[DebugMode::Masks], ..RenderOptions::default() };
    let frame = Renderer::on(gpu(TIERS[0])).unwrap().render(scene, &options).unwrap();
    let shown = &frame.debug[0].1;
    let width = scene.camera.size.x as usize;
    let rows = shown.rgb.chunks_exact(2 * width);
    let join = |row: &[[u8; 3]]| {
        let texel = |i: usize| [row[i][0], row[i][1], row[i][2], row[width + i][0]];
        (0..width).map(texel).collect::<Vec<_>>()
    };
    (rows.flat_map(join).collect(), frame.picture.light)
}

fn apart(a: [u8; 4], b: [u8; 4]) -> u8 {
    (0..4).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0)
}

#[test]
fn kernels_make_the_masks_of_the_reference() {
    for glass in [false, true] {
        let cases = [
            (false, 1, false),
            (false, 5, false),
            (false, 7, true),
            (true, 1, false),
            (true, 7, false),
        ];
        for (half, taps, anisotropic) in cases {
            let mut scene = room(glass);
            scene.mask = Some(MaskSettings { half, taps, anisotropic, ..OFF });
            let (ours, _) = masks_of(&scene);
            let views = shadow_views(&scene);
            let (maps, _) = reference::render_maps(&scene, &views);
            let cpu = reference::picture_masks(&scene, &views, &maps).unwrap().bytes();
            assert_eq!(ours.len(), cpu.len());
            assert_eq!(ours.len() / (96 * 64), if glass { 2 } else { 1 });
            // Channels without a light are shown black.
            let used = if glass { [1, 1, 1, 0] } else { [1, 1, 0, 0] };
            let shown = |texel: [u8; 4]| std::array::from_fn(|i| texel[i] * used[i]);
            let cpu: Vec<[u8; 4]> = cpu.into_iter().map(shown).collect();
            let dark = cpu.iter().filter(|texel| texel[0].min(texel[1]) < 100).count();
            assert!(dark > 30, "{dark}: nothing is in the shadow");
            let far = ours.iter().zip(&cpu).filter(|&(&a, &b)| apart(a, b) > 3).count();
            let few = ours.len() / 300;
            assert!(far <= few, "glass {glass} half {half} taps {taps}: {far}");
        }
    }
}

/// Unfiltered masks change the picture only by the rounding to bytes; coloured masks survive blur and half
/// size away from edges.
#[test]
fn pictures_through_masks_are_those_without() {
    let scene = room(true);
    let (_, plain) = masks_of(&scene);
    let brightest = plain.iter().flatten().fold(0.0_f32, |most, &v| most.max(v));
    for (half, taps, most) in [(false, 1, 0.6), (false, 7, 2.0), (true, 7, 2.0)] {
        let mut own = scene.clone();
        own.mask = Some(MaskSettings { half, taps, ..OFF });
        let (masks, light) = masks_of(&own);
        // Masks of the sun and of the lamp.
        let at = |x: usize, y: usize| [masks[y * 96 + x], masks[(64 + y) * 96 + x]];
        let steps = |a: [[u8; 4]; 2], b: [[u8; 4]; 2]| apart(a[0], b[0]).max(apart(a[1], b[1]));
        let mut errors = Vec::new();
        for y in 8..56 {
            for x in 8..88 {
                // Masks are even around a pixel away from edges.
                let is_even = (0..17 * 17).all(|i| {
                    let (x, y) = (x + i % 17 - 8, y + i / 17 - 8);
                    let left = steps(at(x, y), at(x.max(1) - 1, y));
                    left.max(steps(at(x, y), at(x, y.max(1) - 1))) < 12
                });
                let i = y * 96 + x;
                let error = (0..3).map(|c| (light[i][c] - plain[i][c]).abs()).sum::<f32>() / 3.0;
                if is_even || taps == 1 {
                    errors.push(error / brightest * 255.0);
                }
            }
        }
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        assert!(errors.len() > 200, "{}", errors.len());
        assert!(mean < most, "half {half} taps {taps}: {mean} of 255");
    }
    // The check can fail: without the pane the picture differs.
    let (_, clear) = masks_of(&room(false));
    let differ = clear.iter().zip(&plain).filter(|(a, b)| (a[2] - b[2]).abs() > 0.05).count();
    assert!(differ > 100, "{differ}");
}

/// Lights past the limit, and panes in front of opaque surfaces, read the maps instead of masks.
#[test]
fn what_has_no_mask_is_lit_through_none() {
    let mut scene = room(true);
    let corner = Vec3::new(-1.2, 0.1, 1.5);
    scene.triangles.extend(sheet(corner, Vec3::X * 0.9, Vec3::Y, 1));
    let (_, plain) = masks_of(&scene);
    let most = plain.iter().flatten().fold(0.0_f32, |most, &v| most.max(v));
    let differ = |light: &[[f32; 3]]| {
        let far =
            |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|c| (a[c] - b[c]).abs() > 0.02 * most);
        plain.iter().zip(light).filter(|&pair| far(pair)).count()
    };
    scene.mask = Some(MaskSettings { limit: 1, ..OFF });
    let (masks, light) = masks_of(&scene);
    assert_eq!(masks.len(), 96 * 64, "the lamp has no mask");
    // A byte's rounding shows at the shadows' edges next to a lamp.
    assert!(differ(&light) <= 30, "{}", differ(&light));
    // The check can fail: without the lamp more than the shadow of the sun differs.
    scene.lights.truncate(1);
    assert!(differ(&masks_of(&scene).1) > 300);
}

/// A ball of `around` x `around / 2` facets, with the normals of a sphere.
fn ball(center: Vec3, radius: f32, around: u32) -> Vec<Triangle> {
    let point = |i: u32, j: u32| {
        let turn = std::f32::consts::TAU / around as f32;
        let (across, down) = (i as f32 * turn, j as f32 * turn);
        Vec3::new(across.cos() * down.sin(), down.cos(), across.sin() * down.sin())
    };
    let half = |normals: [Vec3; 3]| Triangle {
        normals,
        ..triangle(normals.map(|normal| center + radius * normal), 0)
    };
    let cells = (0..around).flat_map(|i| (0..around / 2).map(move |j| (i, j)));
    let cell = |(i, j): (u32, u32)| {
        let corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| point(i, j));
        [[corners[0], corners[2], corners[1]], [corners[0], corners[3], corners[2]]].map(half)
    };
    let has_area = |own: &Triangle| {
        let [a, b, c] = own.positions;
        (b - a).cross(c - a).length() > 1e-6
    };
    cells.flat_map(cell).filter(has_area).collect()
}

/// Masks are looked up at the shading's position: on the round surface that a coarse mesh approximates.
#[test]
fn terminators_are_those_of_the_shading() {
    let mut scene = room(false);
    let center = Vec3::new(0.2, 0.7, 1.0);
    scene.triangles.extend(ball(center, 0.7, 10));
    let direction = Vec3::new(-0.9, -0.3, -0.3).normalize();
    // So narrow that its texels are far smaller than a facet's distance from the round surface.
    let kind = LightKind::Spot { position: center - 6.0 * direction, direction, angle: 0.3 };
    scene.lights = vec![Light { size: Some(1024), intensity: 60.0, ..light(kind) }];
    let (_, plain) = masks_of(&scene);
    let most = plain.iter().flatten().fold(0.0_f32, |most, &v| most.max(v));
    scene.mask = Some(OFF);
    let (_, light) = masks_of(&scene);
    let error = |i: usize| (light[i][0] - plain[i][0]).abs() / most;
    let far: Vec<_> = (0..light.len()).filter(|&i| error(i) > 0.004).collect();
    assert!(far.is_empty(), "{} of {far:?}", far.len());
    // The ball is visible and has a dark side.
    let dark = plain.iter().filter(|own| own[0] < 0.1 * most).count();
    assert!((500..6000).contains(&dark), "{dark}");
}
