//! A radix sort optimised for one thread of this CPU.
use gobo_reference::Pair;

/// Sorts by the low `bits` of the keys: stable, least significant digit first, eight bits at a time. All
/// digits are counted in one pass. `scratch` is as long as `pairs`.
pub(crate) fn sort(pairs: &mut Vec<Pair>, scratch: &mut Vec<Pair>, bits: u32) {
    match bits.div_ceil(8) {
        2 => sort_digits::<2>(pairs, scratch),
        3 => sort_digits::<3>(pairs, scratch),
        4 => sort_digits::<4>(pairs, scratch),
        other => unreachable!("{other} digits"),
    }
}

fn sort_digits<const DIGITS: usize>(pairs: &mut Vec<Pair>, scratch: &mut Vec<Pair>) {
    let digit_of = |pair: Pair, digit: usize| (pair.key >> (8 * digit)) as usize & 255;
    let mut places = [[0_u32; 256]; DIGITS];
    for &pair in &*pairs {
        for (digit, counts) in places.iter_mut().enumerate() {
            counts[digit_of(pair, digit)] += 1;
        }
    }
    for (digit, places) in places.iter_mut().enumerate() {
        let mut next = 0;
        for place in places.iter_mut() {
            next += std::mem::replace(place, next);
        }
        for &pair in &*pairs {
            let place = &mut places[digit_of(pair, digit)];
            scratch[*place as usize] = pair;
            *place += 1;
        }
        std::mem::swap(pairs, scratch);
    }
}
