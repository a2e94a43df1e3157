//! Opaque depths against the nearest of the hits, each kernel alone, with handmade inputs and poisoned
//! outputs.
use super::{
    blockers::{Batch, Blocker, depths},
    by_hand::{
        ATLAS, ONE_BITS, POISON, Sums, TEXELS, TILES, casters, disc, dispatches, in_form, pairs,
        records, run_all, segments_of, texel_of, tile_records, view_buffer, views,
    },
};
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, material, particle},
};
use gobo::{
    glam::{Vec2, Vec3, Vec4},
    gpu::{Gpu, KernelDesc, Resource, Resources, Tier},
    model::{Material, Profile, Shape, Transfer},
    records::{CasterRecord, Footprint, GpuMaterial, MAX_MATERIALS, TRIANGLE_BIT, TileRect},
    stage::{
        bin::Segment,
        features::{Features, Flags},
        occlude,
        project::{Chunk, ProjectParams},
    },
    wgpu::{self, BufferUsages, TextureFormat as Format},
};
use gobo_reference::project::{self, depth_key, project_triangle};

/// Tile that other kernels finish.
const MERGED: u32 = 3;
/// Rounding of depths, after a few operations in 32 bits.
const DEPTH: f32 = 1e-6;

fn assert_depth(found: u32, expected: &[f32], what: &str) {
    let depth = f32::from_bits(found);
    let is_near = expected.iter().any(|&expected| (depth - expected).abs() <= DEPTH);
    assert!(is_near, "{what}: {depth} is none of {expected:?}");
    assert_eq!(found & 1, 0, "{what}: a depth of a dithered surface");
}

/// Resources that all kernels share.
struct Inputs {
    views: wgpu::Buffer,
    materials: wgpu::Buffer,
    small: wgpu::Buffer,
    casters: Resource,
    pairs: Resource,
    footprints: Resource,
    setups: Resource,
    textures: Vec<(&'static str, Resource)>,
}

impl Inputs {
    fn new(gpu: &Gpu, batch: &Batch, tiles: &[[u32; 4]]) -> Self {
        let solid =
            Material { shape: Shape::Disc, profile: Profile::Flat, ..material(Transfer::Opaque) };
        let params = project::ProjectParams {
            scatter: false,
            include_non_casters: false,
            by_distance: false,
        };
        let (mut footprints, mut setups) = (Vec::<Footprint>::new(), Vec::new());
        for (id, (blocker, &view)) in (0..).zip(batch.blockers.iter().zip(&batch.view_of)) {
            if let &Blocker::Disc { center, radius, depth } = blocker {
                footprints.push(disc(center, radius, depth, Vec3::ONE, 1.0));
                continue;
            }
            let record = blocker.record(view);
            let (mut projected, setup) =
                project_triangle(&views()[view], view as u32, &record, id, id, params);
            // A disc beside the view has no setup, but keeps its place.
            projected.footprint.thin = depth_key(blocker.depth()) << 16;
            projected.footprint.red_green = id;
            projected.footprint.caster = id | TRIANGLE_BIT;
            footprints.push(projected.footprint);
            setups.push(setup);
        }
        let caster = CasterRecord::new(&particle(Vec3::ZERO, 1.0, Vec4::ONE), &solid);
        let images = gpu.texture_array("images", [1, 1, 2], Format::Rgba8Unorm);
        let vectors = |name, all: &[[u32; 4]]| in_form(gpu, name, Format::Rgba32Uint, all);
        Self {
            views: view_buffer(gpu),
            materials: gpu.upload(
                "materials",
                &vec![GpuMaterial::new(&solid, &[]); MAX_MATERIALS],
                BufferUsages::UNIFORM,
            ),
            small: gpu.upload("small_depths", &[0_u32], BufferUsages::STORAGE),
            casters: casters(gpu, &[caster]),
            pairs: pairs(gpu, &batch.pairs),
            footprints: vectors("footprints", bytemuck::cast_slice(&footprints)),
            setups: vectors("setups", bytemuck::cast_slice(&setups)),
            textures: vec![
                ("tiles", vectors("tiles", tiles)),
                ("triangles", (&records::<4>(gpu, "triangles", Format::Rgba32Uint, &[])).into()),
                ("images", (&images).into()),
            ],
        }
    }

    fn resources(&self) -> Resources {
        let named = Resources::new()
            .with("views", &self.views)
            .with("materials", &self.materials)
            .with("casters", &self.casters)
            .with("pairs", &self.pairs)
            .with("footprints", &self.footprints)
            .with("setups", &self.setups)
            .with("small_depths", &self.small);
        self.textures.iter().fold(named, |named, (name, texture)| named.with(name, texture))
    }
}

fn run(gpu: &Gpu, tier: Tier, desc: &'static KernelDesc, named: &Resources, groups: [u32; 3]) {
    let kinds = Flags::HAS_PARTICLES
        | Flags::HAS_FACING
        | Flags::HAS_TRIANGLES
        | Flags::NOT_PLAIN
        | Flags::NOT_SOLID;
    let features = Features::NONE.with(kinds, true);
    run_all(gpu, tier, &features.constants(), named, &[(desc, groups)]);
}

fn assert_tiles(tier: Tier, desc: &'static KernelDesc, triangles: bool) {
    let gpu = gpu(tier);
    let batch = Batch::new(triangles, 3);
    let run_of = |tile: u32| batch.runs[tile as usize].clone();
    let tiles = tile_records(&batch.runs, MERGED);
    let inputs = Inputs::new(&gpu, &batch, &tiles);
    let opaques = gpu.texture_array("opaques", ATLAS, Format::R32Float);
    gpu.write_texture(&opaques, &vec![POISON; ATLAS.iter().product::<u32>() as usize]);
    let resources = inputs.resources().with("opaques", &opaques);
    run(&gpu, tier, desc, &resources, [TILES / 2, 2, 1]);
    let mut written: Vec<u32> = gpu.read_texture(&opaques);
    let kind = if triangles { "triangles" } else { "discs" };
    let what = format!("{} of {kind} on {tier:?}", desc.name);
    let mut blocked = 0;
    for tile in (0..TILES).filter(|&tile| tile != MERGED) {
        for i in 0..TEXELS {
            let (texel, at) = texel_of(tile, i);
            let found = std::mem::replace(&mut written[at], POISON);
            assert_ne!(found, POISON, "{what}: texel {i} of tile {tile} was not written");
            let expected = depths(batch.of(run_of(tile)), texel);
            assert_depth(found, &expected, &format!("{what}: texel {i} of tile {tile}"));
            blocked += u32::from(found < ONE_BITS);
        }
    }
    assert!(blocked > TEXELS, "{what}: {blocked} texels are blocked");
    let outside = written.iter().filter(|&&word| word != POISON).count();
    assert_eq!(outside, 0, "{what}: texels of other tiles, or outside the maps");
}

#[test]
fn tiles_hold_the_nearest_of_their_pairs() {
    for tier in TIERS {
        assert_tiles(tier, &occlude::TILES, false);
        assert_tiles(tier, &occlude::TILES, true);
        assert_tiles(tier, &occlude::TRIANGLE_TILES, true);
    }
}

/// Sums before a kernel changes them.
fn earlier() -> Vec<[u32; 4]> {
    (0..TILES * TEXELS).map(|i| [1000 + i % 11, 2000, 0, 5]).collect()
}

/// Asserts that only the nearness of the tiles `into` grew, to that of `blockers(tile)`.
fn assert_nearness<'a, B: Iterator<Item = &'a Blocker>>(
    found: &[[u32; 4]],
    into: &[u32],
    what: &str,
    blockers: impl Fn(u32) -> B,
) {
    let earlier = earlier();
    for (index, found) in found.iter().enumerate() {
        let (tile, i) = (index as u32 / TEXELS, index as u32 % TEXELS);
        let what = format!("{what}: texel {i} of tile {tile}");
        let before = earlier.get(index).copied().unwrap_or([POISON; 4]);
        assert_eq!(found[..3], before[..3], "{what}");
        if !into.contains(&tile) || found[3] == 5 {
            assert_eq!(found[3], before[3], "{what}");
        }
        if into.contains(&tile) {
            let expected = depths(blockers(tile), texel_of(tile, i).0);
            let depth = if found[3] == 5 { ONE_BITS } else { ONE_BITS - found[3] };
            assert_depth(depth, &expected, &what);
        }
    }
}

#[test]
fn segments_raise_the_nearness_of_their_tiles() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let batch = Batch::new(false, 4);
        // A whole tile, and a tile in three uneven parts; segments past the count are in no tile's sums.
        let [whole, cut] = [MERGED, 7].map(|tile: u32| batch.runs[tile as usize].clone());
        let ends = [cut.start, cut.start + 1, cut.start + 71, cut.end];
        let parts = ends.windows(2).map(|pair| (7, pair[0]..pair[1]));
        let mut segments: Vec<_> = parts
            .chain([(MERGED, whole)])
            .map(|(tile, pairs)| Segment {
                tile,
                first: pairs.start,
                end: pairs.end,
                source: u32::from(tile == 7),
            })
            .collect();
        let count = segments.len();
        segments.push(Segment { tile: 0, first: 0, end: 1, source: 0 });
        let inputs = Inputs::new(&gpu, &batch, &[]);
        let segments = segments_of(&gpu, count, &segments);
        let sums = Sums::new(&gpu, tier, &earlier());
        let resources = inputs.resources().and(&sums.resources()).with("segments", &segments);
        run(&gpu, tier, &occlude::SEGMENTS, &resources, [3, 2, 1]);
        let of_tile = |tile: u32| batch.of(batch.runs[tile as usize].clone());
        assert_nearness(&sums.read(&gpu), &[MERGED, 7], &format!("{tier:?}"), of_tile);
    }
}

/// Discs that did not fit the pair budget, listed for the last tile of the second view.
#[test]
fn overflow_raises_the_nearness_of_its_rectangle() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let mut batch = Batch::new(false, 5);
        let (mut chance, count) = (Chance::new(6), 21);
        batch.blockers.truncate(1);
        for i in 0..count {
            let center = Vec2::new(chance.within(10.0, 34.0), chance.within(-3.0, 19.0));
            let (radius, depth) = (chance.within(0.8, 5.0), 0.9 - 0.04 * i as f32);
            batch.blockers.push(Blocker::Disc { center, radius, depth });
        }
        batch.view_of = vec![1; count + 1];
        let rect = TileRect { corners: 1 | 1 << 16, mask_view: 1 | 1 << 16 };
        let inputs = Inputs::new(&gpu, &batch, &[]);
        let rects = vec![[rect.corners, rect.mask_view]; count + 1];
        let rects = in_form(&gpu, "rects", Format::Rg32Uint, &rects);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let flags = gpu.upload("scattered_tiles", &[POISON; TILES as usize], usage);
        // The first footprint, which is in front of everything, is listed past the count.
        let list: Vec<_> = (1..=count as u32).chain([0]).collect();
        let overflow = gpu.upload("overflow", &list, BufferUsages::STORAGE);
        let dispatches = dispatches(&gpu, 0, count as u32);
        let sums = Sums::new(&gpu, tier, &earlier());
        let resources = inputs
            .resources()
            .and(&sums.resources())
            .with("rects", rects)
            .with("scattered_tiles", &flags)
            .with("overflow", &overflow)
            .with("dispatches", &dispatches);
        run(&gpu, tier, &occlude::OVERFLOW, &resources, [8, 3, 8]);
        let all = |_| batch.blockers[1..].iter();
        assert_nearness(&sums.read(&gpu), &[7], &format!("{tier:?}"), all);
        let expected = [POISON, POISON, POISON, POISON, POISON, POISON, POISON, 1];
        assert_eq!(gpu.read::<u32>(&flags), expected, "{tier:?}");
    }
}

/// Triangles of a few texels lower the depths of their own texels, in their own view.
#[test]
fn small_triangles_write_their_texels_alone() {
    let tier = Tier::Core;
    let gpu = gpu(tier);
    let (mut chance, count, first) = (Chance::new(8), 90, 2);
    let mut batch = Batch::new(true, 5);
    // Those before and after the chunk cover the whole view.
    batch.blockers.truncate(1);
    let wall = batch.blockers[0];
    batch.blockers.push(wall);
    for i in 0..count {
        let center = Vec2::new(chance.within(-1.0, 33.0), chance.within(-1.0, 17.0));
        let corners = [0; 3].map(|_| center + 5.0 * chance.vec3(-0.5, 0.5).truncate());
        batch.blockers.push(Blocker::Triangle { corners, depth: 0.95 - 0.01 * i as f32 });
    }
    batch.blockers.push(wall);
    let triangles: Vec<_> = batch.blockers.iter().map(|blocker| blocker.record(1)).collect();
    let triangles =
        records::<4>(&gpu, "triangles", Format::Rgba32Uint, bytemuck::cast_slice(&triangles));
    let chunk = Chunk { view: 1, first_caster: first, count, first_footprint: 0 };
    let chunks = gpu.upload("chunks", &[chunk, chunk], BufferUsages::STORAGE);
    let params = ProjectParams { chunk_count: 1, ..ProjectParams::default() };
    let params = gpu.upload("project_params", &[params], BufferUsages::UNIFORM);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let small = gpu.upload("small_depths", &[POISON; (TILES * TEXELS + 64) as usize], usage);
    let views = view_buffer(&gpu);
    let resources = Resources::new()
        .with("views", &views)
        .with("triangles", &triangles)
        .with("chunks", &chunks)
        .with("project_params", &params)
        .with("small_depths", &small);
    run(&gpu, tier, &occlude::SMALL, &resources, [2, 1, 1]);
    let found: Vec<u32> = gpu.read(&small);
    let own = &batch.blockers[first as usize..(first + count) as usize];
    // Row by row over the view's two tiles, after the six tiles of the first view.
    let (start, width) = ((6 * TEXELS) as usize, 32);
    let mut written = 0;
    for (index, &word) in found.iter().enumerate() {
        let in_view = index.checked_sub(start).filter(|&i| i < 2 * TEXELS as usize);
        let texel = in_view.map(|i| Vec2::new((i % width) as f32, (i / width) as f32) + 0.5);
        let expected = texel.map_or(vec![1.0], |texel| depths(own.iter(), texel));
        // A texel that no triangle covers keeps its word.
        if word == POISON {
            assert!(expected.contains(&1.0), "texel {index} was not written: {expected:?}");
        } else {
            assert_depth(word, &expected, &format!("texel {index}"));
            assert!(word < ONE_BITS, "texel {index}");
            written += 1;
        }
    }
    assert!(written > 100, "{written}");
}
