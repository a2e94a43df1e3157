//! Functions of the renderer for hosts, apart from pictures.
use crate::common::{
    TIERS, gpu, own_gpu,
    scenes::{empty, light, material, random_discs, triangle},
};
use gobo::{
    KernelJob, LightKind, Receiver, Scene, Transfer,
    glam::{UVec2, Vec3},
};
use gobo_picture::{RenderOptions, Renderer, ViewMaps};

/// Discs above a floor, under a sun and a lamp.
fn scene() -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter), material(Transfer::Opaque)]);
    scene.camera.size = UVec2::new(48, 40);
    scene.particles = random_discs(300, 4);
    let [a, b, c] = [[-9.0, -2.0, 9.0], [9.0, -2.0, 9.0], [0.0, -2.0, -9.0]].map(Vec3::from);
    scene.triangles = vec![triangle([a, b, c], 1)];
    let direction = Vec3::new(0.3, -1.0, 0.1);
    let position = Vec3::new(0.0, 4.0, 1.0);
    scene.lights = vec![
        light(LightKind::Directional { direction }),
        light(LightKind::Spot { position, direction: -position, angle: 1.0 }),
    ];
    scene
}

#[test]
fn curves_take_memory_only_where_something_filters_or_reads_them() {
    let mut renderer = Renderer::on(own_gpu(TIERS[0])).unwrap();
    let mut bytes = |scene: &Scene, maps: bool| {
        let options = RenderOptions { maps, ..RenderOptions::default() };
        let memory = renderer.render(scene, &options).unwrap().memory;
        memory.iter().filter(|(name, _)| *name == "curves").map(|(_, bytes)| bytes).sum::<u64>()
    };
    let mut scene = scene();
    scene.shadow.receiver = Receiver::Curve;
    // Two maps of 64 x 64 texels, of eight nodes of 8 bytes.
    assert!(bytes(&scene, false) >= 2 * 64 * 64 * 64);
    scene.materials[0] = material(Transfer::Opaque);
    // One texel, to be bound.
    assert_eq!(bytes(&scene, false), 16);
    assert!(bytes(&scene, true) >= 2 * 64 * 64 * 64);
}

#[test]
fn kernels_that_threads_have_made_no_picture_makes() {
    for tier in TIERS {
        let gpu = own_gpu(tier);
        let count = || gpu.device.get_internal_counters().hal.compute_pipelines.read();
        let before = count();
        let made = || (count() - before) as usize;
        let mut renderer = Renderer::on(gpu.clone()).unwrap();
        let scene = scene();
        let jobs = renderer.pending(&scene).unwrap();
        assert_eq!(made(), 0, "{tier:?}");
        let names: Vec<_> = jobs.iter().map(KernelJob::name).collect();
        assert!(names.iter().any(|name| name.starts_with("shade")), "{names:?}");
        jobs.iter().for_each(|job| job.run().unwrap());
        assert!(renderer.pending(&scene).unwrap().is_empty(), "{tier:?}");

        let options = RenderOptions { keep: true, ..RenderOptions::default() };
        let warm = renderer.render(&scene, &options).unwrap();
        assert_eq!(made(), jobs.len(), "{tier:?}");
        let cold =
            Renderer::on(crate::common::gpu(tier)).unwrap().render(&scene, &options).unwrap();
        assert_eq!(warm.picture.rgb, cold.picture.rgb, "{tier:?}");
    }
}

#[test]
fn maps_of_one_light_are_those_of_all_that_are_its_own() {
    let scene = scene();
    for mut renderer in [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()] {
        let mut maps = |of| {
            let options = RenderOptions { maps: true, maps_of: of, ..RenderOptions::default() };
            renderer.render(&scene, &options).unwrap().maps
        };
        let texels = |maps: &ViewMaps| (maps.view.light, maps.filter.clone(), maps.opaque.clone());
        let all: Vec<_> = maps(None).iter().map(texels).collect();
        assert_eq!(all.len(), 2);
        for (light, expected) in all.iter().enumerate() {
            let own: Vec<_> = maps(Some(light)).iter().map(texels).collect();
            assert!(own == [expected.clone()] && own[0].0 == Some(light), "{light}");
        }
        assert!(maps(Some(2)).is_empty());
    }
}
