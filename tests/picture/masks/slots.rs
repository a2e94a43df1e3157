//! Slots of masks: lights that share one, and lights that keep their own.
use super::{OFF, masks_of, room};
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, light},
};
use gobo::{
    Light, LightKind, View,
    glam::Vec3,
    model::MaskSettings,
    records::{COLORED_BIT, FormerSlots, MaskSlots, SLOTS},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

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
