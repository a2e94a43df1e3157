//! Allocations of a frame: none. `record` has neither device nor queue; the counters of wgpu confirm that
//! nothing is created behind the scenes.
use crate::common::{
    counted_gpu, own_gpu,
    scenes::{Chance, empty, light, material, nearest_depth, random_discs, triangle},
    tiers,
};
use gobo::{
    Prepared, Receiver, ShadowSettings, Shadows,
    glam::{Vec3, Vec4},
    gpu::{Gpu, Tier, Timeline},
    model::{Environment, LightKind, Material, Pattern, Sky, Transfer, View},
    shadows::{CasterSet, Config},
    view::shadow_views,
    wgpu,
};
use gobo_picture::picture::{Kept, PictureCapacity, PictureRequest, PreparedPicture};
use gobo_scene::Scene;
use std::sync::{Arc, MutexGuard};

/// Live resources of the device. Buffers include those that `Queue::write_*` stages until the next
/// submission. (Command encoders are the host's; wgpu 30 counts views and bytes of textures, but not all
/// textures.)
fn living(device: &wgpu::Device) -> [(&'static str, isize); 12] {
    let hal = device.get_internal_counters().hal;
    [
        ("buffers", hal.buffers.read()),
        ("texture views", hal.texture_views.read()),
        ("bind groups", hal.bind_groups.read()),
        ("bind group layouts", hal.bind_group_layouts.read()),
        ("pipeline layouts", hal.pipeline_layouts.read()),
        ("compute pipelines", hal.compute_pipelines.read()),
        ("render pipelines", hal.render_pipelines.read()),
        ("shader modules", hal.shader_modules.read()),
        ("samplers", hal.samplers.read()),
        ("query sets", hal.query_sets.read()),
        ("bytes of buffers", hal.buffer_memory.read()),
        ("bytes of textures", hal.texture_memory.read()),
    ]
}

/// Resources that `work` left on the device, by name.
fn made(device: &wgpu::Device, work: impl FnOnce()) -> Vec<(&'static str, isize)> {
    let before = living(device);
    work();
    let after = living(device).into_iter().zip(before);
    after.map(|((name, a), (_, b))| (name, a - b)).filter(|&(_, more)| more != 0).collect()
}

fn submit_all(gpu: &Gpu) {
    gpu.queue.submit([]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    gpu.check().unwrap();
}

/// Discs, triangles and opaque casters; `pane` is the material of the filtering triangles.
fn mixture(pane: Material) -> Scene {
    let opaque = material(Transfer::Opaque);
    let mut scene = empty(vec![material(Transfer::Filter), pane, opaque]);
    let position = Vec3::new(3.0, 4.0, 2.5);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::NEG_Y }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }),
    ];
    scene.particles = random_discs(3000, 3);
    let mut chance = Chance::new(4);
    for i in 0..24 {
        let corners = [0; 3].map(|_| chance.vec3(-2.0, 2.0));
        scene.triangles.push(triangle(corners, 1 + u32::from(i % 4 == 0)));
    }
    scene
}

fn casters(gpu: &Gpu, scene: &Scene) -> CasterSet {
    let form = Config::new(gpu.tier, &gpu.adapter).tuning.record_form;
    CasterSet::new(&gpu.device, &gpu.queue, &scene.casters(), form).unwrap()
}

struct Case {
    name: &'static str,
    scene: Scene,
    /// Changes the configuration of the frame.
    set: fn(&mut ShadowSettings, &mut Config),
}

/// One case for each path through `record`.
fn cases() -> Vec<Case> {
    let pane = |transfer| Material {
        tint: Vec4::new(0.2, 0.7, 0.9, 0.8),
        pattern: Pattern::Blue,
        ..material(transfer)
    };
    let case = |name, transfer, set: fn(&mut ShadowSettings, &mut Config)| {
        let scene = mixture(pane(transfer));
        Case { name, scene, set }
    };
    use Transfer::{Dither, Filter, Over};
    vec![
        case("filter", Filter, |_, _| ()),
        case("tiny ones through tiles", Filter, |_, config| config.toggles.scatter_tiny = false),
        case("too small a budget", Filter, |settings, _| settings.pair_budget = 500),
        case("curves", Filter, |settings, _| settings.receiver = Receiver::Curve),
        case("over", Over, |_, _| ()),
        case("softened dither", Dither, |settings, _| settings.soften = true),
        case("coloured dither", Dither, |settings, _| settings.colored = true),
    ]
}

/// The guard comes first, so that it is dropped last.
fn open(tier: Tier) -> (MutexGuard<'static, ()>, Gpu, Shadows) {
    let (gpu, guard) = counted_gpu(tier);
    // Submissions of earlier tests keep dropped resources alive.
    submit_all(&gpu);
    let mut config = Config::new(gpu.tier, &gpu.adapter);
    config.toggles.scatter_tiny = true; // as on a GPU
    let (device, queue, kernels) = (&gpu.device, &gpu.queue, gpu.kernels.clone());
    let shadows = Shadows::sharing(device, queue, config, kernels).unwrap();
    (guard, gpu, shadows)
}

fn prepare(gpu: &Gpu, shadows: &mut Shadows, scene: &Scene, settings: &ShadowSettings) -> Prepared {
    let prepared = shadows.prepare(&scene.casters(), &shadow_views(scene), settings).unwrap();
    submit_all(gpu);
    prepared
}

#[test]
fn a_frame_makes_nothing_on_the_device() {
    for tier in tiers(Tier::Native) {
        for Case { name, scene, set } in cases() {
            let (_alone, gpu, mut shadows) = open(tier);
            let mut settings = nearest_depth();
            shadows.configure(|config| set(&mut settings, config));
            let prepared = prepare(&gpu, &mut shadows, &scene, &settings);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut commands = None;
            let made = made(&gpu.device, || {
                for _ in 0..3 {
                    prepared.record(&mut encoder).unwrap();
                }
                commands = Some(encoder.finish());
            });
            assert_eq!(made, [], "{tier:?}, {name}");
            gpu.check().unwrap();
        }
    }
}

#[test]
fn the_commands_of_a_frame_are_readable() {
    let (_alone, gpu, mut shadows) = open(Tier::Core);
    let prepared = prepare(&gpu, &mut shadows, &cases()[0].scene, &ShadowSettings::default());
    let text = format!("{:?}", prepared.commands());
    let lines: Vec<_> = text.lines().collect();
    let labels: Vec<_> = lines.iter().filter(|line| line.starts_with("gobo ")).collect();
    assert!(labels.contains(&&"gobo project") && labels.contains(&&"gobo resolve"), "{text}");
    let count = |start| lines.iter().filter(|line| line.starts_with(start)).count();
    assert_eq!(
        count("  bin_scan [1, 1, 1]: bin_params, "),
        count("gobo project"),
        "of each list: {text}"
    );
}

/// No allocation even inside wgpu at a submission.
#[test]
fn frames_after_the_first_leave_the_device_as_it_is() {
    let (_alone, gpu, mut shadows) = open(Tier::Native);
    let scene = &cases()[0].scene;
    let prepared = &prepare(&gpu, &mut shadows, scene, &ShadowSettings::default());
    let Gpu { device, queue, .. } = &gpu;
    let camera = &View::from_camera(&scene.camera, &scene.bounds());
    let request = PictureRequest { scene, camera, prepared, capacity: PictureCapacity::default() };
    let picture = PreparedPicture::new(&shadows, &request, &mut Default::default()).unwrap();
    submit_all(&gpu);
    let mut timeline = Timeline::untimed();
    let mut frame = || {
        let mut encoder = device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).unwrap();
        picture.record(&mut encoder, &mut timeline);
        queue.submit([encoder.finish()]);
        submit_all(&gpu);
    };
    frame();
    assert_eq!(made(device, || (0..10).for_each(|_| frame())), []);
}

/// Pictures at other sample positions, and of the next frames, reuse it.
#[test]
fn an_environment_that_stays_is_not_uploaded_again() {
    let (_alone, gpu, mut shadows) = open(Tier::Native);
    let mut scene = mixture(material(Transfer::Filter));
    let sky = || Some(Arc::new(Environment::of_sky(&Sky::default(), 1.0)));
    scene.environment = sky();
    let prepared = &prepare(&gpu, &mut shadows, &scene, &ShadowSettings::default());
    let (mut pictures, mut kept) = (Vec::new(), Kept::default());
    let mut bytes = |scene: &Scene| {
        let made = made(&gpu.device, || {
            let camera = &View::from_camera(&scene.camera, &scene.bounds());
            let capacity = PictureCapacity::default();
            let request = PictureRequest { scene, camera, prepared, capacity };
            let picture = PreparedPicture::new(&shadows, &request, &mut kept);
            pictures.push(picture.unwrap());
            submit_all(&gpu);
        });
        made.iter().find(|(name, _)| *name == "bytes of textures").map_or(0, |&(_, bytes)| bytes)
    };
    let [first, again, again_too] = [bytes(&scene), bytes(&scene), bytes(&scene)];
    scene.environment = sky();
    let other = bytes(&scene);
    let listed = pictures
        .iter()
        .map(|picture| picture.memory.0.iter().find(|(name, _)| *name == "environment").unwrap().1);
    let listed: Vec<u64> = listed.collect();
    assert!(listed[0] > 100_000 && listed.iter().all(|bytes| *bytes == listed[0]), "{listed:?}");
    // Drivers round sizes up.
    assert!(first - again >= listed[0] as isize, "{first} {again}");
    assert_eq!([again - again_too, other - first], [0, 0]);
}

#[test]
fn casters_that_stay_are_not_uploaded_again() {
    let (_alone, gpu, _) = open(Tier::Native);
    let mut scene = mixture(material(Transfer::Filter));
    let mut casters = casters(&gpu, &scene);
    submit_all(&gpu);
    let mut update = |scene: &Scene| {
        let staged = made(&gpu.device, || {
            assert!(casters.update(&gpu.queue, &scene.casters(), &[]));
        });
        submit_all(&gpu);
        staged
    };
    assert_eq!(update(&scene), []);
    // One buffer for each changed part, and nothing afterwards.
    let buffers = |staged: &[(&str, isize)]| {
        staged.iter().find(|(name, _)| *name == "buffers").map_or(0, |&(_, count)| count)
    };
    scene.particles[7].color.w *= 0.5;
    assert_eq!(buffers(&update(&scene)), 1);
    assert_eq!(update(&scene), []);
    scene.triangles[3].positions[1].y += 0.01;
    scene.materials[1].reflectivity = 0.1;
    assert!(buffers(&update(&scene)) >= 2);
    assert_eq!(update(&scene), []);
}

/// The counters used above do count.
#[test]
fn what_is_made_is_noticed() {
    let gpu = own_gpu(Tier::Native);
    let config = Config::new(gpu.tier, &gpu.adapter);
    let mut shadows = Shadows::with(&gpu.device, &gpu.queue, config).unwrap();
    let Gpu { device, queue, .. } = &gpu;
    // Few kernels, none of them made before.
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.particles = random_discs(20, 1);
    let scene = &scene;
    let has = |made: &[(&str, isize)], wanted: &str| {
        assert!(
            made.iter().any(|&(name, count)| name == wanted && count > 0),
            "{wanted}: {made:?}"
        );
    };
    let mut kept = None;
    let views = shadow_views(scene);
    let by_prepare = made(device, || {
        let settings = ShadowSettings::default();
        kept = Some(shadows.prepare(&scene.casters(), &views, &settings).unwrap());
    });
    for name in
        ["buffers", "texture views", "bind groups", "compute pipelines", "bytes of textures"]
    {
        has(&by_prepare, name);
    }
    submit_all(&gpu);
    let buffer = gpu.storage::<u32>("one", 1);
    has(&made(device, || queue.write_buffer(&buffer, 0, &[0; 4])), "buffers");
    let mut second = None;
    has(&made(device, || second = Some(gpu.storage::<u32>("two", 1))), "buffers");
}
