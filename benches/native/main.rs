//! Kernels against loops for the CPU that do the same work on the same data, measured in turns.
//!
//! `cargo bench -p gobo-benches --bench native`, or `cargo bench -p gobo-benches --bench native -- sort` for
//! one of the two tables. No time is printed before the results agree.
#[path = "../common/mod.rs"]
mod common;

mod accumulate;
mod sort;

use accumulate::{Lists, Texel};
use common::{PairSort, SIZE, pairs, particles, stage_time, timeline, view};
use fearless_simd::Level;
use gobo::{
    Counters, Prepared, Receiver, ShadowSettings, Shadows,
    glam::UVec2,
    gpu::{Gpu, Resource, Timeline},
    model::{Casters, Material},
    records::{CasterRecord, DEPTH_BITS, GpuMaterial, TileRect},
    shadows::cull::order,
    wgpu,
};
use gobo_reference as reference;
use gobo_reference::{Pair, project::ProjectParams};
use half::f16;
use std::{
    num::NonZero,
    time::{Duration, Instant},
};

/// Frames of each, after [`WARM_UP`]; times are their median.
const RUNS: usize = 9;
const WARM_UP: usize = 2;
/// F is stored as fp16, and products are rounded in another order.
const FILTER_TOLERANCE: f32 = 1.0 / 1024.0;
/// Share of texels where rounding decides whether the rim of opacity 1/255 sets D.
const DEPTH_SHARE: f64 = 1e-4;

/// Casters and their mean diameter [texels].
const CASES: [(u32, f32); 3] = [(100_000, 16.0), (1_000_000, 16.0), (1_000_000, 6.0)];
/// Pairs to sort, and bits of their keys.
const SORTS: [(u32, u32); 3] = [(1_000_000, 16), (1_000_000, 24), (1_000_000, 32)];

/// Milliseconds of every run.
#[derive(Default)]
struct Times(Vec<f64>);

impl Times {
    fn add(&mut self, run: usize, time: Duration) {
        if run >= WARM_UP {
            self.0.push(time.as_secs_f64() * 1e3);
            self.0.sort_by(f64::total_cmp);
        }
    }

    fn median(&self) -> f64 {
        self.0[self.0.len() / 2]
    }
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (min, max) = (self.0[0], self.0[self.0.len() - 1]);
        f.pad(&format!("{:.2} ({min:.2}..{max:.2})", self.median()))
    }
}

fn timed(work: impl FnOnce()) -> Duration {
    let started = Instant::now();
    work();
    started.elapsed()
}

/// The pairs by tile, front to back, of the casters in the order of the upload.
fn lists(casters: &[CasterRecord]) -> Lists {
    let (view, material) = (view(), GpuMaterial::new(&Material::default(), &[]));
    let gpu_view = view.to_gpu(0, UVec2::ZERO, 0);
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    let projected: Vec<_> = casters
        .iter()
        .zip(0..)
        .map(|(caster, id)| {
            reference::project::project_caster(&gpu_view, 0, (caster, id), &material, None, params)
        })
        .collect();
    let rects: Vec<TileRect> = projected.iter().map(|projected| projected.rect).collect();
    let mut sorted: Vec<Pair> =
        projected.iter().zip(0..).map(|(p, value)| Pair { key: p.key, value }).collect();
    reference::sort(&mut sorted, 0..DEPTH_BITS);
    let sorted: Vec<u32> = sorted.iter().map(|pair| pair.value).collect();
    let tiles = view.tiles();
    let bins = reference::bin::bin(
        &sorted,
        &rects,
        |_| None,
        &[gpu_view],
        tiles.element_product(),
        u32::MAX,
    );
    Lists {
        footprints: projected.iter().map(|projected| projected.footprint).collect(),
        pairs: bins.pairs.iter().map(|pair| pair.footprint).collect(),
        starts: bins.tile_starts,
        tiles_x: tiles.x as usize,
    }
}

/// Largest difference in F, or an error.
fn compare(ours: &[Texel], theirs: &[Texel]) -> Result<f32, String> {
    if ours.len() != theirs.len() {
        return Err(format!("{} texels, not {}", theirs.len(), ours.len()));
    }
    let (mut largest, mut depths) = (0.0_f32, 0);
    for (at, (a, b)) in ours.iter().zip(theirs).enumerate() {
        let differences = [0, 1, 2].map(|i| (a[i] - b[i]).abs());
        // Written so that a NaN is wrong.
        if !differences.iter().all(|&difference| difference <= FILTER_TOLERANCE) {
            return Err(format!("texel {at}: {a:?} and {b:?}"));
        }
        largest = differences.into_iter().fold(largest, f32::max);
        depths += usize::from(a[3] != b[3]);
    }
    let share = depths as f64 / ours.len() as f64;
    if share > DEPTH_SHARE {
        return Err(format!("{depths} nearest depths differ"));
    }
    Ok(largest)
}

/// Widest vectors: AVX2 on x86, which llvmpipe compiles for. (AVX-512 brings nothing to this loop.)
fn level() -> Level {
    let widest = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = widest.as_avx2() {
        return Level::Avx2(avx2);
    }
    widest
}

/// Maps of the kernels.
fn kernel_map(gpu: &Gpu, prepared: &Prepared) -> Vec<Texel> {
    let filters: Vec<[u16; 4]> = gpu.read_texture(&prepared.maps().filters);
    let nearests: Vec<f32> = gpu.read_texture(&prepared.maps().nearests);
    let texel = |(filter, &depth): (&[u16; 4], &f32)| {
        let [red, green, blue, _] = filter.map(|bits| f16::from_bits(bits).to_f32());
        [red, green, blue, depth]
    };
    filters.iter().zip(&nearests).map(texel).collect()
}

fn compare_accumulate(gpu: &Gpu) {
    let level = level();
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    println!(
        "\naccumulate, {SIZE}x{SIZE}, soft discs of opacity 0.02, spread; native: {threads} threads, \
         {level:?} [ms, median (min..max)]"
    );
    println!(
        "{:>8} {:>6} {:>8} {:>8} {:>24} {:>24} {:>6}",
        "casters", "texels", "pairs", "max |dF|", "kernel", "native", "ratio"
    );
    let mut timeline = timeline(gpu);
    for (count, footprint) in CASES {
        let particles = particles(count, footprint);
        let centers: Vec<_> = particles.iter().map(|particle| particle.center).collect();
        let materials = [Material::default()];
        let uploaded: Vec<_> = order::morton(&centers)
            .into_iter()
            .map(|i| CasterRecord::new(&particles[i as usize], &materials[0]))
            .collect();
        let lists = lists(&uploaded);
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let pair_count = lists.pairs.len() as u32;
        let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)
            .expect("the device runs the kernels");
        let nearest = ShadowSettings { receiver: Receiver::Nearest, ..ShadowSettings::default() };
        shadows.grow_from(&Counters { pairs_needed: pair_count, ..Counters::default() });
        let prepared =
            shadows.prepare(&casters, &[view()], &nearest).expect("the device has the memory");
        let mut map = vec![[f32::NAN; 4]; (SIZE * SIZE) as usize];
        let (mut kernel, mut native) = (Times::default(), Times::default());
        for run in 0..WARM_UP + RUNS {
            let record = |encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline| {
                prepared.record_timed(encoder, timeline).expect("it is the last");
            };
            kernel.add(run, stage_time(gpu, &mut timeline, "accumulate", 1, record));
            native.add(run, timed(|| accumulate::accumulate(level, threads, &lists, &mut map)));
        }
        let counters = prepared.counters().expect("the device works");
        assert_eq!(counters.pairs, u64::from(pair_count), "both have the same pairs");
        assert_eq!(counters.scattered, 0);
        let ours = kernel_map(gpu, &prepared);
        let difference =
            compare(&ours, &map).unwrap_or_else(|wrong| panic!("{count} casters: {wrong}"));
        map[12_345][1] += 2.0 * FILTER_TOLERANCE;
        assert!(compare(&ours, &map).is_err(), "a wrong texel is noticed");
        println!(
            "{count:>8} {footprint:>6} {pair_count:>8} {difference:>8.6} {kernel:>24} {native:>24} {:>6.2}",
            kernel.median() / native.median()
        );
    }
}

/// Error of the first pair that is not where a stable sort puts it.
fn misplaced(found: &[Pair], expected: &[Pair]) -> Result<(), String> {
    let at = (0..expected.len()).find(|&at| found.get(at) != Some(&expected[at]));
    at.map_or(Ok(()), |at| Err(format!("pair {at} is {:?}, not {:?}", found.get(at), expected[at])))
}

fn compare_sort(gpu: &Gpu) {
    println!("\nsort of (key, value) pairs, 32 bits each [ms, median (min..max)]");
    println!(
        "{:>8} {:>5} {:>24} {:>24} {:>6} {:>26} {:>9}",
        "pairs", "bits", "kernels", "native, one thread", "ratio", "lampshade", "of it"
    );
    let Gpu { device, queue, .. } = gpu;
    // Shared by both contestants, so that both are timed alike.
    let mut timeline = Timeline::stepped(device, queue);
    let mut lampshade = lampshade::KeyValueSorter::new_for_adapter(device, queue, &gpu.adapter);
    for (count, bits) in SORTS {
        let keys = pairs(count).into_iter();
        let unsorted: Vec<_> =
            keys.map(|Pair { key, value }| Pair { key: key >> (32 - bits), value }).collect();
        let mut expected = unsorted.clone();
        expected.sort_by_key(|pair| pair.key);

        let on_device = PairSort::new(gpu, &unsorted, bits);
        let from = gpu.upload("unsorted", &unsorted, wgpu::BufferUsages::STORAGE);
        let to = gpu.storage::<Pair>("sorted", unsorted.len());

        let (mut kernels, mut native, mut theirs) =
            (Times::default(), Times::default(), Times::default());
        let (mut sorted, mut scratch) = (Vec::new(), unsorted.clone());
        for run in 0..WARM_UP + RUNS {
            let record = |encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline| {
                on_device.record(encoder, timeline);
            };
            kernels.add(run, stage_time(gpu, &mut timeline, "sort", 1, record));
            sorted.clone_from(&unsorted);
            native.add(run, timed(|| sort::sort(&mut sorted, &mut scratch, bits)));
            let record = |encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline| {
                timeline.step(encoder, "lampshade");
                lampshade
                    .record_sort_with_key_bits(encoder, &from, &to, count, bits)
                    .expect("the buffers are as it wants them");
            };
            theirs.add(run, stage_time(gpu, &mut timeline, "lampshade", 1, record));
        }
        let found: Vec<Pair> = match &on_device.records[2] {
            Resource::Buffer(buffer) => gpu.read(buffer),
            Resource::Texture(texture) => gpu.read_texture(texture),
            Resource::View(view) => gpu.read_texture(view.texture()),
        };
        misplaced(&found[..unsorted.len()], &expected).unwrap_or_else(|wrong| panic!("{wrong}"));
        misplaced(&sorted, &expected).unwrap_or_else(|wrong| panic!("native: {wrong}"));
        sorted.swap(12_344, 12_345);
        assert!(misplaced(&sorted, &expected).is_err(), "a wrong pair is noticed");
        let (theirs, share) = match misplaced(&gpu.read(&to), &expected) {
            Ok(()) => (theirs.to_string(), format!("{:.2}", kernels.median() / theirs.median())),
            Err(wrong) => (format!("wrong: {wrong}"), "-".to_owned()),
        };
        println!(
            "{count:>8} {bits:>5} {kernels:>24} {native:>24} {:>6.2} {theirs:>26} {share:>9}",
            kernels.median() / native.median()
        );
    }
}

fn main() {
    let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let wants = |name: &str| wanted.is_empty() || wanted.iter().any(|part| name.contains(part));
    println!("{} ({})", gpu.adapter.name, gpu.tier_reason);
    if wants("accumulate") {
        compare_accumulate(&gpu);
    }
    if wants("sort") {
        compare_sort(&gpu);
    }
}
