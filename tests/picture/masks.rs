//! Shadow masks: slots, look-up, blur and half size, against values by hand, 64 bits and the twin.
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, empty, light, material, triangle},
};
use gobo::{
    Camera, Light, LightKind, MaskSettings, Material, RenderOptions, Renderer, Transfer, Triangle,
    View,
    glam::{DVec2, DVec3, UVec2, Vec3, Vec4},
    picture::debug::DebugMode,
    records::{COLORED_BIT, FormerSlots, MaskSlots, SLOTS},
    reference,
    scene::Scene,
    view::shadow_views,
};

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

/// The masks, four bytes a pixel, layer by layer, and the light of the picture.
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
fn kernels_make_the_masks_of_the_twin() {
    for glass in [false, true] {
        let cases = [(false, 1, false), (false, 5, false), (false, 7, true), (true, 7, false)];
        for (half, taps, anisotropic) in cases {
            let mut scene = room(glass);
            scene.mask = Some(MaskSettings { half, taps, anisotropic, ..OFF });
            let (ours, _) = masks_of(&scene);
            let views = shadow_views(&scene);
            let (maps, _) = reference::render_maps(&scene, &views);
            let twin = reference::picture_masks(&scene, &views, &maps).unwrap().bytes();
            assert_eq!(ours.len(), twin.len());
            assert_eq!(ours.len() / (96 * 64), if glass { 2 } else { 1 });
            // Channels without a light are shown black.
            let used = if glass { [1, 1, 1, 0] } else { [1, 1, 0, 0] };
            let shown = |texel: [u8; 4]| std::array::from_fn(|i| texel[i] * used[i]);
            let twin: Vec<[u8; 4]> = twin.into_iter().map(shown).collect();
            let dark = twin.iter().filter(|texel| texel[0].min(texel[1]) < 100).count();
            assert!(dark > 30, "{dark}: nothing is in the shadow");
            let far = ours.iter().zip(&twin).filter(|&(&a, &b)| apart(a, b) > 3).count();
            // Rounding chooses the nearest of four pixels on a wall that faces the camera.
            let few = ours.len() / if half { 100 } else { 300 };
            assert!(far <= few, "glass {glass} half {half} taps {taps}: {far}");
        }
    }
}

/// Unfiltered masks change the picture by the rounding to bytes only; coloured masks survive blur and half
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

/// Masks look up the position of the shading: on the round surface that a coarse mesh approximates.
#[test]
fn terminators_are_those_of_the_shading() {
    let mut scene = room(false);
    let center = Vec3::new(0.2, 0.7, 1.0);
    scene.triangles.extend(ball(center, 0.7, 10));
    let direction = Vec3::new(-0.9, -0.3, -0.3).normalize();
    // So narrow that its texels are far smaller than the distance of a facet from the round surface.
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

/// A lit pole, a pixel or two wide, in front of a wall in shadow: neither gets the other's light.
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

fn lamps(count: usize, far: f32, chance: &mut Chance) -> Vec<Light> {
    let lamp = |i: usize| {
        let position = chance.vec3(-4.0, 4.0);
        let kind = match i % 2 {
            0 => LightKind::Point { position },
            _ => LightKind::Spot {
                position,
                direction: chance.vec3(-1.0, 1.0),
                angle: chance.within(0.3, 2.8),
            },
        };
        Light { name: format!("lamp{i}"), far: Some(far), size: Some(16), ..light(kind) }
    };
    (0..count).map(lamp).collect()
}

fn slots(scene: &Scene, limit: u32, former: &FormerSlots) -> MaskSlots {
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    MaskSlots::new(scene, &MaskSettings { limit, ..OFF }, &camera, former)
}

#[test]
fn nine_overlapping_lights_use_three_masks_and_lose_none() {
    let mut scene = room(false);
    scene.lights = lamps(9, 50.0, &mut Chance::new(3));
    let own = slots(&scene, 16, &FormerSlots::new());
    assert_eq!((own.count, own.unmasked), (3, 0));
    let mut all = own.of_lights.clone();
    all.sort_unstable();
    assert_eq!(all, (1..=9).collect::<Vec<_>>());
    // Lights past the limit are counted, and still light the picture.
    let few = slots(&scene, 2, &FormerSlots::new());
    assert_eq!((few.count, few.unmasked), (2, 1));
    scene.lights.iter_mut().for_each(|light| (light.size, light.intensity) = (Some(64), 4.0));
    let (_, plain) = masks_of(&scene);
    let most = plain.iter().flatten().fold(0.0_f32, |most, &v| most.max(v));
    let differ = |light: &[[f32; 3]]| {
        let far = |(a, b): (&[f32; 3], &[f32; 3])| (a[0] - b[0]).abs() > 0.02 * most;
        plain.iter().zip(light).filter(|&pair| far(pair)).count()
    };
    for limit in [2, 16] {
        scene.mask = Some(MaskSettings { limit, ..OFF });
        // A byte's rounding shows at the shadows' edges next to a lamp.
        let far = differ(&masks_of(&scene).1);
        assert!(far <= 60, "limit {limit}: {far}");
    }
    // The check can fail: without four lamps the picture differs.
    let mut fewer = scene.clone();
    fewer.lights.iter_mut().step_by(2).for_each(|light| light.color = Vec3::ZERO);
    let far = differ(&masks_of(&fewer).1);
    assert!(far > 120, "{far}");
    let options = RenderOptions::default();
    scene.mask = Some(MaskSettings { limit: 2, ..OFF });
    let counters = Renderer::on(gpu(TIERS[0])).unwrap().render(&scene, &options).unwrap().counters;
    assert_eq!((counters.masks, counters.unmasked_lights), (2, 1));
}

/// Lights of one slot never overlap, and slots are kept.
#[test]
fn lights_share_slots_where_they_do_not_overlap() {
    let mut chance = Chance::new(17);
    let mut scene = room(false);
    scene.lights = lamps(60, 1.2, &mut chance);
    let own = slots(&scene, 64, &FormerSlots::new());
    let masked = own.of_lights.iter().filter(|&&slot| slot != 0).count();
    assert!(own.unmasked == 0 && (own.count * SLOTS) < masked as u32 / 2, "{own:?}");
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    for _ in 0..20_000 {
        let place = chance.vec3(-5.0, 5.0);
        let reaches = |light: &Light| {
            let (LightKind::Point { position } | LightKind::Spot { position, .. }) = light.kind
            else {
                return false;
            };
            let away = place - position;
            let in_cone = match light.kind {
                LightKind::Spot { direction, angle, .. } => {
                    away.normalize().dot(direction.normalize()) > (angle * 0.5).cos()
                }
                _ => true,
            };
            away.length() < 1.2 && in_cone
        };
        let clip = camera.clip_from_world() * place.extend(1.0);
        let is_seen = clip.x.abs() < clip.w && clip.y.abs() < clip.w && clip.z > 0.0;
        let lit = scene.lights.iter().zip(&own.of_lights);
        let mut found: Vec<u32> =
            lit.filter(|(light, _)| is_seen && reaches(light)).map(|(_, &slot)| slot).collect();
        assert!(!found.contains(&0), "a light that is seen has a slot");
        let count = found.len();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), count, "two lights of one slot at {place}");
    }
    // Without the first light, the others keep their slots.
    let former = own.former(scene.lights.iter());
    let gone = scene.lights.remove(0);
    let next = slots(&scene, 64, &former);
    assert_eq!(next.of_lights, own.of_lights[1..]);
    // It returns at the end of the list, and gets its slot again.
    scene.lights.push(gone);
    let back = slots(&scene, 64, &former);
    assert_eq!(back.of_lights.last(), own.of_lights.first());
}

#[test]
fn lights_of_glass_have_a_mask_of_their_own() {
    let mut scene = room(true);
    let own = slots(&scene, 16, &FormerSlots::new());
    assert_eq!(own.of_lights, [1 | COLORED_BIT, (1 + SLOTS) | COLORED_BIT]);
    // A lamp that does not reach the glass needs one channel.
    scene.lights[1].far = Some(0.5);
    scene.lights[1].kind = LightKind::Point { position: Vec3::new(1.5, 0.3, 0.0) };
    let own = slots(&scene, 16, &FormerSlots::new());
    assert_eq!(own.of_lights, [1 | COLORED_BIT, 1 + SLOTS]);
}
