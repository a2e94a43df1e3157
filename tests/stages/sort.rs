use crate::common::{
    gpu,
    records::{form_of, read_records, records},
};
use gobo::{
    frame::{Commands, Kernels, Sort, SortCount},
    gpu::{Gpu, Resource, Tier, Timeline},
    model::MAX_PAIRS,
    stage::{
        sort::{PAIR_FORMAT, PAIR_ROW, Partition, digits, pair_limit},
        tuning::Tuning,
    },
    wgpu,
};
use gobo_reference as reference;
use gobo_reference::Pair;
use std::ops::Range;

/// Shapes, and tiers whose kernels differ for them.
const WAYS: [(Partition, Tier); 5] = [
    (Partition::Serial, Tier::Core),
    (Partition::Serial, Tier::Native),
    (Partition::Wide, Tier::Core),
    (Partition::Wide, Tier::Subgroups),
    (Partition::Wide, Tier::Native),
];
const POISON: Pair = Pair { key: 0xdead_beef, value: 0xdead_beef };

/// Keys by a bijective mix of the index (the finalizer of Appleby 2011, `MurmurHash3`).
fn mixed(count: u32) -> Vec<Pair> {
    let mix = |i: u32| {
        let i = (i ^ (i >> 16)).wrapping_mul(0x85eb_ca6b);
        let i = (i ^ (i >> 13)).wrapping_mul(0xc2b2_ae35);
        i ^ (i >> 16)
    };
    (0..count).map(|value| Pair { key: mix(value + 1), value }).collect()
}

fn with_keys(count: u32, key: impl Fn(u32) -> u32) -> Vec<Pair> {
    (0..count).map(|value| Pair { key: key(value), value }).collect()
}

/// The comparison of all tests here: the first difference, or that `tail` was written.
fn compare(found: &[Pair], expected: &[Pair]) -> Result<(), String> {
    let (sorted, tail) = found.split_at(expected.len());
    if let Some(at) = (0..expected.len()).find(|&at| sorted[at] != expected[at]) {
        return Err(format!("pair {at} is {:?}, not {:?}", sorted[at], expected[at]));
    }
    match tail.iter().position(|&pair| pair != POISON) {
        Some(at) => Err(format!("pair {} past the end was written", expected.len() + at)),
        None => Ok(()),
    }
}

fn sorted(pairs: &[Pair], bits: Range<u32>) -> Vec<Pair> {
    let mut pairs = pairs.to_vec();
    reference::sort(&mut pairs, bits);
    pairs
}

/// Two arrays full of poison, except for `pairs` at the start of the first.
fn pair_records(gpu: &Gpu, tier: Tier, pairs: &[Pair], capacity: u32) -> [Resource; 2] {
    let mut first = pairs.to_vec();
    first.resize(pairs.len().max(capacity as usize), POISON);
    let second = vec![POISON; first.len()];
    [("pairs", first), ("sorted_pairs", second)]
        .map(|(name, all)| records(gpu, tier, (name, PAIR_FORMAT), &all, POISON))
}

fn kernels(gpu: &Gpu, (shape, tier): (Partition, Tier)) -> Kernels {
    let record_form = form_of(tier);
    let tuning = Tuning { partition: shape, record_form, ..Tuning::of(&gpu.adapter) };
    Kernels::new(&gpu.device, tier, tuning, gpu.kernels.clone())
}

/// Sorts the first `count` of `pairs`; returns the result and what follows.
fn sort_on(
    gpu: &Gpu,
    way: (Partition, Tier),
    pairs: &[Pair],
    count: SortCount<'_>,
    bits: Range<u32>,
) -> Vec<Pair> {
    let capacity = match count {
        SortCount::Known(capacity) | SortCount::FromBuffer { capacity, .. } => capacity,
    };
    let both = pair_records(gpu, way.1, pairs, capacity);
    let sort = Sort::new(&kernels(gpu, way), both.each_ref(), count, bits).unwrap();
    let result = sort.result();
    let mut commands = Commands::new();
    commands.pass("gobo sort", sort.dispatches);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    commands.record(&mut encoder, &mut Timeline::untimed());
    gpu.queue.submit([encoder.finish()]);
    read_records(gpu, &both[result])
}

fn check(gpu: &Gpu, way: (Partition, Tier), pairs: &[Pair], bits: Range<u32>) {
    let count = SortCount::Known(pairs.len() as u32);
    let found = sort_on(gpu, way, pairs, count, bits.clone());
    compare(&found, &sorted(pairs, bits.clone()))
        .unwrap_or_else(|error| panic!("{} pairs, bits {bits:?}, {way:?}: {error}", pairs.len()));
}

#[test]
fn reference_is_a_stable_sort() {
    for bits in [0..12, 0..24, 0..32, 3..17, 8..8, 20..32] {
        let pairs = with_keys(5000, |i| i.wrapping_mul(0x9e37_79b9) & 0xff0f_f00f);
        let mut expected = pairs.clone();
        expected
            .sort_by_key(|pair| (u64::from(pair.key) & ((1_u64 << bits.end) - 1)) >> bits.start);
        assert_eq!(sorted(&pairs, bits), expected);
    }
}

#[test]
fn digits_are_even_and_cover_the_bits() {
    let of = |bits| digits(bits, 8).collect::<Vec<_>>();
    assert_eq!(of(0..12), [0..6, 6..12]);
    assert_eq!(of(0..24), [0..8, 8..16, 16..24]);
    assert_eq!(of(3..20), [3..8, 8..14, 14..20]);
    assert_eq!(of(0..40), of(0..32));
    assert_eq!(of(5..5), []);
    assert_eq!(digits(0..16, 6).collect::<Vec<_>>(), [0..5, 5..10, 10..16]);
}

#[test]
fn gpu_matches_cpu() {
    let gpu = gpu(Tier::Native);
    for way in WAYS {
        for count in [0, 1, 63, 64, 65, 1000, 600_003] {
            for bits in [0..12, 0..24, 0..32, 5..14] {
                if count > 0 || bits.end == 24 {
                    check(&gpu, way, &mixed(count), bits);
                }
            }
        }
    }
}

#[test]
fn gpu_sort_is_stable_whatever_the_keys() {
    let gpu = gpu(Tier::Native);
    let count = 20_000;
    for way in WAYS {
        check(&gpu, way, &with_keys(count, |_| 7), 0..24);
        check(&gpu, way, &with_keys(count, |i| count - i), 0..32);
        check(&gpu, way, &with_keys(count, |i| i), 0..16);
        check(&gpu, way, &with_keys(count, |i| i % 3 * 0x0101_0101), 0..32);
        check(&gpu, way, &with_keys(count, |_| u32::MAX), 0..32);
    }
}

#[test]
fn a_million_pairs_match() {
    let gpu = gpu(Tier::Native);
    for way in WAYS {
        check(&gpu, way, &mixed(1_300_001), 0..16);
    }
}

#[test]
fn count_may_stay_below_the_capacity() {
    let gpu = gpu(Tier::Native);
    let pairs = mixed(3000);
    let expected = sorted(&pairs, 0..24);
    for way in WAYS {
        for capacity in [3000, 50_000, 2_000_000] {
            let counts = gpu.upload("counts", &[9, 9, 3000], wgpu::BufferUsages::STORAGE);
            let counted = SortCount::FromBuffer { counts: &counts, index: 2, capacity };
            let found = sort_on(&gpu, way, &pairs, counted, 0..24);
            compare(&found, &expected).unwrap();
        }
    }
}

/// The capacity sets the size of dispatches and histograms, but fewer pairs may make more runs: 131,072 make
/// 512 runs of 256, 131,073 make 505 of 260.
#[test]
fn partitions_of_the_capacity_hold_those_of_any_count() {
    let run_length = |count: u32| {
        let usual = count.div_ceil(512).clamp(256, 2048);
        usual.max(count.div_ceil(8192)).next_multiple_of(4)
    };
    let mut last = 0;
    for count in (0..MAX_PAIRS).step_by(61).chain([131_072, 131_073, MAX_PAIRS]) {
        if count == 131_072 {
            last = 0;
        }
        let limit = Partition::Serial.partition_limit(count);
        assert!(limit >= last.max(count.div_ceil(run_length(count))), "{count}");
        assert!(limit <= 8192);
        // At most as wide as a texture with that many rows of pairs is high.
        assert!(Partition::Wide.partition_limit(count) <= count.div_ceil(PAIR_ROW));
        last = limit;
    }
}

/// A count past the capacity: the first `capacity` pairs are sorted, none is written past them.
#[test]
fn count_past_the_capacity_is_the_capacity() {
    let gpu = gpu(Tier::Native);
    let pairs = mixed(3000);
    let expected = sorted(&pairs[..2000], 0..12);
    let counts = gpu.upload("counts", &[u32::MAX], wgpu::BufferUsages::STORAGE);
    for way in WAYS {
        let counted = SortCount::FromBuffer { counts: &counts, index: 0, capacity: 2000 };
        let found = sort_on(&gpu, way, &pairs, counted, 0..12);
        // Two passes: the result is where the pairs were, followed by the unsorted ones.
        assert_eq!(found[2000..3000], pairs[2000..]);
        compare(&found[..2000], &expected).unwrap();
    }
}

#[test]
fn too_many_pairs_are_refused() {
    let gpu = gpu(Tier::Native);
    let [pairs, sorted_pairs] = pair_records(&gpu, WAYS[0].1, &[], 1);
    let kernels = kernels(&gpu, WAYS[0]);
    let limit = pair_limit(&gpu.device);
    let count = SortCount::Known(limit + 1);
    let error = Sort::new(&kernels, [&pairs, &sorted_pairs], count, 0..8).unwrap_err();
    assert!(error.to_string().contains(&(limit + 1).to_string()), "{error}");
}
