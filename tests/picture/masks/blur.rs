//! The blur of masks, against its formula in 64 bits, and its limits.
use super::{OFF, apart, masks_of, room, sheet};
use crate::common::scenes::light;
use gobo::{
    Light, LightKind, View,
    glam::{DVec2, DVec3, Vec3},
    model::MaskSettings,
};
use gobo_scene::Scene;

/// Surface at a pixel of the room, by hand: its position in view space, and its normal.
fn seen(scene: &Scene, x: usize, y: usize) -> (DVec3, DVec3) {
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    let half = camera.size.as_dvec2() * 0.5;
    let slope = (DVec2::new(x as f64, y as f64) + 0.5 - half) / f64::from(camera.scale);
    let world = camera.view_from_world.as_dmat4().inverse();
    let (eye, way) =
        (world.w_axis.truncate(), world.transform_vector3(DVec3::new(slope.x, -slope.y, -1.0)));
    let (ground, wall) = (-eye.y / way.y, (-2.0 - eye.z) / way.z);
    let to_view = camera.view_from_world.as_dmat4();
    if ground > 0.0 && ground < wall {
        (to_view.transform_point3(eye + way * ground), to_view.transform_vector3(DVec3::Y))
    } else {
        (to_view.transform_point3(eye + way * wall), to_view.transform_vector3(DVec3::Z))
    }
}

/// Length between two points a thousandth of a pixel apart on a surface parallel to the screen, as a share of
/// that on the room's surface; at most 1.
fn upright_share(scene: &Scene, x: i32, y: i32, axis: (i32, i32)) -> f64 {
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    let (own, normal) = seen(scene, x as usize, y as usize);
    let step = 1e-3 / f64::from(camera.scale);
    // The ray of a point one step aside meets the tangent plane.
    let way = own / -own.z + DVec3::new(f64::from(axis.0), -f64::from(axis.1), 0.0) * step;
    let aside = way * (normal.dot(own) / normal.dot(way));
    (step * -own.z / aside.distance(own)).min(1.0)
}

/// One axis of the blur in 64 bits, by the formula in docs/soft.md.
fn blurred(
    scene: &Scene,
    values: &[[f64; 4]],
    settings: &MaskSettings,
    axis: (i32, i32),
) -> Vec<[f64; 4]> {
    let side = (settings.taps / 2) as i32;
    let pixel = |i: usize| {
        let (x, y) = ((i % 96) as i32, (i / 96) as i32);
        let (own, normal) = seen(scene, x as usize, y as usize);
        let narrow = f64::from(settings.depth_scale) / -own.z;
        let narrow = if settings.depth_scale > 0.0 { narrow.min(1.0) } else { 1.0 };
        let upright = if settings.anisotropic { upright_share(scene, x, y, axis) } else { 1.0 };
        let width = f64::from(side) / 2.0 * narrow * upright;
        let (mut sum, mut weights) = ([0.0; 4], 0.0);
        for step in -side..=side {
            let (x, y) = (x + axis.0 * step, y + axis.1 * step);
            if !(0..96).contains(&x) || !(0..64).contains(&y) {
                continue;
            }
            let (other, facing) = seen(scene, x as usize, y as usize);
            let off = normal.dot(other - own).abs() * f64::from(settings.sensitivity) / -own.z;
            let near = (1.0 - off).max(0.0) * normal.dot(facing).max(0.0).powi(8);
            let weight = (-0.5 * (f64::from(step) / width).powi(2)).exp() * near;
            let value = values[(y * 96 + x) as usize];
            (0..4).for_each(|c| sum[c] += weight * value[c]);
            weights += weight;
        }
        sum.map(|v| v / weights)
    };
    (0..values.len()).map(pixel).collect()
}

#[test]
fn blurs_are_those_of_64_bits() {
    let mut scene = room(false);
    scene.mask = Some(OFF);
    let (sharp, _) = masks_of(&scene);
    for (taps, depth_scale, anisotropic) in
        [(3, 0.0, false), (11, 0.0, false), (15, 4.0, false), (15, 0.0, true)]
    {
        let settings = MaskSettings { taps, depth_scale, anisotropic, ..OFF };
        scene.mask = Some(settings);
        let (soft, _) = masks_of(&scene);
        let bytes = |mask: &[[u8; 4]]| {
            mask.iter().map(|texel| texel.map(|v| f64::from(v) / 255.0)).collect::<Vec<_>>()
        };
        let rows = blurred(&scene, &bytes(&sharp), &settings, (1, 0));
        let truth = blurred(&scene, &rows, &settings, (0, 1));
        let error = |i: usize| {
            let own = soft[i].map(|v| f64::from(v) / 255.0);
            (0..4).map(|c| (own[c] - truth[i][c]).abs()).fold(0.0, f64::max)
        };
        // Two roundings to bytes; on the line between ground and wall a pixel may be on either.
        let far = (0..soft.len()).filter(|&i| error(i) > 1.2 / 255.0).count();
        assert!(far <= 96, "{taps} taps: {far}");
        let moved = (0..soft.len()).filter(|&i| apart(soft[i], sharp[i]) > 20).count();
        assert!(moved > 100, "{taps} taps: {moved}: nothing was blurred");
        // The check can fail: a wrong kernel differs.
        let wrong = match anisotropic {
            true => MaskSettings { anisotropic: false, ..settings },
            false => MaskSettings { taps: if taps == 3 { 7 } else { taps - 4 }, ..settings },
        };
        let wrong_rows = blurred(&scene, &bytes(&sharp), &wrong, (1, 0));
        let wrong = blurred(&scene, &wrong_rows, &wrong, (0, 1));
        let differs = |i: &usize| (wrong[*i][0] - truth[*i][0]).abs() > 1.2 / 255.0;
        assert!((0..soft.len()).filter(differs).count() > 96, "{taps} taps");
    }
}

/// A lit pole, a pixel or two wide, in front of a wall in shadow: neither takes the other's light.
#[test]
fn a_thin_pole_does_not_glow() {
    let mut scene = room(false);
    scene.camera.target = Vec3::new(0.0, 1.5, 0.0);
    scene.triangles.truncate(4);
    let sun = LightKind::Directional { direction: Vec3::new(0.0, -1.0, -0.2) };
    scene.lights = vec![Light { size: Some(1024), ..light(sun) }];
    // Above the wall, not above the pole.
    scene.triangles.extend(sheet(Vec3::new(-9.0, 8.0, -2.5), Vec3::X * 18.0, Vec3::Z * 3.0, 0));
    let width = 2.0 * 0.35_f32.tan() * 3.0 / 64.0 * 1.3;
    scene.triangles.extend(sheet(Vec3::new(0.1, 0.0, 2.0), Vec3::X * width, Vec3::Y * 4.0, 0));
    scene.mask = Some(OFF);
    let (truth, _) = masks_of(&scene);
    let row = 20;
    let line =
        |mask: &[[u8; 4]]| mask[row * 96..row * 96 + 96].iter().map(|t| t[0]).collect::<Vec<_>>();
    let pole: Vec<usize> = (0..96).filter(|&x| line(&truth)[x] > 200).collect();
    assert!((1..=3).contains(&pole.len()), "{:?}", line(&truth));
    for (half, taps) in [(false, 15), (true, 1), (true, 11)] {
        let shown = |sensitivity| {
            let mut scene = scene.clone();
            scene.mask = Some(MaskSettings { half, taps, sensitivity, ..OFF });
            line(&masks_of(&scene).0)
        };
        let own = shown(100.0);
        for x in 0..96 {
            let is_pole = pole.contains(&x);
            let fits = if is_pole { own[x] > 230 } else { own[x] < 12 };
            assert!(fits, "half {half} taps {taps} {x}: {own:?}");
        }
        // Without the depth weight they do.
        if taps > 1 {
            let blind = shown(0.0);
            assert!((0..96).any(|x| !pole.contains(&x) && blind[x] > 12), "{blind:?}");
        }
    }
}
