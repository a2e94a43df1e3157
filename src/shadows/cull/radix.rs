//! Stable radix sort of keys with values, for the order of casters.
/// A key and its value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Keyed {
    pub(super) key: u32,
    pub(super) value: u32,
}

const DIGIT_BITS: u32 = 8;
const DIGIT_COUNT: usize = 4;

/// Sorts by key; equal keys stay in order. Least significant digit first: all digits are counted in one
/// pass, and a digit that all keys share is skipped.
pub(super) fn radix_sort(mut items: Vec<Keyed>) -> Vec<Keyed> {
    let digit_of = |item: Keyed, digit: usize| item.key.to_le_bytes()[digit] as usize;
    let mut histograms = [[0_u32; 1 << DIGIT_BITS]; DIGIT_COUNT];
    for &item in &items {
        for (digit, histogram) in histograms.iter_mut().enumerate() {
            histogram[digit_of(item, digit)] += 1;
        }
    }
    let mut sorted = vec![Keyed::default(); items.len()];
    for (digit, histogram) in histograms.iter_mut().enumerate() {
        if histogram.iter().any(|&count| count as usize == items.len()) {
            continue;
        }
        let mut place = 0;
        for count in histogram.iter_mut() {
            place += std::mem::replace(count, place);
        }
        for &item in &items {
            let place = &mut histogram[digit_of(item, digit)];
            sorted[*place as usize] = item;
            *place += 1;
        }
        std::mem::swap(&mut items, &mut sorted);
    }
    items
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_in_order_and_equal_ones_as_they_were() {
        for bits in [4, 12, 32] {
            let key = |value: u32| value.wrapping_mul(0x9e37_79b9) >> (32 - bits);
            let items: Vec<_> = (0..3000).map(|value| Keyed { key: key(value), value }).collect();
            let mut expected = items.clone();
            expected.sort_by_key(|item| item.key);
            assert_eq!(radix_sort(items), expected, "{bits} bits");
        }
        assert_eq!(radix_sort(Vec::new()), []);
    }
}
