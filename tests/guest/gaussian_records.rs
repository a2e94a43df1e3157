//! The kernel that loads Gaussians, tested alone against the CPU.
use super::{
    Vec3, Vec4,
    gaussians::{gaussians, materials},
};
use crate::common::{TIERS, gpu};
use gobo::{
    Bounds, Gaussian,
    gpu::{Kernel, Resources},
    records::{
        CasterRecord, GaussianAxes, GaussianLook, GpuMaterial, HostGroup, LoadCounters, LoadParams,
        MAX_MATERIALS,
    },
    stage::load,
    wgpu::BufferUsages,
};

/// A Gaussian in WGSL's layout of `Gaussian`.
fn plain(gaussian: &Gaussian) -> [f32; 16] {
    let Gaussian { center: p, opacity, rotation, sigma: s, material, color: c, id } = *gaussian;
    let ([x, y, z, w], [material, id]) = (rotation.to_array(), [material, id].map(f32::from_bits));
    [p.x, p.y, p.z, opacity, x, y, z, w, s.x, s.y, s.z, material, c.x, c.y, c.z, id]
}

#[test]
fn records_and_boxes_are_those_of_an_upload() {
    let gpu = gpu(TIERS[0]);
    let materials = materials();
    let mut all = gaussians(600, &[0, 1, 2, 4], 11);
    all[300].sigma.y = f32::NAN;
    let looks: Vec<_> = materials.iter().map(GaussianLook::new).collect();
    let padded = |mut looks: Vec<GaussianLook>| {
        looks.resize(MAX_MATERIALS, GaussianLook::default());
        looks
    };
    let mut records = vec![<GpuMaterial as bytemuck::Zeroable>::zeroed(); MAX_MATERIALS];
    for (record, material) in records.iter_mut().zip(&materials) {
        *record = GpuMaterial::new(material, &[]);
    }
    let (first_caster, first_axes, first_record) = (100, 1000, 4096);
    let params = LoadParams {
        capacity: 600,
        group_count: 3,
        first_caster,
        first_axes,
        first_record,
        materials: [[0b10111, 0, 0, 0], [0; 4], [0; 4], [0; 4]],
        ..LoadParams::default()
    };
    let written = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let casters = gpu.upload("casters", &vec![[0xdead_beef_u32; 8]; 2000], written);
    let groups = gpu.storage::<HostGroup>("groups", 4);
    let given: Vec<_> = all.iter().map(plain).collect();
    let buffers = [
        gpu.upload("materials", &records, BufferUsages::UNIFORM),
        gpu.upload("params", &[params], BufferUsages::UNIFORM),
        gpu.upload("looks", &padded(looks), BufferUsages::UNIFORM),
        gpu.upload("given", &given, BufferUsages::STORAGE),
        gpu.upload("counts", &[0_u32], BufferUsages::STORAGE),
    ];
    let resources = Resources::new()
        .with("casters", &casters)
        .with("materials", &buffers[0])
        .with("load_params", &buffers[1])
        .with("gaussian_looks", &buffers[2])
        .with("host_gaussians", &buffers[3])
        .with("host_counts", &buffers[4])
        .with("host_groups", &groups);
    let kernel = Kernel::new(&gpu.device, &load::GAUSSIANS, gpu.tier, &[], &[]).unwrap();
    super::kernels::run(&gpu, &kernel, &resources, 4);

    let found: Vec<[[u32; 4]; 2]> = gpu.read(&casters);
    let read: Vec<HostGroup> = gpu.read(&groups);
    let (counted, groups) = LoadCounters::split(&read);
    for (g, members) in all.chunks(256).enumerate() {
        let usable: Vec<_> = members.iter().filter(|g| g.sigma.is_finite()).collect();
        let mut bounds = Bounds::EMPTY;
        for (i, gaussian) in usable.iter().enumerate() {
            let at = (256 * g + i) as u32;
            let material = &materials[gaussian.material as usize];
            let record =
                CasterRecord::of_gaussian(gaussian, material, first_record + first_axes + at);
            let [place, look] = bytemuck::cast::<_, [[u32; 4]; 2]>(record);
            let [found_place, found_look] = found[(first_caster + at) as usize];
            assert_eq!((found_place[..3].to_vec(), found_look), (place[..3].to_vec(), look));
            // The box of a group may be larger.
            let [radius, loaded] = [place[3], found_place[3]].map(f32::from_bits);
            assert!(loaded >= radius && loaded <= radius * 1.001, "{loaded} {radius}");
            let axes = bytemuck::cast::<_, [[u32; 4]; 2]>(GaussianAxes::new(gaussian));
            let own = found[(first_axes + at) as usize];
            assert_eq!(own[1], axes[1]);
            let turn = |bits: [u32; 4]| Vec4::from_array(bits.map(f32::from_bits));
            assert_eq!(own[0], axes[0], "{} {}", turn(own[0]), turn(axes[0]));
            bounds = bounds.with_sphere(gaussian.center, radius);
        }
        assert_eq!(groups[g].count as usize, usable.len());
        let apart = [bounds.min - groups[g].low, groups[g].high - bounds.max];
        let is_around = |apart: Vec3| apart.min_element() >= 0.0 && apart.max_element() < 1e-2;
        assert!(apart.into_iter().all(is_around), "{apart:?}");
    }
    assert_eq!(counted, LoadCounters { taken: 599, skipped: 1 });
}
