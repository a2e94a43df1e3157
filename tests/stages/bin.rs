//! The stage bin: from depth order to tiles.
use crate::common::{
    gpu,
    records::{choices_of, read_records, records},
    scenes::{Chance, flat_view},
};
use gobo::{
    glam::{UVec2, Vec2},
    gpu::{Gpu, Resources, Tier},
    records::{GAUSSIAN_TEXELS, GpuView, MAX_VIEWS, OUTLINE_TEXEL, Outline, TileRect},
    stage::{
        bin::{self, BatchCounters, BinParams},
        sort::{PAIR_FORMAT, Partition},
    },
    wgpu::{BufferUsages, TextureFormat::Rgba32Uint},
};
use gobo_reference::{
    Pair,
    bin::{TilePair, bin},
    outline::{Ellipse, outline_of, outlined_tiles},
};

/// Partitions, and tiers whose kernels differ.
const WAYS: [(Partition, Tier); 6] = [
    (Partition::Serial, Tier::Core),
    (Partition::Serial, Tier::Subgroups),
    (Partition::Serial, Tier::Native),
    (Partition::Wide, Tier::Core),
    (Partition::Wide, Tier::Subgroups),
    (Partition::Wide, Tier::Native),
];

fn rect(x0: u32, y0: u32, x1: u32, y1: u32, view: u32) -> TileRect {
    let mut mask = 0;
    for (y, x) in (0..=y1 - y0).flat_map(|y| (0..=x1 - x0).map(move |x| (y, x))) {
        mask |= 1 << (y * 4 + x);
    }
    TileRect { corners: x0 | y0 << 8 | x1 << 16 | y1 << 24, mask_view: mask | view << 16 }
}

/// Two views of 4x4 tiles.
fn views() -> [GpuView; 2] {
    [0, 16].map(|first_tile| flat_view(64, 1.0).to_gpu(first_tile, UVec2::ZERO, 0))
}

#[test]
fn pairs_are_by_tile_and_keep_their_order_within_it() {
    let rects = [rect(0, 0, 1, 1, 0), rect(1, 1, 3, 1, 0), rect(1, 1, 1, 1, 1)];
    let bins = bin(&[1, 2, 0], &rects, |_| None, &views(), 32, 100);
    let pairs: Vec<_> = bins.pairs.iter().map(|p| (p.tile, p.footprint)).collect();
    assert_eq!(pairs, [(0, 0), (1, 0), (4, 0), (5, 1), (5, 0), (6, 1), (7, 1), (21, 2)]);
    assert_eq!(bins.tile(5), [1, 0].map(|footprint| TilePair { tile: 5, footprint }));
    assert_eq!(bins.tile_starts.len(), 33);
    assert!(bins.tile(31).is_empty() && bins.overflowed.is_empty());
}

#[test]
fn what_does_not_fit_emits_nothing_and_is_listed() {
    let rects = [rect(0, 0, 1, 1, 0), rect(1, 1, 3, 1, 0), rect(1, 1, 1, 1, 1)];
    let bins = bin(&[0, 1, 2], &rects, |_| None, &views(), 32, 6);
    assert_eq!(bins.overflowed, [1, 2]);
    assert!(bins.pairs.iter().all(|pair| pair.footprint == 0) && bins.pairs.len() == 4);
    let bins = bin(&[0, 1, 2], &rects, |_| None, &views(), 32, 8);
    assert!(bins.overflowed.is_empty() && bins.pairs.len() == 8);
}

#[test]
fn a_scattered_caster_has_no_tiles() {
    let scattered = TileRect::scattered(3);
    assert!(
        scattered.is_scattered() && scattered.view() == 3 && scattered.tiles(None).count() == 0
    );
    let corner = rect(255, 255, 255, 255, 0);
    assert!(!corner.is_scattered() && corner.tiles(None).eq([(255, 255)]));
    assert!(!TileRect::EMPTY.is_scattered());
}

/// Initial words of pairs and lists, to show words that a kernel does not write.
const POISON: u32 = 0xdead_beef;

/// Footprints of up to 3x3 tiles of either view, some without a tile.
fn scattered_rects(count: u32) -> Vec<TileRect> {
    (0..count)
        .map(|i| {
            let bits = i.wrapping_mul(0x9e37_79b9) >> 8;
            let (x, y, wide, high) = (bits & 1, bits >> 1 & 1, bits >> 2 & 3, bits >> 4 & 3);
            if bits % 7 == 0 {
                return TileRect::EMPTY;
            }
            rect(x, y, x + wide.min(2), y + high.min(2), bits >> 6 & 1)
        })
        .collect()
}

/// Output of `count`, `scan` and `emit`: pairs, overflow, and the counters.
fn emitted(
    gpu: &Gpu,
    (shape, tier): (Partition, Tier),
    sorted: &[u32],
    rects: &[TileRect],
    views: &[GpuView],
    outlines: &[Outline],
    pair_capacity: u32,
) -> (Vec<Pair>, Vec<u32>, BatchCounters) {
    let choices = choices_of(tier);
    let kernel = |desc| gpu.kernels.kernel(&gpu.device, desc, tier, choices, &[]).unwrap();
    let [count, emit] = bin::count_and_emit(shape).map(kernel);
    let scan = kernel(&bin::SCAN);
    let footprint_count = sorted.len() as u32;
    let run_length = bin::run_length(footprint_count);
    let run_count = footprint_count.div_ceil(run_length);
    let offset_count = run_count + run_count.div_ceil(bin::block_runs(shape));
    assert!(offset_count <= bin::max_offsets(shape));
    let params = BinParams {
        footprint_count,
        run_length,
        run_count,
        pair_capacity,
        tile_count: 32,
        view_count: 2,
        segment_length: 1,
        block_runs: bin::block_runs(shape),
        adds_scattered: 0,
    };
    let mut all_views = views.to_vec();
    all_views.resize(MAX_VIEWS, views[0]);
    let poison = Pair { key: POISON, value: POISON };
    let of_pairs = |name, tier, all: &[Pair]| records(gpu, tier, (name, PAIR_FORMAT), all, poison);
    let keys: Vec<_> = sorted.iter().map(|&value| Pair { key: 0, value }).collect();
    let corners: Vec<_> =
        rects.iter().map(|rect| Pair { key: rect.corners, value: rect.mask_view }).collect();
    let keys = of_pairs("sorted", tier, &keys);
    let corners = of_pairs("rects", tier, &corners);
    let pairs = of_pairs("pairs", tier, &vec![poison; pair_capacity as usize]);
    let mut texels = vec![[POISON; 4]; GAUSSIAN_TEXELS as usize * outlines.len()];
    for (outline, setup) in outlines.iter().zip(texels.chunks_exact_mut(GAUSSIAN_TEXELS as usize)) {
        setup[OUTLINE_TEXEL as usize] = bytemuck::cast(*outline);
    }
    let setups = records(gpu, tier, ("setups", Rgba32Uint), &texels, [POISON; 4]);
    let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let params = gpu.upload("bin_params", &[params], BufferUsages::UNIFORM);
    let view_buffer = gpu.upload("views", &all_views, BufferUsages::UNIFORM);
    let runs = gpu.upload("run_offsets", &vec![POISON; offset_count as usize], storage);
    let counters = gpu.upload("counters", &[BatchCounters::default()], storage);
    let dispatches = gpu.upload("dispatches", &[0_u32; 24], storage);
    let overflow = gpu.upload("overflow", &vec![POISON; rects.len()], storage);
    let resources = Resources::new()
        .with("bin_params", &params)
        .with("views", &view_buffer)
        .with("sorted", &keys)
        .with("rects", &corners)
        .with("setups", setups)
        .with("run_offsets", &runs)
        .with("counters", &counters)
        .with("dispatches", &dispatches)
        .with("overflow", &overflow)
        .with("pairs", &pairs);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    let groups = [run_count.div_ceil(bin::block_runs(shape)), 1, 1];
    for (kernel, groups) in [(&count, groups), (&scan, [1; 3]), (&emit, groups)] {
        let bindings = kernel.bind(&gpu.device, &resources).unwrap();
        kernel.record(&mut pass, &bindings, groups);
    }
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    (read_records(gpu, &pairs), gpu.read(&overflow), gpu.read::<BatchCounters>(&counters)[0])
}

/// Compares pairs and overflow of both shapes with the reference's.
fn assert_emitted(rects: &[TileRect], views: &[GpuView], tile_count: u32, capacity: u32) {
    let gpu = gpu(Tier::Native);
    let visible = |&i: &u32| rects[i as usize].mask_view & 0xffff != 0;
    let sorted: Vec<_> = (0..rects.len() as u32).rev().filter(visible).collect();
    let bins = bin(&sorted, rects, |_| None, views, tile_count, capacity);
    for way in WAYS {
        let (pairs, mut overflow, counters) =
            emitted(&gpu, way, &sorted, rects, views, &[], capacity);
        let name = format!("{} footprints, {way:?}", rects.len());
        // A stable sort by tile, like the next stage.
        let mut found: Vec<_> = pairs[..bins.pairs.len()].to_vec();
        found.sort_by_key(|pair| pair.key);
        let cpu = bins.pairs.iter().map(|pair| Pair { key: pair.tile, value: pair.footprint });
        assert!(found.iter().copied().eq(cpu), "{name}");
        let poison = Pair { key: POISON, value: POISON };
        assert!(pairs[bins.pairs.len()..].iter().all(|&pair| pair == poison), "{name}");
        overflow.truncate(counters.overflowed as usize);
        overflow.sort_unstable();
        let mut expected = bins.overflowed.clone();
        expected.sort_unstable();
        assert_eq!(overflow, expected, "{name}");
        assert_eq!(counters.visible as usize, sorted.len(), "{name}");
    }
}

/// Counts that leave lanes and runs unfilled.
#[test]
fn both_shapes_emit_what_the_reference_emits() {
    for (count, capacity) in [(1, 64), (7, 64), (700, 1 << 12), (70_001, 1 << 19), (5000, 9000)] {
        assert_emitted(&scattered_rects(count), &views(), 32, capacity);
    }
}

/// Among footprints of a tile or two, some that cover up to the whole map, and others that no longer fit.
#[test]
fn both_shapes_emit_large_rectangles() {
    let views = [0, 4096].map(|first| flat_view(1024, 1.0).to_gpu(first, UVec2::ZERO, 0));
    let mut chance = Chance::new(5);
    let rects: Vec<_> = (0..20_000)
        .map(|i| {
            let far = |span: u32, chance: &mut Chance| chance.below(span as usize) as u32;
            let span = if i % 100 == 0 { 64 } else { 2 };
            let [x, y] = [0; 2].map(|_| far(64, &mut chance));
            let [wide, high] = [0; 2].map(|_| far(span, &mut chance));
            let (x1, y1, view) = ((x + wide).min(63), (y + high).min(63), far(2, &mut chance));
            if x1 - x < 4 && y1 - y < 4 {
                return rect(x, y, x1, y1, view);
            }
            let corners = x | y << 8 | x1 << 16 | y1 << 24;
            TileRect { corners, mask_view: TileRect::WHOLE | view << 16 }
        })
        .collect();
    for capacity in [1 << 18, 30_000] {
        assert_emitted(&rects, &views, 8192, capacity);
    }
}

/// An ellipse of a map of 1024 x 1024 texels, up to 1000 times as long as wide and longer than the map.
fn ellipse(chance: &mut Chance) -> Ellipse {
    let [x, y] = [0; 2].map(|_| chance.within(-200.0, 1224.0));
    let [wide, high] = [0; 2].map(|_| 2.5 * 1000.0_f32.powf(chance.unit()));
    let aslant = chance.within(-1.0, 1.0).signum() * (1.0 - 0.001_f32.powf(chance.unit()));
    let width = wide * (1.0 - aslant * aslant).sqrt();
    let (middle, half) = (Vec2::new(x, y), Vec2::new(wide, high));
    Ellipse { middle, half, lean: wide * aslant, width, open: 1.0 }
}

/// Count and emit find the same tiles of an outline as the reference, integer by integer.
#[test]
fn both_shapes_emit_the_tiles_of_outlines() {
    let gpu = gpu(Tier::Native);
    let views = [flat_view(1024, 1.0).to_gpu(0, UVec2::ZERO, 0)];
    let mut chance = Chance::new(3);
    let (mut rects, mut outlines) = (Vec::new(), Vec::new());
    for _ in 0..20_000 {
        let ellipse = ellipse(&mut chance);
        let tile = |texels: Vec2| (texels / 16.0).floor().clamp(Vec2::ZERO, Vec2::splat(63.0));
        let lo = tile(ellipse.middle - ellipse.half).as_uvec2();
        let hi = tile(ellipse.middle + ellipse.half).as_uvec2();
        let corners = lo.x | lo.y << 8 | hi.x << 16 | hi.y << 24;
        let outline = outline_of(&ellipse, lo.y).unwrap();
        rects.push(outlined_tiles(&outline, TileRect { corners, mask_view: TileRect::WHOLE }));
        outlines.push(outline);
    }
    let sorted: Vec<u32> = (0..rects.len() as u32).collect();
    let bins = bin(&sorted, &rects, |i| outlines.get(i as usize), &views, 4096, u32::MAX);
    assert!(bins.pairs.len() > 1_000_000, "{}", bins.pairs.len());
    let capacity = bins.pairs.len() as u32;
    for way in WAYS {
        let (mut found, _, counters) =
            emitted(&gpu, way, &sorted, &rects, &views, &outlines, capacity);
        assert_eq!((counters.pair_count, counters.overflowed), (capacity, 0), "{way:?}");
        found.truncate(bins.pairs.len());
        found.sort_by_key(|pair| pair.key);
        let cpu = bins.pairs.iter().map(|pair| Pair { key: pair.tile, value: pair.footprint });
        assert!(found.into_iter().eq(cpu), "{way:?}");
    }
}
