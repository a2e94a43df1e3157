//! The dispatches of a sort: see [`stage::sort`](crate::stage::sort).
use super::{Dispatch, Kernels};
use crate::{
    error::Error,
    gpu::{Resource, Resources},
    stage::{
        features::Features,
        sort::{SortPass, digits, histogram_size, kernels, pair_limit},
    },
};
use std::ops::Range;
use wgpu::{Buffer, BufferUsages};

/// Source of the number of pairs.
#[derive(Clone, Copy, Debug)]
pub enum SortCount<'a> {
    /// A number known on the CPU.
    Known(u32),
    /// Element `index` of a storage buffer of `u32`. A count past `capacity` is taken as `capacity`.
    FromBuffer {
        /// The buffer.
        counts: &'a Buffer,
        /// Index of the element.
        index: u32,
        /// Most pairs.
        capacity: u32,
    },
}

/// The dispatches of a sort, and its scratch.
#[derive(Debug)]
pub struct Sort {
    /// Two or three for each digit.
    pub dispatches: Vec<Dispatch>,
    digit_passes: usize,
    scratch_size: u64,
}

impl Sort {
    /// Sorts `pairs[0]` by the `bits` of the keys. Textures have
    /// [`PAIR_FORMAT`](crate::stage::sort::PAIR_FORMAT) and
    /// [`pair_texture_size`](crate::stage::sort::pair_texture_size); both are overwritten.
    pub fn new(
        kernels_of: &Kernels,
        pairs: [&Resource; 2],
        count: SortCount<'_>,
        bits: Range<u32>,
    ) -> Result<Self, Error> {
        let (device, partition) = (kernels_of.device(), kernels_of.tuning().partition);
        let (counts, count_index, capacity) = match count {
            SortCount::Known(count) => {
                (kernels_of.filled("counts", &[count], BufferUsages::STORAGE), 0, count)
            }
            SortCount::FromBuffer { counts, index, capacity } => (counts.clone(), index, capacity),
        };
        let limit = pair_limit(device);
        let remedy = "lower the pair budget or the number of casters";
        Error::check_limit("pairs to sort", limit.into(), capacity.into(), remedy)?;
        let partitions = partition.partition_limit(capacity);
        // Few sizes, so that frames with similar numbers share memory.
        let [width, height] = histogram_size(partitions.next_power_of_two());
        let (histograms, is_first) = kernels_of.shared_words("histograms", [width, height]);
        let digit_bits = partition.digit_bits(capacity, bits.clone());
        let (count, scan, scatter) = kernels(partition, digit_bits, partitions);
        let (mut dispatches, mut digit_passes) = (Vec::new(), 0);
        for (at, digit) in digits(bits, digit_bits).enumerate().filter(|_| partitions > 0) {
            let digit_count = 1 << digit.len();
            let pass = SortPass { shift: digit.start, digit_count, capacity, count_index };
            let pass = kernels_of.filled("sort_pass", &[pass], BufferUsages::UNIFORM);
            let resources = Resources::new()
                .with("sort_pass", &pass)
                .with("counts", &counts)
                .with("histograms", &histograms)
                .with("pairs", pairs[at % 2])
                .with("sorted_pairs", pairs[1 - at % 2]);
            let [by_partition, by_digit] =
                [partitions, digit_count].map(|n| [n.div_ceil(partition.lanes()), 1, 1]);
            let scan = scan.map(|scan| (scan, by_digit));
            let last = Some((scatter, by_partition));
            for (desc, groups) in std::iter::once((count, by_partition)).chain(scan).chain(last) {
                dispatches.push(kernels_of.dispatch(desc, Features::NONE, &resources, groups)?);
            }
            digit_passes += 1;
        }
        let scratch_size = if is_first { u64::from(width) * u64::from(height) * 4 } else { 0 };
        Ok(Self { dispatches, digit_passes, scratch_size })
    }

    /// Which of the two holds the sorted pairs.
    pub fn result(&self) -> usize {
        self.digit_passes % 2
    }

    /// Size of the histograms \[bytes\]; 0 if an earlier sort of the frame has them.
    pub fn scratch_size(&self) -> u64 {
        self.scratch_size
    }
}
