//! Work that the samples of a picture, still frames and sequences do not repeat, by counts.
use crate::common::{
    TIERS, gpu,
    scenes::{empty, light, material, random_discs, triangle},
};
use gobo::{
    LightKind, Receiver, Scene, ShadowSettings, Shadows, Transfer,
    glam::{UVec2, Vec3},
    gpu::Timeline,
    model::{Source, View},
};
use gobo_picture::{
    RenderOptions, Renderer,
    picture::{PictureCapacity, PictureRequest, PreparedPicture},
};

/// Discs above a floor under a sun with a size.
fn scene(samples: u32) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter), material(Transfer::Opaque)]);
    scene.camera.size = UVec2::new(48, 40);
    scene.samples = samples;
    scene.particles = random_discs(60, 4);
    let [a, b, c] = [[-9.0, -2.0, 9.0], [9.0, -2.0, 9.0], [0.0, -2.0, -9.0]].map(Vec3::from);
    scene.triangles = vec![triangle([a, b, c], 1)];
    let direction = Vec3::new(0.3, -1.0, 0.1);
    scene.lights = vec![light(LightKind::Directional { direction })];
    scene.lights[0].source = Some(Source::Sun { angle: 0.05 });
    scene.shadow.receiver = Receiver::Curve;
    scene
}

#[test]
fn maps_and_their_levels_are_made_once_for_all_samples_and_still_frames() {
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut fresh = Renderer::on(gpu(TIERS[0])).unwrap();
    let options = RenderOptions { keep: true, ..RenderOptions::default() };
    let mut counts = |scene: &Scene, what: &str| {
        let frame = renderer.render(scene, &options).unwrap();
        let alone = fresh.render(scene, &RenderOptions::default()).unwrap();
        assert!(frame.picture.rgb == alone.picture.rgb, "{what}");
        assert_eq!(alone.counters.levels_made, 1, "{what}");
        let counters = &frame.counters;
        assert_eq!(counters.views_rendered + counters.views_kept, 1, "{what}");
        [
            counters.views_rendered,
            counters.views_searched,
            counters.levels_made,
            counters.pictures_drawn,
        ]
    };
    let mut scene = scene(3);
    assert_eq!(counts(&scene, "first"), [1, 1, 1, 3]);
    assert_eq!(counts(&scene, "still"), [0, 0, 0, 3]);
    scene.lights[0].intensity *= 0.5;
    assert_eq!(counts(&scene, "the map stays"), [0, 0, 0, 3]);
    scene.particles[0].center.x += 0.5;
    assert_eq!(counts(&scene, "a caster moves"), [1, 1, 1, 3]);
    scene.lights[0].kind = LightKind::Directional { direction: Vec3::new(0.1, -1.0, 0.3) };
    assert_eq!(counts(&scene, "the light moves"), [1, 1, 1, 3]);
    assert_eq!(counts(&scene, "and stays"), [0, 0, 0, 3]);
}

/// Pairs of a picture whose camera comes closer from frame to frame.
#[test]
fn a_picture_has_room_for_the_next_ones() {
    let gpu = gpu(TIERS[0]);
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.camera.size = UVec2::splat(480);
    scene.particles = random_discs(9000, 7);
    scene.particles.iter_mut().for_each(|particle| particle.radius = 1.2);
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let mut shadows = Shadows::on_tier(&gpu.device, &gpu.queue, &gpu.adapter, gpu.tier).unwrap();
    let prepared = shadows.prepare(&scene.casters(), &[], &settings).unwrap();
    let (mut capacity, mut grown, mut needs) = (PictureCapacity::default(), 0, Vec::new());
    for _ in 0..6 {
        scene.camera.eye *= 0.995;
        let camera = &View::from_camera(&scene.camera, &scene.bounds());
        loop {
            let request = PictureRequest { scene: &scene, camera, prepared: &prepared, capacity };
            let picture =
                PreparedPicture::new(&shadows, &request, &mut Default::default()).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            picture.record_counts(&mut encoder, &mut Timeline::untimed());
            gpu.queue.submit([encoder.finish()]);
            let needed = picture.read_counters(&gpu).unwrap()[1].pairs_needed;
            let Some(more) = picture.needs(&gpu, u32::MAX).unwrap() else {
                needs.push(needed);
                break;
            };
            (capacity, grown) = (more, grown + 1);
        }
    }
    assert!(needs.is_sorted_by(|a, b| a < b) && needs[0] > 1 << 20, "{needs:?}");
    assert_eq!(grown, 1, "{needs:?}");
}

/// A frame that does not fit is counted before it is drawn, and drawn once; the next frames have room.
#[test]
fn pictures_whose_capacities_grow_are_drawn_once() {
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.camera.size = UVec2::splat(480);
    scene.particles = random_discs(9000, 7);
    scene.particles.iter_mut().for_each(|particle| particle.radius = 1.2);
    scene.samples = 1;
    let options = RenderOptions { keep: true, ..RenderOptions::default() };
    let mut grown = Vec::new();
    for _ in 0..2 {
        let counters = renderer.render(&scene, &options).unwrap().counters;
        assert_eq!(counters.pictures_drawn, 1, "{counters:?}");
        grown.push(counters.capacities_grown);
        scene.camera.eye *= 0.995;
    }
    assert!(grown[0] > 0 && grown[1] == 0, "{grown:?}");
}
