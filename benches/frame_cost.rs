//! CPU time of a host's frame, and gobo's allocations in it: none. Commands are
//! recorded and dropped, so that no kernel runs beside what is measured. Then frames in which all views move,
//! with the host's casters: `prepare_with`, and `bind_lights` or `bind_area_lights` for all of them. It fails
//! where a limit of docs/embedding.md is missed.
//!
//! An allocation is wgpu's if a function of its interface is in its backtrace, gobo's otherwise. The counting
//! allocator takes a lock for each.
//!
//! `cargo run --release -p gobo-benches --example frame_cost`
#[path = "../examples/common/particles.rs"]
mod particles;

use gobo::{
    Bounds, CasterCount, Casters, Gpu, HostCasters, HostInputs, Light, Material, Particle,
    Prepared, Receiver, ShadowSettings, Shadows, View,
    glam::Vec3,
    gpu::RecordForm,
    host::LightBindings,
    model::Source,
    wgpu::{self, BufferUsages},
};
use serde_json::Value;
use std::{error::Error, fs, time::Instant};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

const FRAMES: usize = 400;
const PARTICLES: u32 = 200_000;
/// Frames in which all views move.
const MOVING: usize = 100;
/// The most that recording a frame may take [us].
const BUDGET: f64 = 60.0;
/// Numbers of moving spots and of casters, and the most of a frame.
const MOVES: [(u32, u32, Most); 10] = [
    (1, 1000, Most { us: 100.0, allocations: 50, passes: 1 }),
    (16, 1000, Most { us: 100.0, allocations: 50, passes: 1 }),
    (64, 1000, Most { us: 200.0, allocations: 150, passes: 1 }),
    (256, 1000, Most { us: 400.0, allocations: 150, passes: 1 }),
    (16, 20_000, Most { us: 100.0, allocations: 50, passes: 1 }),
    (256, 20_000, Most { us: 400.0, allocations: 150, passes: 1 }),
    (16, 100_000, Most { us: 200.0, allocations: 50, passes: 1 }),
    (256, 100_000, Most { us: 800.0, allocations: 150, passes: 1 }),
    (16, 200_000, Most { us: 200.0, allocations: 55, passes: 1 }),
    (256, 200_000, Most { us: 800.0, allocations: 170, passes: 1 }),
];
/// Spots that are area lights for `bind_area_lights`; the others are points.
const MOST_AREAS: u32 = 64;

/// Marks of wgpu's stack frames, which all calls of it pass: files, or names without debug information.
const WGPU: [&str; 4] =
    ["(src/api/", "(src/backend/wgpu_core.rs", ": wgpu::", ": <wgpu::backend::wgpu_core::"];

const LOADER: &str = "
@group(1) @binding(0) var<storage, read> smoke: array<vec4<f32>>;

fn load_caster(index: u32) -> Caster {
    return Caster(smoke[index].xyz, smoke[index].w, vec4(0.5), 0.0, 0u, index);
}";

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::headless()?;
    let curve = ShadowSettings { size: 256, ..Default::default() };
    let nearest = ShadowSettings { receiver: Receiver::Nearest, ..curve };
    let lights =
        [Light::directional(Vec3::new(0.3, -1.0, 0.2)), Light::point(Vec3::new(-1.5, 2.5, 0.4))];
    println!(
        "least of {FRAMES} frames [us]     record  finish    made  gobo's allocations, wgpu's"
    );
    let mut slowest = 0.0_f64;
    for (name, settings, lights, is_host) in [
        ("uploads, a sun", nearest, &lights[..1], false),
        ("particles of the host's, a sun", nearest, &lights[..1], true),
        ("the same, sun and point light", nearest, &lights, true),
        ("the same, with curves", curve, &lights, true),
    ] {
        let Cost { record, finish, made, own, foreign } =
            measure(&gpu, &settings, lights, is_host)?;
        println!("{name:32} {record:6.1}  {finish:6.1}  {made:6}  {own:4} {foreign:4}");
        if made != 0 || own != 0 {
            return Err("recording made or allocated something".into());
        }
        slowest = slowest.max(record);
    }
    println!(
        "\nleast of {MOVING} frames [us]  prepare    bind    areas  record  finish  made  allocations  passes"
    );
    let mut missed = Vec::new();
    for (count, particles, most) in MOVES {
        let Moving { times, made, own, passes } = moving(&gpu, count, particles)?;
        let [prepare, bind, areas, record, finish] = times;
        println!(
            "{count:4} spots, {particles:6} casters   {prepare:7.1} {bind:7.1} {areas:8.1} {record:7.1} {finish:7.1}  {made:4}  {own:11}  {passes:6}"
        );
        let of = format!("{count} views that move and {particles} casters");
        if made != 0 {
            missed.push(format!("{of} made {made} objects"));
        }
        if own > most.allocations {
            missed.push(format!("{of}: {own} allocations, at most {}", most.allocations));
        }
        if passes > most.passes {
            missed.push(format!("{of}: {passes} passes, at most {}", most.passes));
        }
        if prepare + bind > most.us && !cfg!(debug_assertions) {
            missed.push(format!("{of} take more than {} us", most.us));
        }
    }
    if !missed.is_empty() {
        return Err(missed.join("; ").into());
    }
    // Without optimisations it says little.
    if slowest > BUDGET && !cfg!(debug_assertions) {
        return Err(format!("recording takes more than {BUDGET} us").into());
    }
    Ok(())
}

/// The most of a frame in which views move.
struct Most {
    /// Time of `prepare_with` and `bind_lights` together [us].
    us: f64,
    /// Allocations of gobo's in both.
    allocations: u64,
    passes: usize,
}

struct Cost {
    /// Times of `record` and of the encoder's `finish` [us].
    record: f64,
    finish: f64,
    /// Objects of the device's that all frames made.
    made: isize,
    /// Allocations of one frame's `record`: by gobo, and by wgpu for gobo's commands.
    own: u64,
    foreign: u64,
}

fn measure(
    gpu: &Gpu,
    settings: &ShadowSettings,
    lights: &[Light],
    is_host: bool,
) -> Result<Cost, Box<dyn Error>> {
    let Gpu { device, queue, .. } = gpu;
    // Bounds of another height have other views.
    let views = |top| -> Result<Vec<View>, gobo::Error> {
        let bounds = Bounds { min: Vec3::new(-2.5, 0.0, -2.5), max: Vec3::new(2.5, top, 2.5) };
        let of = |(i, light)| gobo::light_views(i, light, settings.size, None, &bounds);
        Ok((0..).zip(lights).map(of).collect::<Result<Vec<_>, _>>()?.concat())
    };
    let mut shadows = Shadows::new(device, queue, &gpu.adapter)?;
    let materials = [Material::default()];
    let particles: Vec<_> = (0..1000_u32)
        .map(|id| Particle { id, ..Particle::new([id as f32 * 0.002 - 1.0, 1.0, 0.0], 0.05) })
        .collect();
    let (smoke, layout) = smoke(device);
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("smoke"),
        layout: &layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: smoke.as_entire_binding() }],
    });
    let loader = shadows.caster_loader("smoke.wgsl", LOADER, &layout)?;
    let sets = [HostCasters::new(&loader, &bindings, CasterCount::Fixed(PARTICLES), &[0])];
    let inputs = if is_host { HostInputs::new().casters(&sets) } else { HostInputs::new() };
    let particles = if is_host { &[] } else { &particles[..] };
    let casters = Casters { particles, materials: &materials, ..Casters::default() };
    let first = shadows.prepare_with(&casters, &views(3.9)?, settings, &inputs)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    first.record(&mut encoder)?;
    first.record_statistics(&mut encoder)?;
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely())?;
    // From here on the device has said what a frame needs.
    shadows.statistics()?.ok_or("the device never has them")?;
    let prepared = shadows.prepare_with(&casters, &views(4.0)?, settings, &inputs)?;
    queue.submit([]);
    device.poll(wgpu::PollType::wait_indefinitely())?;
    // The first recordings are slower: memory of wgpu's own.
    frames(device, &prepared, 20);
    let before = living(device);
    let times = frames(device, &prepared, FRAMES);
    let made = living(device) - before;
    let least = |i: usize| times.iter().map(|times| times[i]).fold(f64::INFINITY, f64::min);
    let [own, foreign] = allocations(device, &prepared)?;
    Ok(Cost { record: least(0), finish: least(1), made, own, foreign })
}

struct Moving {
    /// Least times of `prepare_with`, `bind_lights`, `bind_area_lights`, `record` and the encoder's `finish`
    /// [us].
    times: [f64; 5],
    /// Objects of the device's that frames made while all are held.
    made: isize,
    /// Allocations of gobo's in `prepare_with` and `bind_lights`.
    own: u64,
    /// Compute passes of a frame.
    passes: usize,
}

/// Frames in which `count` spots move over `particles` of the host's.
fn moving(gpu: &Gpu, count: u32, particles: u32) -> Result<Moving, Box<dyn Error>> {
    let Gpu { device, queue, .. } = gpu;
    let settings = ShadowSettings { size: 64, receiver: Receiver::Nearest, ..Default::default() };
    let bounds = Bounds { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
    let mut shadows = Shadows::new(device, queue, &gpu.adapter)?;
    // As on GPUs: on software adapters a copy of the records ends a pass.
    shadows.configure(|config| config.tuning.record_form = RecordForm::Buffers);
    let materials = [Material::default()];
    let casters = Casters { materials: &materials, ..Casters::default() };
    let (smoke, layout) = smoke(device);
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("smoke"),
        layout: &layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: smoke.as_entire_binding() }],
    });
    let loader = shadows.caster_loader("smoke.wgsl", LOADER, &layout)?;
    let lights = |frame: usize| -> Vec<Light> {
        let spot = |i| {
            let angle = i as f32 * 0.39 + frame as f32 * 0.02;
            let position = Vec3::new(4.0 * angle.cos(), 4.0, 4.0 * angle.sin());
            let source = (i < MOST_AREAS).then_some(Source::Sphere { radius: 0.1 });
            Light { source, ..Light::spot(position, -position, 0.6) }
        };
        (0..count).map(spot).collect()
    };
    let chosen: Vec<usize> = (0..count as usize).collect();
    let mut held: Vec<(Prepared, LightBindings, LightBindings)> = Vec::new();
    let (mut times, mut before, mut own) = ([f64::INFINITY; 5], 0, 0);
    for frame in 0..MOVING {
        let lights = lights(frame);
        let views = (0..)
            .zip(&lights)
            .map(|(i, light)| gobo::light_views(i, light, settings.size, None, &bounds));
        let views = views.collect::<Result<Vec<_>, _>>()?.concat();
        let sets = [HostCasters::new(&loader, &bindings, CasterCount::Fixed(particles), &[0])];
        let inputs = HostInputs::new().casters(&sets).area_lights();
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut stamps = [Instant::now(); 6];
        let mut prepared = None;
        let mut make = || -> Result<LightBindings, gobo::Error> {
            let made = shadows.prepare_with(&casters, &views, &settings, &inputs)?;
            stamps[1] = Instant::now();
            prepared.insert(made).bind_lights(&lights, &chosen)
        };
        let last = frame + 1 == MOVING;
        let bound = if last {
            let (bound, [of_gobo, _]) = counted(make)?;
            own = of_gobo;
            bound?
        } else {
            make()?
        };
        stamps[2] = Instant::now();
        let prepared = prepared.ok_or("it is prepared")?;
        let areas = prepared.bind_area_lights(&lights, &chosen)?;
        stamps[3] = Instant::now();
        prepared.record(&mut encoder)?;
        stamps[4] = Instant::now();
        let commands = encoder.finish();
        stamps[5] = Instant::now();
        drop(commands);
        // The device says what a frame needs.
        let mut needs = device.create_command_encoder(&Default::default());
        if frame == 0 {
            prepared.record(&mut needs)?;
            prepared.record_statistics(&mut needs)?;
        }
        queue.submit([needs.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        if frame == 0 {
            shadows.statistics()?.ok_or("the device never has them")?;
        }
        if frame == 4 {
            before = living(device);
        }
        if (4..MOVING - 1).contains(&frame) {
            for (least, stamps) in times.iter_mut().zip(stamps.windows(2)) {
                *least = least.min((stamps[1] - stamps[0]).as_secs_f64() * 1e6);
            }
        }
        held.push((prepared, bound, areas));
    }
    let made = living(device) - before;
    let passes = held.last().map_or(0, |(prepared, ..)| prepared.commands().pass_count());
    Ok(Moving { times, made, own, passes })
}

/// The host's buffer, and the layout of its bindings.
fn smoke(device: &wgpu::Device) -> (wgpu::Buffer, wgpu::BindGroupLayout) {
    let smoke = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("smoke"),
        size: u64::from(PARTICLES) * 16,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let layout = particles::layout(device);
    (smoke, layout)
}

/// Allocations while one frame is recorded: gobo's own, and those of wgpu below it.
fn allocations(device: &wgpu::Device, prepared: &Prepared) -> Result<[u64; 2], Box<dyn Error>> {
    let mut encoder = device.create_command_encoder(&Default::default());
    let (recorded, counts) = counted(|| prepared.record(&mut encoder))?;
    recorded?;
    Ok(counts)
}

/// Result of `act`, and its allocations: gobo's own, and those of wgpu below it.
fn counted<T>(act: impl FnOnce() -> T) -> Result<(T, [u64; 2]), Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("gobo_frame_{}.json", std::process::id()));
    let profiler = dhat::Profiler::builder().file_name(&path).trim_backtraces(None).build();
    let result = act();
    drop(profiler);
    let report: Value = serde_json::from_slice(&fs::read(&path)?)?;
    fs::remove_file(&path)?;
    let list = |value: &Value, key| value[key].as_array().cloned().unwrap_or_default();
    let frames = list(&report, "ftbl");
    let mut counts = [0; 2];
    for place in list(&report, "pps") {
        let is_wgpu = list(&place, "fs").iter().any(|frame| {
            let frame = frame.as_u64().and_then(|frame| frames[frame as usize].as_str());
            frame.is_some_and(|frame| WGPU.iter().any(|part| frame.contains(part)))
        });
        counts[usize::from(is_wgpu)] += place["tbk"].as_u64().unwrap_or_default();
    }
    Ok((result, counts))
}

fn frames(device: &wgpu::Device, prepared: &Prepared, count: usize) -> Vec<[f64; 2]> {
    let frame = |_| {
        let mut encoder = device.create_command_encoder(&Default::default());
        let start = Instant::now();
        prepared.record(&mut encoder).expect("no later frame is prepared");
        let recorded = start.elapsed();
        let commands = encoder.finish();
        let finished = start.elapsed();
        drop(commands);
        [recorded, finished - recorded].map(|time| time.as_secs_f64() * 1e6)
    };
    (0..count).map(frame).collect()
}

/// Objects of the device's.
fn living(device: &wgpu::Device) -> isize {
    let hal = device.get_internal_counters().hal;
    hal.buffers.read()
        + hal.texture_views.read()
        + hal.bind_groups.read()
        + hal.compute_pipelines.read()
}
