//! From casters to footprints, keys and tile rectangles.
use crate::common::{
    TIERS, gpu,
    records::{choices_of, read_records, records},
    scenes::{Chance, empty, light, material, particle, triangle},
};
use gobo::{
    glam::{UVec2, Vec3, Vec4},
    gpu::{Gpu, KernelDesc, Resources, Tier},
    model::{LightKind, Material, Scene, Shape, Transfer},
    records::{
        CasterRecord, Footprint, GpuMaterial, GpuView, MAX_MATERIALS, MAX_VIEWS, TileRect,
        TriangleRecord, TriangleSetup,
    },
    stage::{
        project::{CHUNK_SIZE, Chunk, PARTICLES, ProjectParams, TRIANGLES, grid},
        sort::PAIR_FORMAT,
    },
    view::shadow_views,
    wgpu::{BufferUsages, TextureFormat::Rgba32Uint},
};
use gobo_reference::{
    Pair,
    project::{self as cpu, Projected, project_caster, project_triangle},
};

/// Initial words of every output, to show words that a kernel does not write.
const POISON: u32 = 0xdead_beef;
/// Footprints between two chunks, belonging to none.
const GAP: u32 = 5;
/// Relative rounding of positions and radii in f32; for texels of a map of 128.
const ROUNDING: f32 = 2e-5;
/// Lanes, chunks and a single remaining caster.
const COUNTS: [u32; 4] = [1, 255, 257, 1003];

/// A sun, a spot and the six faces of a point light among the casters.
fn lit(materials: Vec<Material>) -> Scene {
    let mut scene = empty(materials);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3) }),
        light(LightKind::Spot {
            position: Vec3::new(2.0, 3.0, 1.0),
            direction: Vec3::new(-0.5, -1.0, -0.2),
            angle: 1.2,
        }),
        light(LightKind::Point { position: Vec3::new(0.1, 0.2, 0.1) }),
    ];
    scene.shadow.size = 128;
    scene
}

fn materials() -> Vec<Material> {
    let shaped = |transfer, shape| Material { shape, ..material(transfer) };
    vec![
        shaped(Transfer::Filter, Shape::Disc),
        shaped(Transfer::Smoke, Shape::Quad),
        shaped(Transfer::Stain, Shape::Puff),
        Material { reflectivity: 0.3, ..shaped(Transfer::Gain, Shape::Disc) },
        shaped(Transfer::None, Shape::Disc),
        shaped(Transfer::Opaque, Shape::Disc),
    ]
}

/// Radii from a hundredth of a texel to half of the scene.
fn radius(chance: &mut Chance) -> f32 {
    0.5 * chance.within(-10.0, 0.0).exp()
}

fn views_of(scene: &Scene) -> Vec<GpuView> {
    let mut first_tile = 0;
    let views = shadow_views(scene);
    let gpu = views.iter().map(|view| {
        let gpu = view.to_gpu(first_tile, UVec2::ZERO, 0);
        first_tile += view.tiles().element_product();
        gpu
    });
    gpu.collect()
}

/// Chunks of all casters in every view, with gaps between them, and the number of footprints.
fn chunks(count: u32, views: u32) -> (Vec<Chunk>, u32) {
    let mut chunks = Vec::new();
    let mut next = GAP;
    for view in 0..views {
        for first_caster in (0..count).step_by(CHUNK_SIZE as usize) {
            let count = (count - first_caster).min(CHUNK_SIZE);
            chunks.push(Chunk { view, first_caster, count, first_footprint: next });
            next += count + GAP;
        }
    }
    (chunks, next)
}

/// Output of the kernel, with poison in the gaps.
#[derive(Debug, PartialEq)]
struct Written {
    keys: Vec<Pair>,
    rects: Vec<Pair>,
    footprints: Vec<[u32; 8]>,
    setups: Vec<[u32; 32]>,
}

struct Input<'a> {
    views: &'a [GpuView],
    materials: &'a [GpuMaterial],
    chunks: &'a [Chunk],
    footprint_count: u32,
    params: ProjectParams,
}

/// Written by every form of a kernel.
fn project<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    desc: &'static KernelDesc,
    casters: (&'static str, &[T]),
    input: &Input<'_>,
) -> Written {
    let [core, native] = TIERS.map(|tier| project_on(gpu, tier, desc, casters, input));
    assert_eq!(core, native, "{}", desc.name);
    core
}

fn project_on<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    tier: Tier,
    desc: &'static KernelDesc,
    (name, casters): (&'static str, &[T]),
    input: &Input<'_>,
) -> Written {
    let kernel = gpu.kernels.kernel(&gpu.device, desc, tier, choices_of(tier), &[]).unwrap();
    let texels: &[[u32; 4]] = bytemuck::cast_slice(casters);
    let form_of = |name| if name == "triangles" { Tier::Core } else { tier };
    let casters = records(gpu, form_of(name), (name, Rgba32Uint), texels, [0; 4]);
    let poison = vec![[POISON; 2]; input.footprint_count as usize];
    let pairs = |name, tier| records(gpu, tier, (name, PAIR_FORMAT), &poison, [POISON; 2]);
    let (keys, rects) = (pairs("keys", tier), pairs("rects", tier));
    let poison = vec![[POISON; 8]; input.footprint_count as usize];
    let footprints = records(gpu, tier, ("footprints", Rgba32Uint), &poison, [POISON; 8]);
    let poison = vec![[POISON; 32]; input.footprint_count as usize];
    let setups = records(gpu, tier, ("setups", Rgba32Uint), &poison, [POISON; 32]);
    let mut views = input.views.to_vec();
    views.resize(MAX_VIEWS, input.views[0]);
    let mut materials = input.materials.to_vec();
    materials.resize(MAX_MATERIALS, input.materials[0]);
    let views = gpu.upload("views", &views, BufferUsages::UNIFORM);
    let materials = gpu.upload("materials", &materials, BufferUsages::UNIFORM);
    let params = gpu.upload("project_params", &[input.params], BufferUsages::UNIFORM);
    let chunks = gpu.upload("chunks", input.chunks, BufferUsages::STORAGE);
    let resources = Resources::new()
        .with(name, casters)
        .with("views", &views)
        .with("materials", &materials)
        .with("project_params", &params)
        .with("chunks", &chunks)
        .with("keys", &keys)
        .with("rects", &rects)
        .with("footprints", &footprints)
        .with("setups", &setups);
    let bindings = kernel.bind(&gpu.device, &resources).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    kernel.record(&mut pass, &bindings, grid(input.chunks.len() as u32));
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    Written {
        keys: read_records(gpu, &keys),
        rects: read_records(gpu, &rects),
        footprints: read_records(gpu, &footprints),
        setups: read_records(gpu, &setups),
    }
}

/// Footprints of one run, counted by kind.
#[derive(Debug, Default)]
struct Compared {
    visible: u32,
    scattered: u32,
    /// Keys one unit off: the depth is rounded across a unit.
    rounded: u32,
}

impl Written {
    fn assert_untouched(&self, chunks: &[Chunk], what: &str) {
        let mut owned = vec![false; self.keys.len()];
        for chunk in chunks {
            let first = chunk.first_footprint as usize;
            owned[first..first + chunk.count as usize].fill(true);
        }
        for (index, _) in owned.iter().enumerate().filter(|(_, owned)| !**owned) {
            let poison = Pair { key: POISON, value: POISON };
            assert_eq!([self.keys[index], self.rects[index]], [poison; 2], "{what}: {index}");
            if let Some(footprint) = self.footprints.get(index) {
                assert_eq!(footprint, &[POISON; 8], "{what}: footprint {index}");
            }
        }
    }

    fn compare(&self, index: usize, expected: &Projected, what: &str, all: &mut Compared) {
        let (key, rect) = (self.keys[index], self.rects[index]);
        let rect = TileRect { corners: rect.key, mask_view: rect.value };
        assert_eq!(key.value, index as u32, "{what}: the key's footprint");
        all.visible += u32::from(expected.rect.mask_view & 0xffff != 0);
        all.scattered += u32::from(expected.rect.is_scattered());
        all.rounded += u32::from(key.key != expected.key);
        assert!(key.key.abs_diff(expected.key) <= 1, "{what}: {key:?} is not {}", expected.key);
        assert_eq!(rect, expected.rect, "{what}");
        if expected.rect == TileRect::EMPTY {
            return;
        }
        let found: Footprint = bytemuck::cast(self.footprints[index]);
        let cpu = &expected.footprint;
        let near = |a: f32, b: f32| (a - b).abs() <= ROUNDING * (1.0 + a.abs().max(b.abs()));
        let places = [
            (found.center.x, cpu.center.x),
            (found.center.y, cpu.center.y),
            (found.radius, cpu.radius),
            (found.depth, cpu.depth),
        ];
        assert!(places.iter().all(|&(a, b)| near(a, b)), "{what}: {found:?} is not {cpu:?}");
        // Packed half floats round either way.
        let halves = |word: u32| [word & 0xffff, word >> 16];
        let packed = [(found.red_green, cpu.red_green), (found.blue_slope, cpu.blue_slope)];
        for (a, b) in packed.into_iter().chain([(found.thin & 0xffff, cpu.thin & 0xffff)]) {
            let apart = halves(a).into_iter().zip(halves(b)).map(|(a, b)| a.abs_diff(b));
            assert!(apart.max() <= Some(1), "{what}: {found:?} is not {cpu:?}");
        }
        assert_eq!(found.caster, cpu.caster, "{what}");
    }
}

#[test]
fn particles_are_projected_as_the_reference_does() {
    let gpu = gpu(Tier::Native);
    let scene = lit(materials());
    let views = views_of(&scene);
    let materials: Vec<_> = scene.materials.iter().map(|m| GpuMaterial::new(m, &[])).collect();
    let mut chance = Chance::new(7);
    for (i, count) in COUNTS.into_iter().enumerate() {
        let flag = |bit: usize| u32::from(i >> bit & 1 == 1);
        let params = ProjectParams {
            scatter: flag(0),
            include_non_casters: flag(1),
            by_distance: 1 - flag(0),
            ..ProjectParams::default()
        };
        let reference_params = cpu::ProjectParams {
            scatter: params.scatter == 1,
            include_non_casters: params.include_non_casters == 1,
            by_distance: params.by_distance == 1,
        };
        let casters: Vec<_> = (0..count)
            .map(|id| {
                let at = chance.vec3(-2.0, 2.0);
                let color = Vec4::new(chance.unit(), chance.unit(), chance.unit(), chance.unit());
                let material = chance.below(scene.materials.len());
                let mut particle = particle(at, radius(&mut chance), color);
                (particle.material, particle.id) = (material as u32, id);
                CasterRecord::new(&particle, &scene.materials[material])
            })
            .collect();
        let (chunks, footprint_count) = chunks(count, views.len() as u32);
        let params = ProjectParams { chunk_count: chunks.len() as u32, ..params };
        let (views, materials) = (&views, &materials);
        let input = Input { views, materials, chunks: &chunks, footprint_count, params };
        let written = project(&gpu, &PARTICLES, ("casters", &casters), &input);
        let mut all = Compared::default();
        for chunk in &chunks {
            for lane in 0..chunk.count {
                let id = chunk.first_caster + lane;
                let caster = &casters[id as usize];
                let material = &materials[caster.material() as usize];
                let view = &views[chunk.view as usize];
                let expected = project_caster(
                    view,
                    chunk.view,
                    (caster, id),
                    material,
                    None,
                    reference_params,
                );
                let what = format!("particle {id} of {count} in view {}", chunk.view);
                let index = (chunk.first_footprint + lane) as usize;
                written.compare(index, &expected, &what, &mut all);
            }
        }
        written.assert_untouched(&chunks, &format!("{count} particles"));
        assert!(all.rounded * 200 <= footprint_count, "{count}: {all:?}");
        assert!(count == 1 || 4 * all.visible > count, "{count}: {all:?}");
        assert!(count == 1 || (all.scattered > 0) == reference_params.scatter, "{count}: {all:?}");
    }
}

#[test]
fn triangles_are_projected_as_the_reference_does() {
    let gpu = gpu(Tier::Native);
    let scene = lit(materials());
    let views = views_of(&scene);
    let materials: Vec<_> = scene.materials.iter().map(|m| GpuMaterial::new(m, &[])).collect();
    let mut chance = Chance::new(8);
    for count in COUNTS {
        let by_distance = count % 2;
        let reference_params = cpu::ProjectParams {
            scatter: false,
            include_non_casters: false,
            by_distance: by_distance == 1,
        };
        let records: Vec<_> = (0..count)
            .map(|id| {
                let (at, size) = (chance.vec3(-2.0, 2.0), radius(&mut chance));
                let positions = [(); 3].map(|()| at + chance.vec3(-size, size));
                let mut triangle = triangle(positions, 0);
                triangle.id = id;
                TriangleRecord::new(&triangle)
            })
            .collect();
        let (chunks, footprint_count) = chunks(count, views.len() as u32);
        let params = ProjectParams {
            chunk_count: chunks.len() as u32,
            by_distance,
            ..ProjectParams::default()
        };
        let (views, materials) = (&views, &materials);
        let input = Input { views, materials, chunks: &chunks, footprint_count, params };
        let written = project(&gpu, &TRIANGLES, ("triangles", &records), &input);
        let mut all = Compared::default();
        for chunk in &chunks {
            for lane in 0..chunk.count {
                let id = chunk.first_caster + lane;
                let index = chunk.first_footprint + lane;
                let view = &views[chunk.view as usize];
                let (expected, setup) = project_triangle(
                    view,
                    chunk.view,
                    &records[id as usize],
                    id,
                    index,
                    reference_params,
                );
                let what = format!("triangle {id} of {count} in view {}", chunk.view);
                let index = index as usize;
                written.compare(index, &expected, &what, &mut all);
                if expected.rect != TileRect::EMPTY {
                    assert_setup(&bytemuck::cast(written.setups[index]), &setup, &what);
                }
            }
        }
        written.assert_untouched(&chunks, &format!("{count} triangles"));
        assert!(all.rounded * 200 <= footprint_count, "{count}: {all:?}");
        assert!(count == 1 || 4 * all.visible > count, "{count}: {all:?}");
    }
}

fn assert_setup(found: &TriangleSetup, cpu: &TriangleSetup, what: &str) {
    let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * (1.0 + a.abs().max(b.abs()));
    for (a, b) in found.edges.iter().zip(&cpu.edges) {
        let same = a.to_array().into_iter().zip(b.to_array()).all(|(a, b)| near(a, b));
        assert!(same, "{what}: {found:?} is not {cpu:?}");
    }
    let depths = found.depths.to_array().into_iter().zip(cpu.depths.to_array());
    assert!(depths.into_iter().all(|(a, b)| near(a, b)), "{what}: {found:?} is not {cpu:?}");
    assert_eq!((found.material, found.id), (cpu.material, cpu.id), "{what}");
    assert_eq!(found.uvs, cpu.uvs, "{what}");
    assert_eq!(found.ties, cpu.ties, "{what}");
}
