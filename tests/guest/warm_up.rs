//! Kernels that the host's threads compile before a frame needs them.
use super::{materials, particles, shadows, submit, views};
use crate::common::{TIERS, own_gpu, scenes::nearest_depth};
use gobo::{
    Bounds, Casters, HostInputs, KernelJob, Light, ShadowSettings, glam::Vec3, gpu::Gpu,
    light_views, model::Source,
};

fn pipelines(gpu: &Gpu) -> isize {
    gpu.device.get_internal_counters().hal.compute_pipelines.read()
}

#[test]
fn what_threads_have_made_no_frame_makes() {
    for tier in TIERS {
        let gpu = own_gpu(tier);
        let (mut particles, materials) = (particles(3000, 5), materials());
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let (views, settings) = (views(), nearest_depth());
        let mut warm = shadows(&gpu);
        assert!(warm.is_ready());
        let before = pipelines(&gpu);
        let made = || (pipelines(&gpu) - before) as usize;

        let jobs = warm.pending(&casters, &views, &settings, &HostInputs::new()).unwrap();
        let names: Vec<_> = jobs.iter().map(KernelJob::name).collect();
        assert!(names.iter().any(|name| name.starts_with("sort")), "{names:?}");
        assert_eq!((made(), warm.is_ready()), (0, false), "{tier:?}");
        // A second call returns the same jobs.
        let again = warm.pending(&casters, &views, &settings, &HostInputs::new()).unwrap();
        assert_eq!(again.iter().map(KernelJob::name).collect::<Vec<_>>(), names);

        let (last, others) = jobs.split_last().unwrap();
        std::thread::scope(|scope| {
            let halves = others.split_at(others.len() / 2);
            for half in [halves.0, halves.1, others] {
                scope.spawn(move || half.iter().for_each(|job| job.run().unwrap()));
            }
        });
        assert_eq!((made(), warm.is_ready()), (others.len(), false));
        last.run().unwrap();
        assert!(warm.is_ready());

        let prepared = warm.prepare(&casters, &views, &settings).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).unwrap();
        assert_eq!(made(), jobs.len(), "{tier:?}");
        let mut cold = shadows(&gpu);
        let expected = submit(&gpu, &cold.prepare(&casters, &views, &settings).unwrap());
        assert_eq!(submit(&gpu, &prepared), expected, "{tier:?}");
        // Nor is a later one, in which something has changed.
        particles[0].radius *= 2.0;
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        warm.prepare(&casters, &views, &settings).unwrap();
        assert_eq!(made(), jobs.len(), "{tier:?}");

        // Another world on the device has the same kernels, and its own casters and maps.
        let mut another = warm.another();
        assert!(
            another.pending(&casters, &views, &settings, &HostInputs::new()).unwrap().is_empty()
        );
        let of_another = submit(&gpu, &another.prepare(&casters, &views, &settings).unwrap());
        assert_eq!(made(), jobs.len(), "{tier:?}");
        assert!(of_another != expected, "a caster is larger");
        assert_eq!(submit(&gpu, &warm.prepare(&casters, &views, &settings).unwrap()), of_another);

        // Other settings have kernels of their own.
        let curves = ShadowSettings::default();
        let jobs = warm.pending(&casters, &views, &curves, &HostInputs::new()).unwrap();
        assert!(!jobs.is_empty() && jobs.iter().all(|job| !names.contains(&job.name())));
    }
}

/// Area lights, too, if the host announces that it binds them.
#[test]
fn area_lights_compile_nothing_when_they_are_bound() {
    let gpu = own_gpu(TIERS[0]);
    let (particles, materials) = (particles(300, 5), materials());
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let bounds = Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let source = Some(Source::Sphere { radius: 0.2 });
    let lights = [Light { source, ..Light::spot(Vec3::Y * 4.0, Vec3::NEG_Y, 0.9) }];
    let views = light_views(0, &lights[0], 64, None, &bounds).unwrap();
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let mut shadows = shadows(&gpu);
    let inputs = HostInputs::new().area_lights();
    for job in shadows.pending(&casters, &views, &settings, &inputs).unwrap() {
        job.run().unwrap();
    }
    let before = pipelines(&gpu);
    let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs).unwrap();
    let bound = prepared.bind_area_lights(&lights, &[0]).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    bound.record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    assert_eq!(pipelines(&gpu), before);
    gpu.check().unwrap();
}
