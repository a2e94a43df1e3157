//! bin by buckets: each tile's pairs in the order of stable sorts, and how few dispatches a frame has.
use crate::common::{
    gpu,
    records::{choices_of, read_records, records},
    scenes::{Chance, flat_view},
    shadows,
};
use gobo::{
    Bounds, Counters, Light, Particle, ShadowSettings,
    glam::{UVec2, Vec3},
    gpu::{Gpu, Resources, Tier},
    light_views,
    model::{Casters, Material},
    records::{GpuView, MAX_VIEWS, TileRect},
    stage::{
        bin::{self, BatchCounters, BinParams, Segment, WIDE_DISC_SEGMENT},
        buckets::{self, BUCKET_LANES, BUCKET_PAIRS},
        sort::{PAIR_FORMAT, Partition},
    },
    wgpu::{self, BufferUsages, TextureFormat::Rgba32Uint},
};
use gobo_reference::{Pair, bin::bin};

const TILES: u32 = 32;
const SEGMENT: u32 = 600;

/// Footprints in up to 3 x 3 tiles of two views of 4 x 4, and most of `crowd` in one.
fn rects(count: u32, crowd: u32, chance: &mut Chance) -> Vec<TileRect> {
    let mut below = |span: usize| chance.below(span) as u32;
    let one = |i| {
        if below(7) == 0 {
            return TileRect::EMPTY;
        }
        if i < crowd {
            return TileRect { corners: 0x0302_0302, mask_view: 1 | 1 << 16 };
        }
        let [x, y, wide, high] = [below(2), below(2), below(3), below(3)];
        let mut mask = 0;
        for (row, column) in (0..=high).flat_map(|row| (0..=wide).map(move |column| (row, column)))
        {
            mask |= 1 << (row * 4 + column);
        }
        let corners = x | y << 8 | (x + wide) << 16 | (y + high) << 24;
        TileRect { corners, mask_view: mask | below(2) << 16 }
    };
    (0..count).map(one).collect()
}

struct Found {
    pairs: Vec<Pair>,
    /// First and last pair of each tile, and whether it has segments.
    tiles: Vec<[u32; 3]>,
    segments: Vec<Segment>,
    counters: BatchCounters,
}

fn binned(gpu: &Gpu, tier: Tier, keys: &[Pair], rects: &[TileRect], views: &[GpuView]) -> Found {
    let footprint_count = rects.len() as u32;
    let room = 10 * rects.len().max(1);
    let params = BinParams::new(Partition::Wide, footprint_count, room as u32, TILES, 2, SEGMENT);
    let mut all_views = views.to_vec();
    all_views.resize(MAX_VIEWS, views[0]);
    let none = Pair { key: 0, value: 0 };
    let of_pairs = |name, tier, all: &[Pair]| records(gpu, tier, (name, PAIR_FORMAT), all, none);
    let corners: Vec<_> =
        rects.iter().map(|rect| Pair { key: rect.corners, value: rect.mask_view }).collect();
    let pairs = of_pairs("pairs", tier, &vec![none; room]);
    let tiles = records(gpu, tier, ("tiles", Rgba32Uint), &[[0_u32; 4]; TILES as usize], [0; 4]);
    let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let words = |label, count: usize| gpu.upload(label, &vec![0_u32; count], storage);
    let counters = gpu.upload("counters", &[BatchCounters::default()], storage);
    let segments = gpu.upload("segments", &vec![Segment::default(); 1 + room], storage);
    // No footprint is a Gaussian with an outline.
    let setups = records(gpu, tier, ("setups", Rgba32Uint), &[[0; 4]], [0; 4]);
    let resources = Resources::new()
        .with("setups", setups)
        .with("bin_params", &gpu.upload("bin_params", &[params], BufferUsages::UNIFORM))
        .with("views", &gpu.upload("views", &all_views, BufferUsages::UNIFORM))
        .with("keys", of_pairs("keys", tier, keys))
        .with("rects", of_pairs("rects", tier, &corners))
        .with("counters", &counters)
        .with("dispatches", &words("dispatches", 4 * bin::DispatchEntry::COUNT as usize))
        .with("scattered_tiles", &words("scattered_tiles", TILES as usize))
        .with("merged_tiles", &words("merged_tiles", TILES as usize))
        .with("tile_cursors", &words("tile_cursors", TILES as usize))
        .with("bucketed", &words("bucketed", 4 * room))
        .with("segments", &segments)
        .with("tiles", &tiles)
        .with("pairs", &pairs);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    let footprints = [footprint_count.div_ceil(BUCKET_LANES), 1, 1];
    for (desc, groups) in [
        (&buckets::COUNT, footprints),
        (&buckets::PLACE, [TILES.div_ceil(BUCKET_LANES), 1, 1]),
        (&buckets::EMIT, footprints),
        (&buckets::SORT, bin::tile_grid(TILES)),
    ] {
        let kernel = gpu.kernels.kernel(&gpu.device, desc, tier, choices_of(tier), &[]).unwrap();
        let bindings = kernel.bind(&gpu.device, &resources).unwrap();
        kernel.record(&mut pass, &bindings, groups);
    }
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let texels: Vec<[u32; 4]> = read_records(gpu, &tiles);
    Found {
        pairs: read_records(gpu, &pairs),
        tiles: texels[..TILES as usize]
            .iter()
            .map(|&[first, end, merged, _]| [first, end, merged])
            .collect(),
        segments: gpu.read(&segments).split_off(1),
        counters: gpu.read::<BatchCounters>(&counters)[0],
    }
}

/// Few pairs a tile, a chunk's and one more, and several chunks; equal keys keep the order of the footprints.
#[test]
fn buckets_are_what_the_reference_bins() {
    let gpu = gpu(Tier::Native);
    let views = [0, 16].map(|first_tile| flat_view(64, 1.0).to_gpu(first_tile, UVec2::ZERO, 0));
    let mut chance = Chance::new(11);
    for (count, crowd, depths) in
        [(1, 0, 9), (5, 0, 2), (300, 0, 65_535), (1500, 1200, 40), (7001, 6500, 500)]
    {
        let rects = rects(count, crowd, &mut chance);
        let keys: Vec<_> =
            (0..count).map(|value| Pair { key: chance.below(depths) as u32, value }).collect();
        let visible = |&i: &u32| rects[i as usize].mask_view & 0xffff != 0;
        let mut sorted: Vec<_> = (0..count).filter(visible).collect();
        sorted.sort_by_key(|&i| keys[i as usize].key);
        let bins = bin(&sorted, &rects, |_| None, &views, TILES, u32::MAX);
        for &tier in Tier::ALL {
            let name = format!("{count} footprints, {tier:?}");
            let found = binned(&gpu, tier, &keys, &rects, &views);
            let mut segments = 0;
            for (tile, &[first, end, merged]) in found.tiles.iter().enumerate() {
                let expected = bins.tile(tile);
                let pairs = found.pairs[first as usize..end as usize].iter();
                let is_same = |(pair, expected): (&Pair, &gobo_reference::bin::TilePair)| {
                    (pair.key, pair.value) == (expected.tile, expected.footprint)
                };
                assert_eq!(pairs.len(), expected.len(), "{name}, tile {tile}");
                assert!(pairs.zip(expected).all(is_same), "{name}, tile {tile}");
                let needed = (end - first).div_ceil(SEGMENT);
                assert_eq!(merged > 0, needed > 1, "{name}, tile {tile}");
                if merged > 0 {
                    let of_tile = &found.segments[merged as usize - 1..][..needed as usize];
                    for (i, segment) in (1..).zip(of_tile) {
                        let flags = u32::from(i == 1) | (u32::from(i == needed) << 1);
                        assert_eq!(segment.source, (tile as u32 / 16) | (flags << 8), "{name}");
                    }
                    let ends = of_tile.iter().map(|segment| segment.end).collect::<Vec<_>>();
                    assert_eq!((of_tile[0].first, ends[ends.len() - 1]), (first, end), "{name}");
                    segments += needed;
                }
            }
            let BatchCounters { pairs_needed, pair_count, visible, segment_count, .. } =
                found.counters;
            let expected = (bins.pairs.len() as u32, sorted.len() as u32, segments);
            assert_eq!((pairs_needed, visible, segment_count), expected, "{name}");
            assert_eq!(pair_count, pairs_needed, "{name}");
        }
    }
}

/// Dispatches of a frame of soft discs, `diameter` texels wide, over one map of 1024 x 1024, as on a GPU.
/// `was_counted`: whether a frame before this one told what it needed.
fn dispatches(tier: Tier, count: u32, diameter: f32, was_counted: bool) -> usize {
    let gpu = gpu(tier);
    let mut shadows = shadows(&gpu);
    shadows.configure(|config| {
        config.tuning.partition = Partition::Wide;
        config.tuning.bucket_pairs = BUCKET_PAIRS;
        config.tuning.disc_segment = WIDE_DISC_SEGMENT;
        (config.toggles.scatter_tiny, config.toggles.queued) = (true, false);
    });
    let mut chance = Chance::new(7);
    let particles: Vec<_> = (0..count)
        .map(|id| {
            let radius = diameter * chance.within(0.75, 1.25) / 1024.0;
            Particle { id, ..Particle::new(chance.vec3(-1.0, 1.0).to_array(), radius) }
        })
        .collect();
    let materials = [Material::default()];
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let bounds = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let light = Light::directional(Vec3::NEG_Y);
    let settings = ShadowSettings { size: 1024, ..ShadowSettings::default() };
    let views = light_views(0, &light, 1024, None, &bounds).unwrap();
    if was_counted {
        // Four pairs a caster.
        let (casters, pairs_needed) = (u64::from(count), 4 * count);
        let pair_capacity = pairs_needed;
        shadows.grow_from(&Counters {
            casters,
            pairs_needed,
            pair_capacity,
            ..Counters::default()
        });
    }
    let prepared =
        shadows.prepare_uncompiled(&casters, &views, &settings, &Default::default()).unwrap();
    prepared.commands().dispatch_count()
}

/// A dispatch that waits for the one before costs two to seven microseconds on an H100. A first frame knows
/// nothing of its pairs, and records the parts that they may need.
#[test]
fn few_dispatches_render_a_frame() {
    // Most of a first frame, and of those after it.
    let cases = [(10_000, 6.0, [10, 10]), (100_000, 16.0, [17, 10]), (1_000_000, 16.0, [44, 20])];
    let of_tier = |&tier: &Tier| {
        cases.map(|(count, diameter, _)| {
            [false, true].map(|was_counted| dispatches(tier, count, diameter, was_counted))
        })
    };
    let found: Vec<_> = Tier::ALL.iter().map(of_tier).collect();
    for of_tier in &found {
        let most = cases.iter().flat_map(|(.., most)| most);
        let is_few = of_tier.as_flattened().iter().zip(most).all(|(found, most)| found <= most);
        assert!(is_few, "{found:?}");
    }
}
