//! Time saved by clusters: a picture whose pixels evaluate the lights of their cluster, and the same picture
//! whose pixels evaluate all lights.
//!
//! `cargo run --release --example many_lights [SCENE=data/lamps.toml] [KEY=VALUE]...`
use gobo::{
    Shadows,
    gpu::{Gpu, Timeline},
    model::View,
    view::shadow_views,
};
use gobo_picture::picture::{PictureCapacity, PictureRequest, PreparedPicture};
use gobo_scene::load_with;
use std::{path::Path, time::Instant};

/// Frames, after one to warm up: drivers compile at the first use.
const RUNS: usize = 7;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (set, paths): (Vec<_>, Vec<_>) = arguments.iter().partition(|a| a.contains('='));
    let set: Vec<(String, String)> = set
        .iter()
        .filter_map(|a| a.split_once('='))
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect();
    let path = paths.first().map_or("data/lamps.toml", |path| path.as_str());
    let mut scene = load_with(Path::new(path), &set)?;

    let gpu = Gpu::headless()?;
    let (device, queue) = (&gpu.device, &gpu.queue);
    let mut shadows = Shadows::new(device, queue, &gpu.adapter)?;
    let views = shadow_views(&scene);
    let prepared = &shadows.prepare(&scene.casters(), &views, &scene.shadow)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder)?;
    queue.submit([encoder.finish()]);

    println!("{}; {path}: {} lights, {} views", gpu.adapter.name, scene.lights.len(), views.len());
    let mut pictures = Vec::new();
    for (name, budget) in [("clusters", scene.clusters.budget), ("all lights", 0)] {
        scene.clusters.budget = budget;
        let camera = &View::from_camera(&scene.camera, &scene.bounds());
        let capacity = PictureCapacity::default();
        let request = PictureRequest { scene: &scene, camera, prepared, capacity };
        let picture = PreparedPicture::new(&shadows, &request, &mut Default::default())?;
        let mut times: Vec<[f64; 3]> = Vec::new();
        for _ in 0..=RUNS {
            times.push(frame(&gpu, &picture)?);
        }
        let median = |i: usize| {
            let mut sorted: Vec<f64> = times[1..].iter().map(|time| time[i]).collect();
            sorted.sort_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        };
        let counters = picture.read_cluster_counters(&gpu)?;
        let mean = f64::from(counters.needed) / f64::from(picture.grid().cluster_count());
        println!(
            "{name:>10}: cluster {:.2} ms, shade {:.2} ms, whole picture {:.2} ms; {} clusters, \
             {mean:.1} lights in the mean, {} at most, {} clusters without a list",
            median(0),
            median(1),
            median(2),
            picture.grid().cluster_count(),
            counters.longest,
            counters.overflowed,
        );
        pictures.push(picture.read(&gpu)?.rgb);
    }
    println!(
        "the pictures are {}",
        if pictures[0] == pictures[1] { "the same" } else { "different" }
    );
    Ok(())
}

/// Times of the stages `cluster` and `shade`, and of the frame [ms].
fn frame(gpu: &Gpu, picture: &PreparedPicture) -> Result<[f64; 3], gobo::Error> {
    // A software adapter stamps when it records, not when the work is done.
    let mut timeline = if gpu.adapter.device_type == wgpu::DeviceType::Cpu {
        Timeline::stepped(&gpu.device, &gpu.queue)
    } else {
        Timeline::new(&gpu.device, &gpu.queue)
    };
    let start = Instant::now();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    picture.record(&mut encoder, &mut timeline);
    timeline.finish(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    picture.read_counters(gpu)?;
    let wall = start.elapsed().as_secs_f64() * 1e3;
    let stages = timeline.read(&gpu.device);
    let of = |wanted: &[&str]| {
        let known = stages.iter().filter(|(name, _)| wanted.contains(name));
        known.map(|(_, ms)| ms).sum::<f64>()
    };
    Ok([of(&["cluster"]), of(&["shade"]), wall])
}
