//! Counters of frames, read without blocking.
use super::{HostBuffers, materials, on_device, particles, shadows, views};
use crate::common::{TIERS, gpu};
use gobo::{
    CasterCount, Casters, Counters, HostCasters, Prepared, ShadowSettings, Shadows,
    internals::gpu::Gpu, wgpu,
};
use std::time::{Duration, Instant};

fn submit(gpu: &Gpu, prepared: &Prepared) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    prepared.record_statistics(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
}

/// Polls until the device has the counters.
fn told(shadows: &mut Shadows) -> Counters {
    let start = Instant::now();
    loop {
        if let Some(counters) = shadows.statistics().unwrap() {
            return counters;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "the device never has them");
        std::thread::yield_now();
    }
}

#[test]
fn statistics_are_the_counters_of_their_frame() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let (mut uploaded, materials) = (particles(800, 9), materials());
        uploaded.iter_mut().for_each(|particle| particle.material = 2 * (particle.id & 1));
        let mut broken = particles(600, 10);
        broken[7].radius = f32::NAN;
        let host = HostBuffers::new(&gpu, &broken);
        let loader = host.loader(&shadows);
        let sets = [HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(600), &[0, 1])];
        let settings = ShadowSettings::default();
        let prepared = on_device(&mut shadows, &uploaded, &sets, &settings);
        assert_eq!(shadows.statistics().unwrap(), None, "nothing was recorded");
        submit(&gpu, &prepared);
        let counters = told(&mut shadows);
        assert!(counters.pairs > 0 && counters.visible > 0, "{counters:?}");
        assert_eq!(counters.skipped.values().sum::<u64>(), 1, "{counters:?}");
        assert_eq!(counters, prepared.counters().unwrap(), "{tier:?}");
        assert_eq!(shadows.statistics().unwrap(), None, "they were told");

        // Frames are recorded while the statistics of one are on their way, and one that waits comes
        // between.
        submit(&gpu, &prepared);
        submit(&gpu, &prepared);
        assert_eq!(prepared.counters().unwrap(), counters);
        submit(&gpu, &prepared);
        assert_eq!(told(&mut shadows), counters);
        gpu.check().unwrap();

        let none = Casters { materials: &materials, ..Casters::default() };
        submit(&gpu, &prepared);
        shadows.prepare(&none, &views(), &settings).unwrap();
        assert_eq!(told(&mut shadows), counters, "of maps that were taken over since");
    }
}

#[test]
fn statistics_of_changing_frames_arrive_with_two_in_flight() {
    const FRAMES: u64 = 60;
    for tier in TIERS {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let (mut uploaded, materials) = (particles(500, 3), materials());
        let mut in_flight = std::collections::VecDeque::new();
        let (mut arrived, mut last) = (0, 0);
        for frame in 0..FRAMES {
            // One caster more in each frame.
            uploaded.push(uploaded[frame as usize]);
            let casters =
                Casters { particles: &uploaded, materials: &materials, ..Casters::default() };
            let prepared = shadows.prepare(&casters, &views(), &ShadowSettings::default()).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder).unwrap();
            prepared.record_statistics(&mut encoder).unwrap();
            in_flight.push_back(gpu.queue.submit([encoder.finish()]));
            if in_flight.len() > 2 {
                let submission_index = in_flight.pop_front();
                let wait = wgpu::PollType::Wait { submission_index, timeout: None };
                gpu.device.poll(wait).unwrap();
            }
            if let Some(counters) = shadows.statistics().unwrap() {
                assert!(counters.casters > last, "frames in their order");
                last = counters.casters;
                arrived += 1;
            }
        }
        assert!(last >= 500 + FRAMES - 3, "{tier:?}: the latest is of {last} casters");
        // All but the first two frames in flight.
        assert!(arrived * 10 > FRAMES * 9, "{tier:?}: {arrived} of {FRAMES}");
    }
}
