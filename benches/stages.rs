//! Stages alone: the CPU references on the CPU; sort, bin and accumulate on the device.
//!
//! `cargo bench -p gobo-benches --bench stages`, or `cargo bench -p gobo-benches --bench stages -- gpu/sort`
//! for some of them.
mod common;

use common::{PairSort, mix, pairs, particles, stage_time, timeline, view};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput};
use gobo::{
    Receiver, ShadowSettings, Shadows,
    glam::{UVec2, Vec3},
    gpu::Gpu,
    model::{Bounds, Casters, Light, LightKind, Material, Particle},
    records::{CasterRecord, DEPTH_BITS, GpuMaterial, TileRect},
    shadows::cull::{Frustum, GroupTree, order, widened},
    view::light_views,
};
use gobo_reference as reference;
use gobo_reference::{Pair, project::ProjectParams};
use std::{hint::black_box, time::Duration};

const COUNTS: [u32; 2] = [100_000, 1_000_000];
/// Mean diameters [texels].
const FOOTPRINTS: [f32; 2] = [6.0, 16.0];

fn cpu_sort(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cpu/sort");
    for count in COUNTS {
        let unsorted = pairs(count);
        group.throughput(Throughput::Elements(count.into()));
        for bits in [DEPTH_BITS, 32] {
            group.bench_function(BenchmarkId::new(format!("{bits} bits"), count), |bencher| {
                let sort = |mut pairs: Vec<Pair>| {
                    reference::sort(&mut pairs, 0..bits);
                    pairs
                };
                bencher.iter_batched(|| unsorted.clone(), sort, BatchSize::LargeInput);
            });
        }
    }
    group.finish();
}

fn cpu_project_and_bin(criterion: &mut Criterion) {
    let (material, view) = (Material::default(), view());
    let gpu_material = GpuMaterial::new(&material, &[]);
    let gpu_view = view.to_gpu(0, UVec2::ZERO, 0);
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    let count = COUNTS[0];
    for footprint in FOOTPRINTS {
        let casters: Vec<_> =
            particles(count, footprint).iter().map(|p| CasterRecord::new(p, &material)).collect();
        let project = |(caster, id): (&CasterRecord, u32)| {
            reference::project::project_caster(
                &gpu_view,
                0,
                (caster, id),
                &gpu_material,
                None,
                params,
            )
        };
        let mut group = criterion.benchmark_group("cpu");
        group.throughput(Throughput::Elements(count.into()));
        group.bench_function(BenchmarkId::new("project", footprint), |bencher| {
            bencher.iter(|| black_box(casters.iter().zip(0..).map(project).collect::<Vec<_>>()));
        });
        let projected: Vec<_> = casters.iter().zip(0..).map(project).collect();
        let rects: Vec<TileRect> = projected.iter().map(|projected| projected.rect).collect();
        let mut sorted: Vec<Pair> =
            projected.iter().zip(0..).map(|(p, value)| Pair { key: p.key, value }).collect();
        reference::sort(&mut sorted, 0..DEPTH_BITS);
        let sorted: Vec<u32> = sorted.iter().map(|pair| pair.value).collect();
        let tile_count = view.tiles().element_product();
        group.bench_function(BenchmarkId::new("bin", footprint), |bencher| {
            bencher.iter(|| {
                reference::bin::bin(&sorted, &rects, |_| None, &[gpu_view], tile_count, u32::MAX)
            });
        });
        group.finish();
    }
}

/// Boxes of the spheres of `particles`, in `groups` groups in Morton order.
fn group_boxes(particles: &[Particle], groups: usize) -> Vec<Bounds> {
    let centers: Vec<Vec3> = particles.iter().map(|particle| particle.center).collect();
    let order = order::morton(&centers);
    let start = |group: usize| group * particles.len() / groups;
    let around = |members: &[u32]| {
        let members = members.iter().map(|&i| &particles[i as usize]);
        members.fold(Bounds::EMPTY, |b, p| b.with_sphere(p.center, p.radius))
    };
    (0..groups).map(|group| around(&order[start(group)..start(group + 1)])).collect()
}

/// Lamps among the particles, and above them: `angle` is a spot's whole cone [radians].
fn lamps(count: u64, angle: f32, far: f32) -> Vec<Frustum> {
    let lamp = |id: u64| {
        let unit = |salt: u64| (mix(id * 8 + salt) >> 40) as f32 / (1 << 24) as f32;
        let position = Vec3::new(2.0 * unit(1) - 1.0, 2.0 * unit(2) - 1.0, -1.8 * unit(3));
        let direction = (Vec3::new(unit(4), unit(5), unit(6)) - 0.5).normalize();
        let light = Light {
            kind: LightKind::Spot { position, direction, angle },
            near: Some(0.01),
            far: Some(far),
            ..Light::default()
        };
        Frustum::new(
            &light_views(0, &light, 512, None, &Bounds::EMPTY).expect("a light that shines")[0]
                .to_gpu(0, UVec2::ZERO, 0),
        )
    };
    (0..count).map(lamp).collect()
}

fn cpu_cull(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cpu/cull");
    let casters = particles(COUNTS[1], FOOTPRINTS[0]);
    for (groups, angle, far) in [(4096, 1.0, 1.0), (100_000, 0.6, 1.6)] {
        let boxes = group_boxes(&casters, groups);
        let tree = GroupTree::new(&boxes);
        let lamps = lamps(64, angle, far);
        let mut visible = Vec::new();
        let mut sum = 0;
        for lamp in &lamps {
            visible.clear();
            tree.cull(lamp, &mut visible);
            sum += visible.len();
        }
        eprintln!("{groups} groups: {:.2}% visible", sum as f64 / (64 * groups) as f64 * 100.0);
        group.throughput(Throughput::Elements(64));
        group.bench_function(BenchmarkId::new("tree, 64 views", groups), |bencher| {
            bencher.iter(|| {
                for lamp in &lamps {
                    visible.clear();
                    tree.cull(black_box(lamp), &mut visible);
                    black_box(&visible);
                }
            });
        });
        let wide: Vec<Bounds> = boxes.iter().filter_map(widened).collect();
        group.bench_function(BenchmarkId::new("loop, 64 views", groups), |bencher| {
            bencher.iter(|| {
                for lamp in &lamps {
                    visible.clear();
                    let seen = wide.iter().zip(0..).filter(|(bounds, _)| lamp.sees(bounds));
                    visible.extend(seen.map(|(_, group)| group));
                    black_box(&visible);
                }
            });
        });
        let mut refitted = tree.clone();
        group.bench_function(BenchmarkId::new("refit", groups), |bencher| {
            bencher.iter(|| refitted.refit(black_box(&boxes)));
        });
        group.bench_function(BenchmarkId::new("build", groups), |bencher| {
            bencher.iter(|| GroupTree::new(black_box(&boxes)));
        });
    }
    group.finish();
}

fn gpu_sort(criterion: &mut Criterion, gpu: &Gpu) {
    let mut group = criterion.benchmark_group("gpu/sort");
    let mut timeline = timeline(gpu);
    for count in COUNTS {
        group.throughput(Throughput::Elements(count.into()));
        for bits in [DEPTH_BITS, 32] {
            let sort = PairSort::new(gpu, &pairs(count), bits);
            group.bench_function(BenchmarkId::new(format!("{bits} bits"), count), |bencher| {
                bencher.iter_custom(|frames| {
                    stage_time(gpu, &mut timeline, "sort", frames, |encoder, timeline| {
                        sort.record(encoder, timeline);
                    })
                });
            });
        }
    }
    group.finish();
}

fn gpu_stages(criterion: &mut Criterion, gpu: &Gpu) {
    let mut timeline = timeline(gpu);
    let nearest = ShadowSettings { receiver: Receiver::Nearest, ..ShadowSettings::default() };
    for footprint in FOOTPRINTS {
        for count in COUNTS {
            let particles = particles(count, footprint);
            let materials = [Material::default()];
            let casters =
                Casters { particles: &particles, materials: &materials, ..Casters::default() };
            let prepared = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)
                .and_then(|mut shadows| shadows.prepare(&casters, &[view()], &nearest))
                .expect("the device has the memory");
            for stage in ["project", "bin", "accumulate"] {
                let mut group = criterion.benchmark_group(format!("gpu/{stage}"));
                group.throughput(Throughput::Elements(count.into()));
                group.bench_function(BenchmarkId::new(footprint.to_string(), count), |bencher| {
                    bencher.iter_custom(|frames| {
                        stage_time(gpu, &mut timeline, stage, frames, |encoder, timeline| {
                            prepared.record_timed(encoder, timeline).expect("it is the last");
                        })
                    });
                });
                group.finish();
            }
        }
    }
}

fn main() {
    let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    cpu_sort(&mut criterion);
    cpu_project_and_bin(&mut criterion);
    cpu_cull(&mut criterion);
    gpu_sort(&mut criterion, &gpu);
    gpu_stages(&mut criterion, &gpu);
    criterion.final_summary();
}
