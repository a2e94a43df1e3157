//! From pairs to maps and sums, against products of the formulas in 64 bits: each kernel alone, with handmade
//! inputs and poisoned outputs.
use super::by_hand::{
    ATLAS, FIXED_ONE, ONE_BITS, Outputs, POISON, Sums, TEXELS, TILES, casters, disc, dispatches,
    in_form, pairs, records, run, segments_of, texel_of, tile_records, view_buffer,
};
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, material, particle},
};
use gobo::{
    glam::{DVec3, Vec2, Vec3, Vec4},
    gpu::{Gpu, KernelDesc, Resource, Resources, Tier},
    model::{Profile, Shape, Transfer},
    records::{CasterRecord, Footprint, GpuMaterial, MAX_MATERIALS, TileRect},
    stage::{
        accumulate,
        bin::Segment,
        project::{Chunk, ProjectParams},
    },
    wgpu::{self, BufferUsages, TextureFormat as Format},
};
use std::ops::Range;

/// Pairs of each tile: none, one, and around the sizes of subgroups.
const COUNTS: [u32; TILES as usize] = [1, 0, 7, 9, 8, 65, 33, 300];
/// Tile that other kernels finish.
const MERGED: u32 = 3;
/// Pairs between those of two tiles, belonging to none.
const GAP: u32 = 3;
/// Least opacity of a hit that sets the nearest depth, and the margin in which rounding decides.
const VISIBLE: f64 = 1.0 / 255.0;
const NEAR: f64 = 1e-5;
/// Rounding of products of 300 factors in 32 bits, in the fixed point of sums.
const ROUNDING: f64 = 30.0;
/// Least transmittance of a texel that is not black.
const BLACK: f64 = 1.0 / 1024.0;

/// A disc across tiles that is in no tile: nothing passes it.
fn shade() -> Footprint {
    disc(Vec2::splat(24.0), 1e4, 0.001, Vec3::ZERO, 1.0)
}

/// Footprints front to back, and each tile's run of `pairs`.
struct Batch {
    footprints: Vec<Footprint>,
    pairs: Vec<u32>,
    runs: [Range<u32>; TILES as usize],
    /// `Z` of each texel of the atlas.
    opaques: Vec<f32>,
}

impl Batch {
    /// Discs of at most `opacity`. Those of a tile touch it, or just miss it.
    fn new(opacity: f32, seed: u64) -> Self {
        let mut chance = Chance::new(seed);
        let (mut footprints, mut pairs) = (vec![shade()], Vec::new());
        let runs = [0, 1, 2, 3, 4, 5, 6, 7].map(|tile: usize| {
            pairs.extend([0; GAP as usize]);
            let first = pairs.len() as u32;
            let corner = texel_of(tile as u32, 0).0;
            for i in 0..COUNTS[tile] {
                let center =
                    corner + Vec2::new(chance.within(-9.0, 25.0), chance.within(-9.0, 25.0));
                let color = Vec3::new(chance.unit(), chance.unit(), chance.unit());
                let depth = 0.01 + 0.98 * (i as f32 + chance.unit()) / COUNTS[tile] as f32;
                let radius = chance.within(0.8, 12.0);
                pairs.push(footprints.len() as u32);
                footprints.push(disc(center, radius, depth, color, opacity * chance.unit()));
            }
            first..pairs.len() as u32
        });
        pairs.extend([0; GAP as usize]);
        let opaque = |i: u32| if i.is_multiple_of(5) { 0.3 + (i % 7) as f32 * 0.1 } else { 1.0 };
        let opaques = (0..ATLAS.iter().product::<u32>()).map(opaque).collect();
        Self { footprints, pairs, runs, opaques }
    }

    fn truth(&self, run: Range<u32>, (texel, at): (Vec2, usize)) -> Truth {
        let ids = self.pairs[run.start as usize..run.end as usize].iter();
        Truth::of(ids.map(|&id| &self.footprints[id as usize]), texel, self.opaques[at])
    }
}

/// Expected values of a texel by the formulas.
struct Truth {
    light: DVec3,
    /// `D`, by a threshold slightly above and below the least visible opacity.
    nearest: [f32; 2],
}

impl Truth {
    fn of<'a>(discs: impl Iterator<Item = &'a Footprint>, texel: Vec2, opaque: f32) -> Self {
        let mut truth = Self { light: DVec3::ONE, nearest: [1.0; 2] };
        for disc in discs.filter(|disc| disc.depth < opaque) {
            let (center, radius) = (disc.center.as_dvec2(), f64::from(disc.radius));
            let rest = 1.0 - (texel.as_dvec2() - center).length_squared() / (radius * radius);
            let opacity = f64::from(disc.slope()) * rest.max(0.0).powi(2);
            truth.light *= 1.0 - opacity * (1.0 - disc.color(Transfer::Filter as u32).as_dvec3());
            for (nearest, least) in truth.nearest.iter_mut().zip([VISIBLE - NEAR, VISIBLE + NEAR]) {
                if opacity >= least {
                    *nearest = nearest.min(disc.depth);
                }
            }
        }
        truth
    }

    /// Optical depth in fixed point, at most the largest addend.
    fn tau(&self) -> DVec3 {
        self.light.map(|light| (-light.max(1e-9).ln()).min(7.0) * FIXED_ONE)
    }
}

fn counters(gpu: &Gpu) -> wgpu::Buffer {
    gpu.upload("counters", &[0_u32; 10], BufferUsages::STORAGE | BufferUsages::COPY_SRC)
}

/// Resources that all kernels share.
struct Inputs {
    views: wgpu::Buffer,
    materials: wgpu::Buffer,
    counters: wgpu::Buffer,
    casters: Resource,
    pairs: Resource,
    footprints: Resource,
    setups: Resource,
    textures: Vec<(&'static str, Resource)>,
    opaques: wgpu::Texture,
}

impl Inputs {
    fn new(gpu: &Gpu, batch: &Batch, tiles: &[[u32; 4]]) -> Self {
        let soft = gobo::Material {
            shape: Shape::Disc,
            profile: Profile::Soft,
            ..material(Transfer::Filter)
        };
        let caster = CasterRecord::new(&particle(Vec3::ZERO, 1.0, Vec4::ONE), &soft);
        let vectors = |name, all: &[[u32; 4]]| in_form(gpu, name, Format::Rgba32Uint, all);
        let opaques = gpu.texture_array("opaques", ATLAS, Format::R32Float);
        gpu.write_texture(&opaques, &batch.opaques);
        let images = gpu.texture_array("images", [1, 1, 2], Format::Rgba8Unorm);
        Self {
            views: view_buffer(gpu),
            materials: gpu.upload(
                "materials",
                &vec![GpuMaterial::new(&soft, &[]); MAX_MATERIALS],
                BufferUsages::UNIFORM,
            ),
            counters: counters(gpu),
            casters: casters(gpu, &[caster]),
            pairs: pairs(gpu, &batch.pairs),
            footprints: vectors("footprints", bytemuck::cast_slice(&batch.footprints)),
            setups: vectors("setups", &[]),
            textures: vec![
                ("tiles", vectors("tiles", tiles)),
                ("triangles", (&records::<4>(gpu, "triangles", Format::Rgba32Uint, &[])).into()),
                ("images", (&images).into()),
            ],
            opaques,
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
            .with("counters", &self.counters)
            .with("opaques", &self.opaques);
        self.textures.iter().fold(named, |named, (name, texture)| named.with(name, texture))
    }
}

/// Rounding to a half float, and of products of up to 300 factors.
fn is_close(found: f64, expected: f64) -> bool {
    let rounding = expected / 1024.0 + 1e-4;
    (found - expected).abs() <= rounding || found == 0.0 && expected < BLACK * 1.01
}

fn assert_tiles(tier: Tier, desc: &'static KernelDesc, opacity: f32) {
    let gpu = gpu(tier);
    let batch = Batch::new(opacity, 3);
    let run_of = |tile: u32| batch.runs[tile as usize].clone();
    let tiles = tile_records(&batch.runs, MERGED);
    let inputs = Inputs::new(&gpu, &batch, &tiles);
    let outputs = Outputs::poisoned(&gpu);
    let resources =
        inputs.resources().with("filters", &outputs.filters).with("nearests", &outputs.nearests);
    run(&gpu, desc, tier, &[], &resources, [TILES / 2, 2, 1]);
    let mut written = outputs.read(&gpu);
    let what = format!("{} on {tier:?}", desc.name);
    for tile in (0..TILES).filter(|&tile| tile != MERGED) {
        for i in 0..TEXELS {
            let texel = texel_of(tile, i);
            let truth = batch.truth(run_of(tile), texel);
            let found = written[texel.1].take();
            let Some(([r, g, b, alpha], nearest)) = found else {
                panic!("{what}: texel {i} of tile {tile} was not written");
            };
            let close = [r, g, b].into_iter().zip(truth.light.to_array());
            let is_right = close.into_iter().all(|(found, expected)| is_close(found, expected));
            assert!(is_right, "{what}: {found:?} is not {} in tile {tile}, texel {i}", truth.light);
            assert!(truth.nearest.contains(&nearest), "{what}: {nearest} {:?}", truth.nearest);
            assert!((0.0..=1.0).contains(&alpha), "{what}: {alpha}");
        }
    }
    let outside = written.iter().flatten().count();
    assert_eq!(outside, 0, "{what}: texels of other tiles, or outside the maps");
}

#[test]
fn tiles_hold_the_products_of_their_pairs() {
    for tier in TIERS {
        for desc in [&accumulate::TILES, &accumulate::DISC_TILES] {
            assert_tiles(tier, desc, 0.4);
        }
        // Saturated texels are black, whether or not their walk ends.
        assert_tiles(tier, &accumulate::DISC_TILES, 1.0);
    }
}

/// Sums before a kernel adds to them.
fn earlier() -> Vec<[u32; 4]> {
    (0..TILES * TEXELS).map(|i| [1000 + i % 11, 2000, 0, 5]).collect()
}

/// Checks that discs were added to the sums of the tiles `into`, and that all others are unchanged.
fn assert_sums(
    found: &[[u32; 4]],
    into: &[u32],
    what: &str,
    added: impl Fn(u32, (Vec2, usize)) -> ([DVec3; 2], [f32; 2]),
) {
    let earlier = earlier();
    for (index, found) in found.iter().enumerate() {
        let (tile, i) = (index as u32 / TEXELS, index as u32 % TEXELS);
        if !into.contains(&tile) {
            let before = earlier.get(index).copied().unwrap_or([POISON; 4]);
            assert_eq!(*found, before, "{what}: texel {i} of tile {tile}");
            continue;
        }
        let (bounds, nearest) = added(tile, texel_of(tile, i));
        for channel in 0..3 {
            let grown = f64::from(found[channel]) - f64::from(earlier[index][channel]);
            // A saturated sum stays unchanged.
            let is_full =
                found[channel] >= 7 << 16 && bounds[1][channel] >= 7.0 * FIXED_ONE - 4000.0;
            let is_within = grown >= bounds[0][channel] && grown <= bounds[1][channel];
            assert!(is_within || is_full, "{what}: {grown} in {bounds:?}, texel {i} of {tile}");
        }
        let nearness = nearest.map(|depth| (ONE_BITS - depth.to_bits()).max(5));
        assert!(nearness.contains(&found[3]), "{what}: {} is none of {nearness:?}", found[3]);
    }
}

fn assert_segments(tier: Tier, desc: &'static KernelDesc, opacity: f32) {
    let gpu = gpu(tier);
    let batch = Batch::new(opacity, 4);
    // A whole tile, and a tile in three uneven parts; segments past the count are poison.
    let [whole, cut] = [MERGED, 7].map(|tile: u32| batch.runs[tile as usize].clone());
    let ends = [cut.start, cut.start + 1, cut.start + 131, cut.end];
    let parts = ends.windows(2).map(|pair| (7, pair[0]..pair[1]));
    let parts: Vec<_> = parts.chain([(MERGED, whole)]).collect();
    let mut segments: Vec<_> = parts
        .iter()
        .map(|(tile, pairs)| Segment {
            tile: *tile,
            first: pairs.start,
            end: pairs.end,
            source: u32::from(*tile == 7),
        })
        .collect();
    segments.push(Segment { tile: 0, first: 0, end: 1, source: 0 });
    let inputs = Inputs::new(&gpu, &batch, &[]);
    let segment_buffer = segments_of(&gpu, parts.len(), &segments);
    let sums = Sums::new(&gpu, tier, &earlier());
    let resources = inputs.resources().and(&sums.resources()).with("segments", &segment_buffer);
    run(&gpu, desc, tier, &[], &resources, [3, 2, 1]);
    let what = format!("{} on {tier:?}", desc.name);
    assert_sums(&sums.read(&gpu), &[MERGED, 7], &what, |tile, texel| {
        let truths = parts.iter().filter(|part| part.0 == tile);
        let truths: Vec<_> = truths.map(|part| batch.truth(part.1.clone(), texel)).collect();
        let tau: DVec3 = truths.iter().map(Truth::tau).sum();
        let nearest = [0, 1].map(|i| truths.iter().map(|t| t.nearest[i]).fold(1.0, f32::min));
        ([tau - ROUNDING, tau + ROUNDING], nearest)
    });
}

#[test]
fn segments_add_their_optical_depths() {
    for tier in TIERS {
        for desc in [&accumulate::SEGMENTS, &accumulate::DISC_SEGMENTS] {
            assert_segments(tier, desc, 0.1);
        }
        assert_segments(tier, &accumulate::SEGMENTS, 0.9);
    }
}

/// Bounds of the sums that discs add to a texel, and their nearest depth.
fn scattered(batch: &Batch, discs: Range<usize>, texel: (Vec2, usize)) -> ([DVec3; 2], [f32; 2]) {
    let mut bounds = [DVec3::ZERO; 2];
    let mut nearest = [1.0_f32; 2];
    for disc in &batch.footprints[discs] {
        let truth = Truth::of([disc].into_iter(), texel.0, batch.opaques[texel.1]);
        // Dithered before it is rounded down.
        bounds[0] += (truth.tau() - 0.5).floor().max(DVec3::ZERO);
        bounds[1] += (truth.tau() + 0.5).ceil();
        nearest = [0, 1].map(|i| nearest[i].min(truth.nearest[i]));
    }
    (bounds, nearest)
}

/// Discs of the second view's last tile: tiny ones, or some that did not fit the pair budget.
fn assert_scattered(tier: Tier, tiny: bool) {
    let gpu = gpu(tier);
    let mut batch = Batch::new(0.3, 5);
    let mut chance = Chance::new(6);
    // In the second view; the first footprint is in no chunk and no list.
    let (count, tile) = (37, 7);
    let radius = |chance: &mut Chance| if tiny { 0.8 } else { chance.within(0.8, 12.0) };
    batch.footprints.truncate(1);
    for i in 0..count {
        let center = Vec2::new(chance.within(18.0, 30.0), chance.within(2.0, 14.0));
        let radius = radius(&mut chance);
        let color = Vec3::new(chance.unit(), chance.unit(), chance.unit());
        batch.footprints.push(disc(center, radius, 0.1 + i as f32 * 0.02, color, 0.3));
    }
    let rect = if tiny {
        TileRect::scattered(1)
    } else {
        TileRect { corners: 1 | 1 << 16, mask_view: 1 | 1 << 16 }
    };
    let rects = vec![[rect.corners, rect.mask_view]; count + 1];
    let inputs = Inputs::new(&gpu, &batch, &[]);
    let rects = in_form(&gpu, "rects", Format::Rg32Uint, &rects);
    let sums = Sums::new(&gpu, tier, &earlier());
    let flags = gpu.upload(
        "scattered_tiles",
        &[POISON; TILES as usize],
        BufferUsages::STORAGE | BufferUsages::COPY_SRC,
    );
    let chunk = Chunk { view: 1, first_caster: 0, count: count as u32, first_footprint: 1 };
    let chunks = gpu.upload("chunks", &[chunk], BufferUsages::STORAGE);
    let params = ProjectParams { chunk_count: 1, ..ProjectParams::default() };
    let params = gpu.upload("project_params", &[params], BufferUsages::UNIFORM);
    let mut list: Vec<_> = (1..=count as u32).collect();
    list.push(0);
    let overflow = gpu.upload("overflow", &list, BufferUsages::STORAGE);
    let dispatches = dispatches(&gpu, 0, count as u32);
    let resources = inputs
        .resources()
        .and(&sums.resources())
        .with("rects", rects)
        .with("scattered_tiles", &flags)
        .with("chunks", &chunks)
        .with("project_params", &params)
        .with("overflow", &overflow)
        .with("dispatches", &dispatches);
    let (desc, groups) =
        if tiny { (&accumulate::TINY, [2, 1, 1]) } else { (&accumulate::OVERFLOW, [13, 3, 8]) };
    run(&gpu, desc, tier, &[], &resources, groups);
    let what = format!("{} on {tier:?}", desc.name);
    let all = 1..count + 1;
    assert_sums(&sums.read(&gpu), &[tile], &what, |_, at| scattered(&batch, all.clone(), at));
    let expected = [POISON, POISON, POISON, POISON, POISON, POISON, POISON, 1];
    assert_eq!(gpu.read::<u32>(&flags), expected, "{what}");
    let counted = if tiny { count as u32 } else { 0 };
    assert_eq!(gpu.read::<u32>(&inputs.counters), [0, 0, 0, counted, 0, 0, 0, 0, 0, 0], "{what}");
}

#[test]
fn scattered_casters_add_their_optical_depths() {
    for tier in TIERS {
        assert_scattered(tier, true);
        assert_scattered(tier, false);
    }
}
