//! Counters of frames, read without blocking.
use super::{HostBuffers, materials, on_device, particles, shadows, views};
use crate::common::{TIERS, gpu};
use gobo::{
    CasterCount, Casters, Counters, HostCasters, Prepared, ShadowSettings, internals::gpu::Gpu,
};
use std::time::{Duration, Instant};

fn submit(gpu: &Gpu, prepared: &Prepared) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    prepared.record_statistics(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
}

/// Polls until the device has the counters.
fn told(prepared: &Prepared) -> Counters {
    let start = Instant::now();
    loop {
        if let Some(counters) = prepared.statistics().unwrap() {
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
        assert_eq!(prepared.statistics().unwrap(), None, "nothing was recorded");
        submit(&gpu, &prepared);
        let counters = told(&prepared);
        assert!(counters.pairs > 0 && counters.visible > 0, "{counters:?}");
        assert_eq!(counters.skipped.values().sum::<u64>(), 1, "{counters:?}");
        assert_eq!(counters, prepared.counters().unwrap(), "{tier:?}");
        assert_eq!(prepared.statistics().unwrap(), None, "they were told");

        // Frames are recorded while the statistics of one are on their way, and one that waits comes
        // between.
        submit(&gpu, &prepared);
        submit(&gpu, &prepared);
        assert_eq!(prepared.counters().unwrap(), counters);
        submit(&gpu, &prepared);
        assert_eq!(told(&prepared), counters);
        gpu.check().unwrap();

        let none = Casters { materials: &materials, ..Casters::default() };
        shadows.prepare(&none, &views(), &settings).unwrap();
        assert!(prepared.statistics().is_err(), "they are of maps that are no more");
    }
}
