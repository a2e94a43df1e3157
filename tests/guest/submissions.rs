//! Frames that were recorded but did not run, or would run too late.
use super::{Bits, assert_equal, materials, particles, shadows, submit, views};
use crate::common::{counted_gpu, gpu, tiers};
use gobo::{
    Casters, Particle, Prepared, Receiver, ShadowSettings, Shadows, View,
    glam::Vec3,
    gpu::{Gpu, Tier},
    wgpu,
};
use std::{
    sync::MutexGuard,
    time::{Duration, Instant},
};

/// Time after which counters of a submitted frame count as lost.
const PATIENCE: Duration = Duration::from_secs(20);

fn settings() -> ShadowSettings {
    ShadowSettings { receiver: Receiver::Curve, ..ShadowSettings::default() }
}

fn prepare(shadows: &mut Shadows, particles: &[Particle], views: &[View]) -> Prepared {
    let materials = materials();
    let casters = Casters { particles, materials: &materials, ..Casters::default() };
    shadows.prepare(&casters, views, &settings()).unwrap()
}

fn recorded(gpu: &Gpu, prepared: &Prepared) -> wgpu::CommandEncoder {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    encoder
}

fn run(gpu: &Gpu, prepared: &Prepared) {
    gpu.queue.submit([recorded(gpu, prepared).finish()]);
}

/// Maps of a `Shadows` that has rendered nothing before.
fn truth(gpu: &Gpu, particles: &[Particle], views: &[View]) -> Bits {
    submit(gpu, &prepare(&mut shadows(gpu), particles, views))
}

fn moved(particles: &[Particle], by: Vec3) -> Vec<Particle> {
    particles.iter().map(|p| Particle { center: p.center + by, ..*p }).collect()
}

/// Numbers of rendered and of kept views.
fn counts(prepared: &Prepared) -> [u64; 2] {
    let counters = prepared.counters().unwrap();
    [counters.views_rendered, counters.views_kept]
}

/// A device that no other test polls: a poll can take a mark's answer and give it after this one's.
fn lone_gpu(tier: Tier) -> (Gpu, MutexGuard<'static, ()>) {
    counted_gpu(tier)
}

/// The device's error for a submission.
fn refusal(gpu: &Gpu, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> Option<String> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    gpu.queue.submit(commands);
    let mut context = std::task::Context::from_waker(std::task::Waker::noop());
    match std::pin::pin!(scope.pop()).as_mut().poll(&mut context) {
        std::task::Poll::Ready(error) => error.map(|error| error.to_string()),
        std::task::Poll::Pending => panic!("the device does not answer"),
    }
}

#[test]
fn a_frame_that_is_dropped_is_rendered_by_the_next() {
    for tier in tiers(Tier::Native) {
        let (gpu, _guard) = &lone_gpu(tier);
        let (mut shadows, views) = (shadows(gpu), views());
        let (first, second) = (particles(600, 5), moved(&particles(600, 5), Vec3::X * 0.4));
        run(gpu, &prepare(&mut shadows, &first, &views));
        for finishes in [false, true] {
            let encoder = recorded(gpu, &prepare(&mut shadows, &second, &views));
            if finishes {
                drop(encoder.finish());
            } else {
                drop(encoder);
            }
            let again = prepare(&mut shadows, &second, &views);
            assert_eq!(counts(&again), [views.len() as u64, 0], "{tier:?}");
        }
        // The first frame of all, too.
        let mut other = shadows.another();
        drop(recorded(gpu, &prepare(&mut other, &second, &views)));
        let expected = truth(gpu, &second, &views);
        for shadows in [&mut shadows, &mut other] {
            let found = submit(gpu, &prepare(shadows, &second, &views));
            assert_equal(&found, &expected, &format!("{tier:?}"));
        }
    }
}

/// Maps that would have been copied to other rectangles.
#[test]
fn maps_whose_move_is_dropped_are_rendered() {
    let (gpu, _guard) = &lone_gpu(Tier::Native);
    let (mut shadows, views) = (shadows(gpu), views());
    let casters = particles(600, 6);
    let settings = ShadowSettings::default();
    let materials = materials();
    let mut prepare = |views: &[View]| {
        let casters = Casters { particles: &casters, materials: &materials, ..Casters::default() };
        shadows.prepare(&casters, views, &settings).unwrap()
    };
    let expected = submit(gpu, &prepare(&views[..3]));
    let mut turned = views.clone();
    turned.swap(0, 7);
    run(gpu, &prepare(&turned));
    drop(recorded(gpu, &prepare(&views[..3])));
    assert_equal(&submit(gpu, &prepare(&views[..3])), &expected, "moved");
}

/// Whether or not the device has finished it.
#[test]
fn a_frame_that_was_submitted_is_kept() {
    for tier in tiers(Tier::Native) {
        let gpu = &gpu(tier);
        let (mut shadows, views) = (shadows(gpu), views());
        let all = views.len() as u64;
        let casters = particles(3000, 7);
        let expected = truth(gpu, &casters, &views);
        for waits in [false, true] {
            for shift in [1.0, 2.0] {
                run(gpu, &prepare(&mut shadows, &moved(&casters, Vec3::Z * shift), &views));
            }
            for _ in 0..6 {
                run(gpu, &prepare(&mut shadows, &casters, &views));
                if waits {
                    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
                }
            }
            let last = prepare(&mut shadows, &casters, &views);
            assert_eq!(counts(&last), [0, all], "{tier:?} {waits}");
            assert_equal(&submit(gpu, &last), &expected, &format!("{tier:?} {waits}"));
        }
        // Twice in one encoder and in two.
        let prepared = prepare(&mut shadows, &moved(&casters, Vec3::Z), &views);
        let mut encoder = recorded(gpu, &prepared);
        prepared.record(&mut encoder).unwrap();
        gpu.queue.submit([encoder.finish(), recorded(gpu, &prepared).finish()]);
        let last = prepare(&mut shadows, &moved(&casters, Vec3::Z), &views);
        assert_eq!(counts(&last), [0, all], "{tier:?}");
        gpu.check().unwrap();
    }
}

/// A submission that the device refuses for another reason, and a later one.
#[test]
fn a_frame_that_is_refused_did_not_run() {
    let (gpu, _guard) = &lone_gpu(Tier::Native);
    let (mut shadows, views) = (shadows(gpu), views());
    let casters = particles(600, 8);
    let prepared = prepare(&mut shadows, &casters, &views);
    let gone = gpu.storage::<u32>("gone", 1);
    let mut encoder = recorded(gpu, &prepared);
    encoder.clear_buffer(&gone, 0, None);
    let commands = encoder.finish();
    gone.destroy();
    assert!(refusal(gpu, [commands]).is_some());
    let again = prepare(&mut shadows, &casters, &views);
    assert_eq!(counts(&again), [views.len() as u64, 0]);
    assert_equal(&submit(gpu, &again), &truth(gpu, &casters, &views), "refused");
}

#[test]
fn a_frame_that_is_submitted_after_the_next_prepare_is_refused() {
    for tier in tiers(Tier::Native) {
        let (gpu, _guard) = &lone_gpu(tier);
        let (mut shadows, views) = (shadows(gpu), views());
        let casters = particles(600, 9);
        let of = |step: f32| moved(&casters, Vec3::X * (0.1 * step));
        run(gpu, &prepare(&mut shadows, &of(0.0), &views));
        let late = recorded(gpu, &prepare(&mut shadows, &of(1.0), &views));
        let next = prepare(&mut shadows, &of(2.0), &views);
        let late = [late.finish(), recorded(gpu, &next).finish()];
        let error = refusal(gpu, late);
        assert!(error.is_some_and(|it| it.contains("later `prepare`")), "{tier:?}");
        // The frame that went with it did not run either.
        let next = prepare(&mut shadows, &of(2.0), &views);
        assert_equal(&submit(gpu, &next), &truth(gpu, &of(2.0), &views), &format!("{tier:?}"));
        // A frame that ran, and is submitted again after the next `prepare`.
        let prepared = prepare(&mut shadows, &of(3.0), &views);
        let late = recorded(gpu, &prepared).finish();
        run(gpu, &prepared);
        let next = prepare(&mut shadows, &of(4.0), &views);
        assert!(refusal(gpu, [late]).is_some(), "{tier:?}");
        assert_equal(&submit(gpu, &next), &truth(gpu, &of(4.0), &views), &format!("{tier:?}"));
        gpu.check().unwrap();
    }
}

#[test]
fn a_frame_that_did_not_run_has_no_counters() {
    let (gpu, _guard) = &lone_gpu(Tier::Native);
    let (mut shadows, views) = (shadows(gpu), views());
    let casters = particles(600, 10);
    let mut frame = |count: usize, is_submitted: bool| {
        let prepared = prepare(&mut shadows, &casters[..count], &views);
        let mut encoder = recorded(gpu, &prepared);
        prepared.record_statistics(&mut encoder).unwrap();
        if is_submitted {
            gpu.queue.submit([encoder.finish()]);
        }
        // Another thread that polls the same device may receive its answer.
        let asked = Instant::now();
        loop {
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            let counters = shadows.statistics().unwrap();
            if counters.is_some() || !is_submitted || asked.elapsed() > PATIENCE {
                return counters.map(|counters| counters.casters);
            }
        }
    };
    // Each read-back buffer of counters is used several times.
    for count in 1..12 {
        assert_eq!(frame(50 * count, count % 3 > 0), (count % 3 > 0).then_some(50 * count as u64));
    }
}
