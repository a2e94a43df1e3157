//! Kernels that a host's threads compile before a frame needs them, the time of each, and memory by mode.
use gobo::{
    Bounds, Casters, CurveMemory, Gpu, HostInputs, Light, Material, Particle, Receiver,
    ShadowSettings, Shadows, Transfer, View, glam::Vec3, host::Selection, light_views, wgpu,
};
use std::{error::Error, sync::Mutex, thread, time::Instant};

type Done = Result<(), Box<dyn Error + Send + Sync>>;

/// Smoke in front of a ground.
fn particles() -> Vec<Particle> {
    let at = |i: f32| Vec3::new((i * 0.37).sin(), 1.0 + (i * 0.11).sin(), (i * 0.23).cos());
    (0..5000)
        .map(|i| Particle { center: at(i as f32), radius: 0.1, id: i, ..Particle::default() })
        .collect()
}

fn main() -> Done {
    let gpu = Gpu::new(&Selection::default())?;
    let (particles, lamp) = (particles(), Light::point(Vec3::new(0.2, 4.0, 0.3)));
    let bounds = Bounds { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) };
    let views = |size| light_views(0, &lamp, size, None, &bounds);
    let curve = ShadowSettings { receiver: Receiver::Curve, ..ShadowSettings::default() };
    let nearest = ShadowSettings { receiver: Receiver::Nearest, ..curve };
    println!(
        "| | kernels | one after another | on {} threads | first frame | next | bytes of a texel |",
        cores()
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, transfer, settings) in [
        ("nearest depth", Transfer::Filter, nearest),
        ("`over`, in its order", Transfer::Over, nearest),
        ("dithered, `soften`", Transfer::Dither, ShadowSettings { soften: true, ..nearest }),
        ("curve of 4", Transfer::Filter, ShadowSettings { nodes: 4, ..curve }),
        ("curve of 8", Transfer::Filter, curve),
        ("curve of 16", Transfer::Filter, ShadowSettings { nodes: 16, ..curve }),
        (
            "dithered, curve of 8, `soften`",
            Transfer::Dither,
            ShadowSettings { soften: true, ..curve },
        ),
        (
            "curve of 8 in pages",
            Transfer::Filter,
            ShadowSettings { curve_memory: CurveMemory::Counted, ..curve },
        ),
    ] {
        let materials = [Material { transfer, ..Material::default() }];
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let [small, large] = [views(256)?, views(512)?];
        let (count, [one, ..], _) = measure(&gpu, &casters, &large, &settings, 1)?;
        let (_, [many, first, next], most) = measure(&gpu, &casters, &large, &settings, cores())?;
        let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)?;
        let least = shadows.prepare(&casters, &small, &settings)?.memory().total();
        let texels = |views: &[View]| -> f64 {
            views.iter().map(|view| f64::from(view.size.element_product())).sum()
        };
        let bytes = (most - least) as f64 / (texels(&large) - texels(&small));
        println!(
            "| {name} | {count} | {one:.0} ms | {many:.0} ms | {first:.0} ms | {next:.0} ms | \
             {bytes:.1} |"
        );
    }
    Ok(())
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Number of kernels; times to compile them, of the first frame and of the next [ms]; memory [bytes].
fn measure(
    gpu: &Gpu,
    casters: &Casters<'_>,
    views: &[View],
    settings: &ShadowSettings,
    threads: usize,
) -> Result<(usize, [f64; 3], u64), Box<dyn Error + Send + Sync>> {
    let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)?;
    let jobs = shadows.pending(casters, views, settings, &HostInputs::new())?;
    let start = Instant::now();
    let (left, failed) = (Mutex::new(jobs.iter()), Mutex::new(Ok(())));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let job = left.lock().ok().and_then(|mut left| left.next());
                    let Some(job) = job else { break };
                    if let (Err(error), Ok(mut failed)) = (job.run(), failed.lock()) {
                        *failed = Err(error);
                    }
                }
            });
        }
    });
    failed.into_inner()??;
    assert!(shadows.is_ready(), "all were run");
    let mut times = [start.elapsed().as_secs_f64() * 1e3, 0.0, 0.0];
    let prepared = shadows.prepare(casters, views, settings)?;
    for time in &mut times[1..] {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        *time = start.elapsed().as_secs_f64() * 1e3;
    }
    Ok((jobs.len(), times, prepared.memory().total()))
}
