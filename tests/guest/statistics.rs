//! Counters of frames, read without blocking.
use super::{HostBuffers, materials, on_device, particles, shadows, submit as bits, views};
use crate::common::{TIERS, gpu};
use gobo::{
    CasterCount, Casters, Counters, HostCasters, Prepared, ShadowSettings, Shadows, frame::Command,
    gpu::Gpu, wgpu,
};
use std::time::{Duration, Instant};

/// Dispatches of a host's steady frame: two batches of lists, each projected, sorted, binned and walked.
const MOST_DISPATCHES: usize = 60;

fn submit(gpu: &Gpu, prepared: &Prepared) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    prepared.record_statistics(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
}

/// Polls until the device has delivered the counters.
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

        // Frames are recorded while one's statistics are on their way, and one that waits comes between.
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

/// Settings that state neither receiver nor nodes.
#[test]
fn statistics_tell_of_curves_past_their_budget() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (uploaded, materials) = (particles(100, 4), materials());
    let casters = Casters { particles: &uploaded, materials: &materials, ..Casters::default() };
    let mut dropped_of = |settings: &ShadowSettings| {
        let prepared = shadows.prepare(&casters, &views(), settings).unwrap();
        submit(&gpu, &prepared);
        let dropped = told(&mut shadows).nodes_dropped;
        assert_eq!(u64::from(prepared.maps().nodes) + dropped, 8, "{}", settings.curve_budget);
        let memory = &prepared.memory().0;
        let bytes = memory.iter().filter(|(name, _)| *name == "curves").map(|(_, bytes)| bytes);
        (dropped, bytes.sum::<u64>())
    };
    let (none, all) = dropped_of(&ShadowSettings::default());
    let within = |curve_budget| ShadowSettings { curve_budget, ..ShadowSettings::default() };
    assert_eq!((none, dropped_of(&within(all)).0), (0, 0));
    assert_eq!(dropped_of(&within(all - 1)), (4, all / 2));
    assert_eq!(dropped_of(&within(all / 2 - 1)).0, 8);
}

/// Passes and dispatches of a frame.
fn recorded(prepared: &Prepared) -> [usize; 2] {
    let passes = prepared.commands().iter().filter_map(|command| match command {
        Command::Pass { dispatches, .. } => Some(dispatches.len()),
        _ => None,
    });
    passes.fold([0; 2], |[passes, all], own| [passes + 1, all + own])
}

/// The pairs of a host's casters have no useful bound. From the second frame on, the number that its frames
/// needed is known: then no work is recorded for pairs that do not fit, except the dispatch that scatters
/// them.
#[test]
fn steady_frames_of_a_host_record_no_empty_work() {
    const COUNT: u32 = 20_000;
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let host = HostBuffers::new(&gpu, &particles(COUNT as usize, 21));
    let loader = host.loader(&shadows);
    let sets = [HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(COUNT), &[0, 1])];
    let settings = ShadowSettings::default();
    let first = on_device(&mut shadows, &[], &sets, &settings);
    submit(&gpu, &first);
    let counters = told(&mut shadows);
    let (needed, capacity) = (u64::from(counters.pairs_needed), u64::from(counters.pair_capacity));
    assert!(needed > 0 && needed * 5 / 4 < capacity, "{counters:?}");
    let whole = bits(&gpu, &first);
    let steady = on_device(&mut shadows, &[], &sets, &settings);
    assert!(bits(&gpu, &steady) == whole);
    let [before, after] = [&first, &steady].map(recorded);
    let count = |prepared: &Prepared, kernel| {
        format!("{:?}", prepared.commands()).matches(&format!("\n  {kernel} ")).count()
    };
    let parts = count(&first, "part_next");
    assert!(parts > 4, "{parts} parts");
    for (kernel, unknown, known) in [
        ("part_count", 1, 0),
        ("part_plan", 1, 0),
        ("part_next", parts, 0),
        ("part_gather", parts, 0),
        ("accumulate_overflow", 1, 1),
    ] {
        assert_eq!([&first, &steady].map(|it| count(it, kernel)), [unknown, known], "{kernel}");
    }
    let fewer = before[1] - after[1];
    assert!(after[1] <= MOST_DISPATCHES && fewer > 4 * parts, "{before:?}, then {after:?}");
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
