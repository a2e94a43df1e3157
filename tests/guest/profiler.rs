//! A host's own profiler around each pass.
use super::{bits, materials, particles, shadows, submit, views};
use crate::common::{TIERS, gpu};
use gobo::{Casters, ShadowSettings, Timeline, gpu::Gpu, host::Profiler, wgpu};
use std::sync::{Arc, Mutex};

/// Number of passes that it can time.
const PASSES: u32 = 64;

#[derive(Debug)]
struct Log {
    stamps: Option<wgpu::QuerySet>,
    labels: Arc<Mutex<Vec<&'static str>>>,
}

impl Profiler for Log {
    fn begin(
        &mut self,
        _: &mut wgpu::CommandEncoder,
        label: &'static str,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let mut labels = self.labels.lock().unwrap();
        let first = labels.len() as u32;
        labels.push(label);
        self.stamps.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    fn end(&mut self, _: &mut wgpu::CommandEncoder) {
        self.labels.lock().unwrap().push("end");
    }
}

fn stamps(gpu: &Gpu) -> Option<wgpu::QuerySet> {
    let has = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
    has.then(|| {
        gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: None,
            ty: wgpu::QueryType::Timestamp,
            count: 2 * PASSES,
        })
    })
}

#[test]
fn a_profiler_sees_each_pass_from_begin_to_end() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let (particles, materials) = (particles(500, 5), materials());
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let mut shadows = shadows(&gpu);
        let prepared = shadows.prepare(&casters, &views(), &ShadowSettings::default()).unwrap();
        let labels = Arc::new(Mutex::new(Vec::new()));
        let stamps = stamps(&gpu);
        let log = Log { stamps: stamps.clone(), labels: Arc::clone(&labels) };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record_timed(&mut encoder, &mut Timeline::profiled(log)).unwrap();
        let labels = labels.lock().unwrap();
        let count = labels.len() as u32;
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = gpu.upload("ticks", &vec![0_u64; 2 * PASSES as usize], usage);
        if let Some(stamps) = &stamps {
            encoder.resolve_query_set(stamps, 0..count, &resolved, 0);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.check().unwrap();

        assert!(count <= 2 * PASSES, "{labels:?}");
        let (begun, ended): (Vec<_>, Vec<_>) = labels.chunks_exact(2).map(|c| (c[0], c[1])).unzip();
        assert_eq!((ended, count % 2), (vec!["end"; begun.len()], 0), "{tier:?}");
        for stage in ["gobo project", "gobo sort", "gobo bin", "gobo accumulate", "gobo resolve"] {
            assert!(begun.contains(&stage), "{begun:?}");
        }
        assert!(begun.iter().all(|label| label.starts_with("gobo ")), "{begun:?}");
        if stamps.is_some() {
            let ticks: Vec<u64> = gpu.read(&resolved);
            let (ticks, _) = ticks[..count as usize].as_chunks::<2>();
            assert!(ticks.iter().all(|&[begin, end]| begin > 0 && begin <= end), "{ticks:?}");
        }
    }
}

#[test]
fn passes_of_a_split_timeline_are_submitted_one_by_one() {
    let gpu = gpu(TIERS[1]);
    let (particles, materials) = (particles(500, 5), materials());
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let mut shadows = shadows(&gpu);
    let prepared = shadows.prepare(&casters, &views(), &ShadowSettings::default()).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut timeline = Timeline::new(&gpu.device, &gpu.queue).split(&gpu.device, &gpu.queue);
    prepared.record_timed(&mut encoder, &mut timeline).unwrap();
    // All passes but the last have run.
    assert!(prepared.counters().unwrap().pairs > 500);
    timeline.finish(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    let found = bits(&gpu, &prepared);
    if stamps(&gpu).is_some() {
        let stages: Vec<_> =
            timeline.read(&gpu.device).into_iter().map(|(stage, _)| stage).collect();
        assert!(
            ["project", "sort", "bin", "accumulate"].iter().all(|s| stages.contains(s)),
            "{stages:?}"
        );
    }
    assert!(found == submit(&gpu, &prepared));
}
