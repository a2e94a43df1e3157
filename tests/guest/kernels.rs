//! Kernels of load and cull, each tested alone against the CPU.
use super::{Vec3, materials, particles};
use crate::common::{TIERS, gpu, scenes::Chance};
use gobo::{
    Bounds, Light,
    glam::{UVec2, Vec4},
    gpu::{Gpu, Kernel, Resources},
    light_views,
    model::Particle,
    records::{
        CasterRecord, CullParams, DIAGONAL, GpuMaterial, GpuView, HostGroup, LoadCounters,
        LoadParams, MAX_MATERIALS, MAX_VIEWS,
    },
    shadows::cull::{Frustum, widened},
    stage::{
        bin::BinParams,
        load,
        project::{CHUNK_SIZE, Chunk, ProjectParams},
    },
    wgpu::BufferUsages,
};

const POISON: u32 = 0xdead_beef;

pub(super) fn run(gpu: &Gpu, kernel: &Kernel, resources: &Resources, groups: u32) {
    let bindings = kernel.bind(&gpu.device, resources).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    kernel.record(&mut encoder.begin_compute_pass(&Default::default()), &bindings, [groups, 1, 1]);
    gpu.queue.submit([encoder.finish()]);
}

/// A particle in WGSL's layout of `Caster`.
fn plain(particle: &Particle) -> [f32; 12] {
    let Particle { center: c, radius, color, rotation, material, id } = *particle;
    let [r, g, b, a] = color.to_array();
    let bits = [material, id].map(f32::from_bits);
    [c.x, c.y, c.z, radius, r, g, b, a, rotation, bits[0], bits[1], 0.0]
}

/// Whether records are the same. If division is not that of IEEE 754, a rotation may be a neighbour's value.
fn is_same(a: &[u32; 8], b: &[u32; 8]) -> bool {
    let turn = |record: &[u32; 8]| (record[6] >> 16) as u16;
    let rest = |record: &[u32; 8]| {
        let mut rest = *record;
        rest[6] &= 0xffff;
        rest
    };
    let steps = turn(a).wrapping_sub(turn(b)).wrapping_add(1);
    a == b || (rest(a) == rest(b) && steps <= 2)
}

#[test]
fn records_and_boxes_are_those_of_an_upload() {
    let gpu = gpu(TIERS[0]);
    let materials = materials();
    let mut all = particles(600, 11);
    let mut chance = Chance::new(12);
    for particle in &mut all {
        // Down to subnormal halves of the scaled opacity, and to zero.
        particle.color.w = [0.0, 1.0, 10_f32.powf(chance.within(-12.0, 0.0))][chance.below(3)];
        particle.rotation = chance.within(-100.0, 100.0);
    }
    all[300].radius = f32::NAN;
    let records: Vec<_> =
        materials.iter().map(|material| GpuMaterial::new(material, &[])).collect();
    let mut padded = vec![<GpuMaterial as bytemuck::Zeroable>::zeroed(); MAX_MATERIALS];
    padded[..records.len()].copy_from_slice(&records);
    let (first_group, first_caster) = (2, 100);
    let params = LoadParams {
        capacity: 600,
        group_count: 3,
        first_group,
        first_caster,
        quad_reach: DIAGONAL,
        materials: [[0b11, 0, 0, 0], [0; 4], [0; 4], [0; 4]],
        ..LoadParams::default()
    };
    let poison = vec![[POISON; 8]; 1000];
    let written = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let casters = gpu.upload("casters", &poison, written);
    let groups = gpu.storage::<HostGroup>("groups", 7);
    let given: Vec<_> = all.iter().map(plain).collect();
    let resources = [
        gpu.upload("materials", &padded, BufferUsages::UNIFORM),
        gpu.upload("params", &[params], BufferUsages::UNIFORM),
        gpu.upload("given", &given, BufferUsages::STORAGE),
        gpu.upload("counts", &[0_u32], BufferUsages::STORAGE),
    ];
    let [of_materials, of_params, of_given, of_counts] = &resources;
    let resources = Resources::new()
        .with("casters", &casters)
        .with("materials", of_materials)
        .with("load_params", of_params)
        .with("host_casters", of_given)
        .with("host_counts", of_counts)
        .with("host_groups", &groups);
    let kernel = Kernel::new(&gpu.device, &load::CASTERS, gpu.tier, &[], &[]).unwrap();
    run(&gpu, &kernel, &resources, 5);

    let found: Vec<[u32; 8]> = gpu.read(&casters);
    let read: Vec<HostGroup> = gpu.read(&groups);
    let (counted, groups) = LoadCounters::split(&read);
    let mut expected = poison;
    for (g, members) in all.chunks(CHUNK_SIZE as usize).enumerate() {
        let usable: Vec<_> = members.iter().filter(|p| p.radius > 0.0).collect();
        let mut bounds = Bounds::EMPTY;
        for (i, particle) in usable.iter().enumerate() {
            let material = &materials[particle.material as usize];
            let record = CasterRecord::new(particle, material);
            expected[first_caster as usize + g * CHUNK_SIZE as usize + i] = bytemuck::cast(record);
            let corner = if particle.material == 1 { 2_f32.sqrt() } else { 1.0 };
            bounds = bounds.with_sphere(particle.center, particle.radius * corner);
        }
        let group = groups[first_group as usize + g];
        assert_eq!(group.count as usize, usable.len());
        let least = usable.iter().map(|particle| particle.color.w).fold(1.0, f32::min);
        assert_eq!(group.least_alpha, least);
        let apart = [group.low - bounds.min, bounds.max - group.high];
        for apart in apart {
            assert!(apart.max_element() <= 1e-6 && apart.min_element() > -1e-3, "{apart}");
        }
    }
    let apart = found.iter().zip(&expected).find(|(a, b)| !is_same(a, b));
    assert!(apart.is_none() && found.len() == expected.len(), "{apart:x?}");
    assert!(groups[..2].iter().chain(&groups[5..]).all(|group| *group == HostGroup::default()));
    assert_eq!(counted, LoadCounters { taken: 599, skipped: 1 });
}

fn views() -> Vec<GpuView> {
    let bounds = Bounds { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) };
    let lights = [
        Light::point(Vec3::new(0.5, 0.1, -0.3)),
        Light::spot(Vec3::splat(5.0), Vec3::splat(-1.0), 0.4),
    ];
    let views = lights.iter().flat_map(|light| light_views(0, light, 64, None, &bounds).unwrap());
    views.map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect()
}

#[test]
fn chunks_are_of_what_views_may_see_in_order() {
    let gpu = gpu(TIERS[0]);
    let mut chance = Chance::new(3);
    let groups: Vec<_> = (0..12_000)
        .map(|i| {
            let (center, half) = (chance.vec3(-9.0, 9.0), chance.vec3(0.0, 0.8));
            let count = if i % 7 == 0 { 0 } else { 1 + chance.below(256) as u32 };
            HostGroup { low: center - half, count, high: center + half, least_alpha: 1.0 }
        })
        .collect();
    let (views, first_group) = (views(), 5_u32);
    let of_list = &groups[first_group as usize..11_990];
    let params = CullParams {
        view_count: views.len() as u32,
        group_count: of_list.len() as u32,
        first_group,
        first_caster: 1000,
        first_footprint: 77,
        ..CullParams::default()
    };
    let frustums: Vec<_> = views.iter().map(Frustum::new).collect();
    let mut planes: Vec<_> = frustums.iter().flat_map(Frustum::planes).collect();
    planes.resize(6 * MAX_VIEWS, Vec4::ZERO);
    let entries = views.len() * of_list.len();
    let chunks = gpu.upload(
        "chunks",
        &vec![[POISON; 4]; entries],
        BufferUsages::STORAGE | BufferUsages::COPY_SRC,
    );
    let project = ProjectParams { first_setup: 3, ..ProjectParams::default() };
    let bin = BinParams { run_count: 5, ..BinParams::default() };
    let written = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let of_project = gpu.upload("project", &[project], written);
    let of_bin = gpu.upload("bin", &[bin], written);
    let counts = gpu.storage::<u32>("counts", load::listed_length(entries as u32) as usize);
    let of_params = gpu.upload("params", &[params], BufferUsages::UNIFORM);
    let of_planes = gpu.upload("planes", &planes, BufferUsages::UNIFORM);
    let with_counters = [&[HostGroup::default()], &groups[..]].concat();
    let of_groups = gpu.upload("groups", &with_counters, BufferUsages::STORAGE);
    let resources = Resources::new()
        .with("cull_params", &of_params)
        .with("cull_planes", &of_planes)
        .with("host_groups", &of_groups)
        .with("chunks", &chunks)
        .with("listed_bin_params", &of_bin)
        .with("listed_project_params", &of_project)
        .with("listed_counts", &counts);
    let steps = load::cull(entries as u32);
    // More blocks than one turn of the scan takes.
    assert!(steps[0].1[0] > 256, "{steps:?}");
    for (desc, groups) in steps {
        let kernel = Kernel::new(&gpu.device, desc, gpu.tier, &[], &[]).unwrap();
        run(&gpu, &kernel, &resources, groups[0]);
    }

    let (mut expected, mut next) = (Vec::new(), 77);
    for (view, frustum) in (0..).zip(&frustums) {
        for (g, group) in (first_group..).zip(of_list) {
            let bounds = widened(&Bounds { min: group.low, max: group.high }).unwrap();
            if group.count > 0 && frustum.sees(&bounds) {
                let first_caster = 1000 + g * CHUNK_SIZE;
                let count = group.count;
                expected.push(Chunk { view, first_caster, count, first_footprint: next });
                next += count;
            }
        }
    }
    // Only the counts are replaced.
    let chunk_count = expected.len() as u32;
    assert_eq!(gpu.read::<ProjectParams>(&of_project), [ProjectParams { chunk_count, ..project }]);
    assert_eq!(gpu.read::<BinParams>(&of_bin), [BinParams { footprint_count: next, ..bin }]);
    let chunks: Vec<Chunk> = gpu.read(&chunks);
    assert_eq!(chunks[..expected.len()], expected);
    let rest: &[u32] = bytemuck::cast_slice(&chunks[expected.len()..]);
    assert!(rest.iter().all(|&word| word == POISON));
    // Each view sees some, and no view sees most.
    assert!((0..views.len() as u32).all(|v| expected.iter().any(|chunk| chunk.view == v)));
    assert!(expected.len() * 4 < entries, "{} of {entries}", expected.len());
}
