//! Grids in the host's textures and buffers give the same maps as uploads of them.
use super::{Bits, ShadowSettings, Vec3, Vec4, particles, shadows, submit, views};
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, nearest_depth},
    tiers,
};
use gobo::{
    Brick, Casters, Error, Grid, HostGrid, HostInputs, Material, Particle, Prepared, Shadows,
    Shape, Transfer,
    glam::{Affine3A, IVec3, Quat, UVec3},
    gpu::{Gpu, Tier},
    host::Input,
    wgpu::{self, BufferUsages, TextureDimension, TextureFormat, TextureUsages},
};
use half::f16;

/// The same voxels are the same half floats; but a ray is measured from the middle of an uploaded grid's
/// bricks, or from that of a host grid's whole extent.
const ROUNDED: f32 = 1e-3;

/// More than one group of bricks, and a multiple of a group along no axis.
const SIZE: UVec3 = UVec3::new(60, 50, 41);

fn volume() -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("smoke"),
        size: wgpu::Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: SIZE.z },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D3,
        format: TextureFormat::R32Float,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    }
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, voxels: &[f32]) {
    let half = texture.format() == TextureFormat::R16Float;
    let bytes: Vec<u8> = if half {
        voxels.iter().flat_map(|&voxel| f16::from_f32(voxel).to_le_bytes()).collect()
    } else {
        bytemuck::cast_slice(voxels).to_vec()
    };
    gpu.queue.write_texture(
        texture.as_image_copy(),
        &bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(SIZE.x * if half { 2 } else { 4 }),
            rows_per_image: Some(SIZE.y),
        },
        texture.size(),
    );
}

fn index(voxel: UVec3) -> usize {
    ((voxel.z * SIZE.y + voxel.y) * SIZE.x + voxel.x) as usize
}

/// Two lumps in an otherwise empty box; `corners`: also a voxel in the first and the last corner.
fn lumps(seed: u64, corners: bool) -> Vec<f32> {
    let mut chance = Chance::new(seed);
    let places = [chance.vec3(0.25, 0.5), chance.vec3(0.5, 0.75)];
    let mut voxels: Vec<f32> = (0..SIZE.element_product())
        .map(|i| {
            let at = UVec3::new(i % SIZE.x, i / SIZE.x % SIZE.y, i / (SIZE.x * SIZE.y)).as_vec3();
            let lump = |place: &Vec3| {
                (1.0 - at.distance(*place * SIZE.as_vec3()) / 11.0).max(0.0)
                    * chance.within(0.5, 1.5)
            };
            places.iter().map(lump).sum()
        })
        .collect();
    if corners {
        voxels[0] = 0.7;
        voxels[index(SIZE - 1)] = 0.9;
    }
    voxels
}

/// A rotated and stretched grid around the origin, without bricks.
fn grid() -> Grid {
    let turn = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(0.3);
    let scale = Vec3::new(0.06, 0.05, 0.07);
    let linear = Affine3A::from_quat(turn) * Affine3A::from_scale(scale);
    Grid {
        world_from_index: linear * Affine3A::from_translation(-0.5 * SIZE.as_vec3()),
        factor: 1.7,
        extinction: Vec3::new(1.0, 0.7, 0.4),
        ..Grid::default()
    }
}

fn uploaded_grid(voxels: &[f32]) -> Grid {
    let last = SIZE.as_ivec3() - 1;
    let bricks = Brick::of_voxels(IVec3::ZERO, last, |voxel| voxels[index(voxel.as_uvec3())]);
    Grid { bricks, ..grid() }
}

fn materials() -> Vec<Material> {
    vec![
        Material { shape: Shape::Brick, ..Material::default() },
        Material { tint: Vec4::new(0.9, 0.7, 0.8, 0.9), ..Material::default() },
        Material { shape: Shape::Brick, transfer: Transfer::None, ..Material::default() },
        Material { shape: Shape::Brick, reflectivity: 0.5, ..Material::default() },
    ]
}

fn discs() -> Vec<Particle> {
    let mut discs = particles(300, 5);
    discs.iter_mut().for_each(|disc| disc.material = 1);
    discs
}

fn uploaded(
    gpu: &Gpu,
    shadows: &mut Shadows,
    particles: &[Particle],
    grids: &[Grid],
    settings: &ShadowSettings,
) -> Bits {
    let materials = materials();
    let casters =
        Casters { particles, grids, materials: &materials, in_order: true, ..Casters::default() };
    submit(gpu, &shadows.prepare(&casters, &views(), settings).unwrap())
}

/// Maps of a host's grids, in addition to the uploaded `particles` and `grids`.
fn on_device(
    shadows: &mut Shadows,
    particles: &[Particle],
    grids: &[Grid],
    of_host: &[HostGrid<'_>],
    settings: &ShadowSettings,
) -> Prepared {
    let materials = materials();
    let casters =
        Casters { particles, grids, materials: &materials, in_order: true, ..Casters::default() };
    let inputs = HostInputs::new().grids(of_host);
    shadows.prepare_with(&casters, &views(), settings, &inputs).unwrap()
}

/// Largest difference of two maps' filters.
fn apart(a: &Bits, b: &Bits) -> f32 {
    let light = |bits: u16| f16::from_bits(bits).to_f32();
    let texels = a.filters.iter().flatten().zip(b.filters.iter().flatten());
    texels.map(|(a, b)| (light(*a) - light(*b)).abs()).fold(0.0, f32::max)
}

fn shade(bits: &Bits) -> usize {
    bits.filters.iter().filter(|texel| texel[1] < 0x3b00).count()
}

#[test]
fn maps_of_textures_equal_those_of_uploads() {
    let (nearest, curve) = (nearest_depth(), ShadowSettings::default());
    for (tier, settings) in TIERS.into_iter().zip([[nearest, curve], [curve, nearest]]) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let own = grid();
        for (format, settings) in
            [TextureFormat::R32Float, TextureFormat::R16Float].into_iter().zip(settings)
        {
            let texture =
                gpu.device.create_texture(&wgpu::TextureDescriptor { format, ..volume() });
            for corners in [true, false] {
                let voxels = lumps(3, corners);
                let all = [uploaded_grid(&voxels)];
                let expected = uploaded(&gpu, &mut shadows, &discs(), &all, &settings);
                write(&gpu, &texture, &voxels);
                let of_host = [HostGrid::new(&texture, &own)];
                let prepared = on_device(&mut shadows, &discs(), &[], &of_host, &settings);
                let found = submit(&gpu, &prepared);
                let apart = apart(&found, &expected);
                let receiver = settings.receiver;
                assert!(apart <= ROUNDED, "{tier} {format:?} {receiver:?} {corners}: {apart}");
                // With the same anchor the bits are the same.
                assert!(!corners || found == expected, "{tier} {format:?} {receiver:?}");
                let counters = prepared.counters().unwrap();
                let bricks = all[0].bricks.len() as u64;
                assert_eq!((counters.casters, counters.skipped.len()), (300 + bricks, 0));
                assert!(shade(&found) > 500 && bricks < 300, "{} {bricks}", shade(&found));
            }
        }
    }
}

/// A host's own bricks of 4^3 voxels, without empty ones.
const POOL: &str = "
@group(1) @binding(0) var<storage, read> table: array<u32>;
@group(1) @binding(1) var<storage, read> pool: array<array<f32, 64>>;

fn load_density(voxel: vec3<u32>) -> f32 {
    let brick = voxel / 4u;
    let entry = table[(brick.z * 13u + brick.y) * 15u + brick.x];
    let own = voxel % 4u;
    if entry == 0u { return 0.0; }
    return pool[entry - 1u][(own.z * 4u + own.y) * 4u + own.x];
}
";

/// Table and pool of voxels.
fn pooled(voxels: &[f32]) -> (Vec<u32>, Vec<[f32; 64]>) {
    let bricks = UVec3::new(15, 13, 11);
    let (mut table, mut pool) = (Vec::new(), Vec::new());
    for i in 0..bricks.element_product() {
        let brick = UVec3::new(i % bricks.x, i / bricks.x % bricks.y, i / (bricks.x * bricks.y));
        let own: [f32; 64] = std::array::from_fn(|i| {
            let i = i as u32;
            let voxel = brick * 4 + UVec3::new(i % 4, i / 4 % 4, i / 16);
            if voxel.cmplt(SIZE).all() { voxels[index(voxel)] } else { 0.0 }
        });
        let is_empty = own == [0.0; 64];
        if !is_empty {
            pool.push(own);
        }
        table.push(if is_empty { 0 } else { pool.len() as u32 });
    }
    (table, pool)
}

/// A texture and a pool of bricks beside an uploaded grid give the same maps as all uploaded.
#[test]
fn bricks_of_a_hosts_own_are_read_by_its_function() {
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let all = [lumps(1, true), lumps(2, true), lumps(3, true)];
        let shifted = |grid: Grid, by: Vec3| Grid {
            world_from_index: Affine3A::from_translation(by) * grid.world_from_index,
            ..grid
        };
        let by = [Vec3::ZERO, Vec3::new(1.0, 0.2, 0.0), Vec3::new(-1.0, 0.3, 0.4)];
        let grids: Vec<Grid> =
            all.iter().zip(by).map(|(all, by)| shifted(uploaded_grid(all), by)).collect();
        let settings = ShadowSettings::default();
        let expected = uploaded(&gpu, &mut shadows, &discs(), &grids, &settings);
        let texture = gpu.device.create_texture(&volume());
        write(&gpu, &texture, &all[1]);
        let (table, pool) = pooled(&all[2]);
        let buffers = [
            gpu.upload("table", &table, BufferUsages::STORAGE),
            gpu.upload("pool", &pool, BufferUsages::STORAGE),
        ];
        let (layout, bindings) = super::bound(&gpu, &buffers);
        let loader = shadows.grid_loader("pool.wgsl", POOL, &layout).unwrap();
        let own = [1, 2].map(|i| shifted(grid(), by[i]));
        let of_host =
            [HostGrid::new(&texture, &own[0]), HostGrid::loaded(&loader, &bindings, SIZE, &own[1])];
        let prepared = on_device(&mut shadows, &discs(), &grids[..1], &of_host, &settings);
        assert!(submit(&gpu, &prepared) == expected, "{tier}");
        // A simulation that alternates between two pools.
        let (table, pool) = pooled(&lumps(4, true));
        let buffers = [
            gpu.upload("table", &table, BufferUsages::STORAGE),
            gpu.upload("pool", &pool, BufferUsages::STORAGE),
        ];
        let (_, other) = super::bound(&gpu, &buffers);
        prepared.rebind_grid(1, &other).unwrap();
        assert!(submit(&gpu, &prepared).filters != expected.filters, "{tier}");
        prepared.rebind_grid(1, &bindings).unwrap();
        assert!(submit(&gpu, &prepared) == expected, "{tier}");
        assert!(
            prepared.rebind_grid(0, &other).is_err() && prepared.rebind_grid(2, &other).is_err()
        );
    }
}

/// Several frames from one `prepare`: smoke appears, changes and vanishes. Then a version keeps the maps.
#[test]
fn frames_follow_the_texture() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let settings = ShadowSettings::default();
    let texture = gpu.device.create_texture(&volume());
    let own = grid();
    let of_host = [HostGrid::new(&texture, &own)];
    let frames = [lumps(1, true), lumps(2, true), vec![0.0; SIZE.element_product() as usize]];
    let expected: Vec<Bits> = frames
        .iter()
        .map(|voxels| uploaded(&gpu, &mut shadows, &[], &[uploaded_grid(voxels)], &settings))
        .collect();
    let prepared = on_device(&mut shadows, &[], &[], &of_host, &settings);
    for (voxels, expected) in frames.iter().zip(&expected) {
        write(&gpu, &texture, voxels);
        assert!(submit(&gpu, &prepared).filters == expected.filters);
    }
    assert_eq!(prepared.counters().unwrap().casters, 0, "nothing is left");
    let of_host = [of_host[0].version(7)];
    let mut rendered = |of_host: &[HostGrid<'_>]| {
        let prepared = on_device(&mut shadows, &[], &[], of_host, &settings);
        submit(&gpu, &prepared);
        prepared.counters().unwrap().views_rendered
    };
    assert_eq!(rendered(&of_host), 8);
    assert_eq!(rendered(&of_host), 0);
    assert_eq!(rendered(&[of_host[0].version(8)]), 8);
}

#[test]
fn densities_out_of_range_are_counted_and_are_none() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let settings = ShadowSettings::default();
    let mut voxels = lumps(4, true);
    let wrong = [f32::NAN, -0.1, f32::INFINITY, f32::NEG_INFINITY, 65600.0, -1e30];
    // On the faces that bricks share, and inside them.
    for (i, wrong) in wrong.into_iter().enumerate() {
        voxels[index(UVec3::new(8 * i as u32, 8 + i as u32, 16))] = wrong;
    }
    let texture = gpu.device.create_texture(&volume());
    write(&gpu, &texture, &voxels);
    let own = grid();
    let of_host = [HostGrid::new(&texture, &own)];
    let prepared = on_device(&mut shadows, &[], &[], &of_host, &settings);
    let found = submit(&gpu, &prepared);
    let skipped: u64 = prepared.counters().unwrap().skipped.values().sum();
    assert_eq!(skipped, wrong.len() as u64);
    for voxel in &mut voxels {
        *voxel = if (0.0..=65504.0).contains(voxel) { *voxel } else { 0.0 };
    }
    assert!(found == uploaded(&gpu, &mut shadows, &[], &[uploaded_grid(&voxels)], &settings));
}

#[test]
fn grids_that_cannot_be_used_are_named() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let texture = |change: &dyn Fn(&mut wgpu::TextureDescriptor<'static>)| {
        let mut desc = volume();
        change(&mut desc);
        gpu.device.create_texture(&desc)
    };
    let good = texture(&|_| {});
    let flat = texture(&|desc| desc.dimension = TextureDimension::D2);
    let whole = texture(&|desc| desc.format = TextureFormat::R32Uint);
    let unbound = texture(&|desc| desc.usage = TextureUsages::COPY_DST);
    let own = grid();
    let with = |material| Grid { material, ..grid() };
    let (none, discs, casts_nothing, mirror) = (with(9), with(1), with(2), with(3));
    let singular = Grid { world_from_index: Affine3A::ZERO, ..grid() };
    let negative = Grid { factor: -1.0, ..grid() };
    let filled = uploaded_grid(&lumps(1, false));
    let (layout, bindings) = super::bound(
        &gpu,
        &[
            gpu.upload("table", &[0_u32], BufferUsages::STORAGE),
            gpu.upload("pool", &[0_u32; 64], BufferUsages::STORAGE),
        ],
    );
    let loader = shadows.grid_loader("pool.wgsl", POOL, &layout).unwrap();
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let mut error = |wrong: HostGrid<'_>| {
        let grids = [HostGrid::new(&good, &own), wrong];
        let inputs = HostInputs::new().grids(&grids);
        let settings = ShadowSettings::default();
        shadows.prepare_with(&casters, &views(), &settings, &inputs).unwrap_err()
    };
    for (wrong, problem) in [
        (HostGrid::new(&flat, &own), "three dimensions"),
        (HostGrid::new(&whole, &own), "format"),
        (HostGrid::new(&unbound, &own), "TEXTURE_BINDING"),
        (HostGrid::loaded(&loader, &bindings, [4, 0, 4], &own), "a voxel along each axis"),
        (HostGrid::new(&good, &none), "not among"),
        (HostGrid::new(&good, &discs), "shape"),
        (HostGrid::new(&good, &casts_nothing), "casts nothing"),
        (HostGrid::new(&good, &mirror), "reflectivity"),
        (HostGrid::new(&good, &singular), "invertible"),
        (HostGrid::new(&good, &negative), "factor"),
        (HostGrid::new(&good, &filled), "bricks must be empty"),
    ] {
        let error = error(wrong);
        let is_named = matches!(error, Error::Invalid { what: Input::HostGrid, index: 1, .. });
        assert!(is_named && error.to_string().contains(problem), "{problem}: {error}");
    }
    for size in [[4096; 3], [u32::MAX; 3]] {
        let error = error(HostGrid::loaded(&loader, &bindings, size, &own));
        assert!(matches!(error, Error::Limit { .. }), "{error}");
    }
    let text = POOL.replace("let own = voxel", "let own = voxels");
    let error = shadows.grid_loader("pool.wgsl", &text, &layout).unwrap_err();
    assert!(error.to_string().contains("pool.wgsl:8:"), "{error}");
    assert!(gpu.check().is_ok());
}
