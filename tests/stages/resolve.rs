//! From sums to maps, against the formulas in 64 bits: each kernel alone, with handmade sums and poisoned
//! maps.
use super::by_hand::{
    ATLAS, FIXED_ONE, ONE_BITS, Outputs, POISON, Sums, TEXELS, TILES, dispatches, in_form, run,
    texel_of, tile_record, view_buffer,
};
use crate::common::{TIERS, gpu};
use gobo::{
    glam::DVec3,
    gpu::{Gpu, Resource, Resources, Tier},
    stage::{bin::SEGMENT_LENGTH, resolve},
    wgpu::{self, BufferUsages, TextureFormat as Format},
};

/// Resolved tiles, in an order of their own.
const MERGED: [u32; 3] = [6, 1, 4];
const BLACK: f64 = 1.0 / 1024.0;

/// Sums of a texel: zero, faint, half, nearly black, saturated, with nearness of none, some and all depths.
fn sums() -> Vec<[u32; 4]> {
    let tau = |i: u32| [0, 1, 655, 45426, 454_000, 455_000, 458_752, 4_000_000][i as usize % 8];
    let depth = |i: u32| [1.0, 0.25, 1e-6, 0.999, 0.0][i as usize % 5];
    let texel = |i: u32| {
        let nearness = ONE_BITS - f32::to_bits(depth(i));
        [tau(i), tau(i / 8), tau(i / 3), nearness]
    };
    (0..TILES * TEXELS).map(texel).collect()
}

struct Inputs {
    views: wgpu::Buffer,
    tiles: Resource,
    merged: wgpu::Buffer,
    dispatches: wgpu::Buffer,
}

impl Inputs {
    fn new(gpu: &Gpu, tiles: &[[u32; 4]]) -> Self {
        let listed = [&MERGED[..], &[0]].concat();
        Self {
            views: view_buffer(gpu),
            tiles: in_form(gpu, "tiles", Format::Rgba32Uint, tiles),
            merged: gpu.upload("merged_tiles", &listed, BufferUsages::STORAGE),
            dispatches: dispatches(gpu, 2, MERGED.len() as u32),
        }
    }

    fn resources<'a>(&'a self, sums: &'a Sums) -> Resources {
        sums.resources()
            .with("views", &self.views)
            .with("tiles", &self.tiles)
            .with("merged_tiles", &self.merged)
            .with("dispatches", &self.dispatches)
    }
}

/// Every tile has a few pairs in one segment.
fn short_tiles() -> Vec<[u32; 4]> {
    (0..TILES).map(|tile| tile_record(tile, [0, 9], 1)).collect()
}

/// Asserts that each texel's maps equal `expected(tile, texel of the batch)`, and that the sums of resolved
/// tiles are zero.
fn assert_resolved(
    gpu: &Gpu,
    what: &str,
    (outputs, sums_after): (&Outputs, &Sums),
    expected: impl Fn(u32, usize) -> (DVec3, f32),
) {
    let mut written = outputs.read(gpu);
    for tile in MERGED {
        for i in 0..TEXELS {
            let Some(([r, g, b, _], nearest)) = written[texel_of(tile, i).1].take() else {
                panic!("{what}: texel {i} of tile {tile} was not written");
            };
            let (light, depth) = expected(tile, (tile * TEXELS + i) as usize);
            for (found, exact) in [r, g, b].into_iter().zip(light.to_array()) {
                // Half floats are rounded either way.
                let rounding = exact / 1000.0;
                let is_black = found == 0.0 && exact < BLACK * 1.001;
                let is_right = exact > BLACK * 0.999 && (found - exact).abs() <= rounding;
                assert!(
                    is_black || is_right,
                    "{what}: {found} is not {exact}, texel {i} of {tile}"
                );
            }
            assert_eq!(nearest, depth, "{what}: texel {i} of tile {tile}");
        }
    }
    assert_eq!(written.iter().flatten().count(), 0, "{what}: texels of other tiles");
    let mut after = sums();
    for tile in MERGED {
        let first = (tile * TEXELS) as usize;
        after[first..first + TEXELS as usize].fill([0; 4]);
    }
    let found = sums_after.read(gpu);
    assert_eq!(found[..after.len()], after, "{what}: sums");
    assert!(found[after.len()..].iter().all(|words| *words == [POISON; 4]), "{what}: beyond sums");
}

/// Transmittance and nearest depth of a texel's sums.
fn of_sums([red, green, blue, nearness]: [u32; 4]) -> (DVec3, f32) {
    let light = [red, green, blue].map(|sum| (-f64::from(sum) / FIXED_ONE).exp());
    (light.into(), f32::from_bits(ONE_BITS - nearness))
}

#[test]
fn sums_become_transmittances_and_depths() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let inputs = Inputs::new(&gpu, &short_tiles());
        let (outputs, all) = (Outputs::poisoned(&gpu), Sums::new(&gpu, tier, &sums()));
        let resources = inputs
            .resources(&all)
            .with("filters", &outputs.filters)
            .with("nearests", &outputs.nearests);
        run(&gpu, &resolve::TILES, tier, &[], &resources, [2, 2, 1]);
        let what = format!("{tier:?}");
        assert_resolved(&gpu, &what, (&outputs, &all), |_, texel| of_sums(sums()[texel]));
    }
}

/// A segment's transfer to the light: a scale, an addition, and its nearest depth.
struct Partial {
    /// Scale in 65,535ths, as segments store it.
    scale: [u32; 3],
    added: [u32; 3],
    nearest: f32,
}

impl Partial {
    /// A different value for each texel of each segment.
    fn of(at: u32) -> Self {
        let share = |i: u32| (at * 31 + i * 17) % 101 * 648;
        Self {
            scale: [share(0), share(1), 65535],
            added: [0, (65535 - share(1)) / 3, 0],
            nearest: [1.0, 0.4, 0.75][at as usize % 3],
        }
    }

    fn packed(&self) -> [u32; 4] {
        let ([r, g, b], [added_r, added_g, added_b]) = (self.scale, self.added);
        [r | g << 16, b | added_r << 16, added_g | added_b << 16, self.nearest.to_bits()]
    }
}

fn assert_composed(tier: Tier) {
    let gpu = gpu(tier);
    // Segments of the tiles, from the first on: a single one is not composed.
    let counts = |tile: u32| [1, 3, 1, 1, 2, 1, 1, 1][tile as usize];
    let first = |tile: u32| (0..tile).map(counts).sum::<u32>();
    let tiles: Vec<_> = (0..TILES)
        .map(|tile| {
            let pairs = (counts(tile) - 1) * SEGMENT_LENGTH + 5;
            tile_record(tile, [40, 40 + pairs], 1 + first(tile))
        })
        .collect();
    let segments = first(TILES);
    // The second record of a texel is for volumes and owner tags.
    let partials: Vec<_> =
        (0..segments * TEXELS).flat_map(|at| [Partial::of(at).packed(), [POISON; 4]]).collect();
    let inputs = Inputs::new(&gpu, &tiles);
    let (outputs, all) = (Outputs::poisoned(&gpu), Sums::new(&gpu, tier, &sums()));
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let partial_buffer = gpu.upload("partials", &partials, usage);
    let resources = inputs
        .resources(&all)
        .with("partials", &partial_buffer)
        .with("filters", &outputs.filters)
        .with("nearests", &outputs.nearests);
    let flags = [("HAS_VOLUMES", 0.0), ("HAS_OWNERS", 0.0)];
    run(&gpu, &resolve::ORDERED, tier, &flags, &resources, [2, 2, 1]);
    let what = format!("in order, {tier:?}");
    assert_resolved(&gpu, &what, (&outputs, &all), |tile, texel| {
        let (scattered, mut nearest) = of_sums(sums()[texel]);
        let mut light = DVec3::ONE;
        let composed = if counts(tile) > 1 { counts(tile) } else { 0 };
        for segment in first(tile)..first(tile) + composed {
            let at = segment * TEXELS + texel as u32 % TEXELS;
            let partial = Partial::of(at);
            let share = |of: [u32; 3]| DVec3::from(of.map(f64::from)) / 65535.0;
            light = light * share(partial.scale) + share(partial.added);
            nearest = nearest.min(partial.nearest);
        }
        (light * scattered, nearest)
    });
    assert_eq!(gpu.read::<[u32; 4]>(&partial_buffer), partials, "{what}: segments are read only");
}

#[test]
fn segments_are_composed_front_to_back() {
    TIERS.into_iter().for_each(assert_composed);
}

/// Opaque depths are the nearest of the sums alone.
#[test]
fn nearness_becomes_opaque_depths() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let inputs = Inputs::new(&gpu, &short_tiles());
        let all = Sums::new(&gpu, tier, &sums());
        let opaques = gpu.texture_array("opaques", ATLAS, Format::R32Float);
        gpu.write_texture(&opaques, &vec![POISON; ATLAS.iter().product::<u32>() as usize]);
        let small = gpu.upload("small_depths", &[0_u32], BufferUsages::STORAGE);
        let resources =
            inputs.resources(&all).with("small_depths", &small).with("opaques", &opaques);
        run(&gpu, &resolve::OPAQUE, tier, &[], &resources, [4, 1, 1]);
        let mut expected = vec![POISON; ATLAS.iter().product::<u32>() as usize];
        for tile in MERGED {
            for i in 0..TEXELS {
                let nearness = sums()[(tile * TEXELS + i) as usize][3];
                expected[texel_of(tile, i).1] = ONE_BITS - nearness;
            }
        }
        assert_eq!(gpu.read_texture::<u32>(&opaques), expected, "{tier:?}");
    }
}
