//! Codebooks: few numbers, or few rows of numbers, that stand for many (Lloyd 1982). The same input has the
//! same codebook on every machine: sums are in the order of the input.
use rayon::prelude::*;

/// Rounds of assigning and averaging.
const ROUNDS: usize = 8;

/// Most samples that a codebook of rows is trained by, per entry.
const SAMPLES: usize = 64;

/// 256 numbers in ascending order that stand for `numbers`, which are finite; 0 where there are fewer.
pub(super) fn book_of_numbers(numbers: &[f32]) -> [f32; 256] {
    let mut sorted = numbers.to_vec();
    sorted.par_sort_unstable_by(f32::total_cmp);
    let mut distinct = sorted.clone();
    distinct.dedup();
    if distinct.len() <= 256 {
        distinct.resize(256, distinct.last().copied().unwrap_or_default());
        return distinct.try_into().unwrap_or([0.0; 256]);
    }
    let sums: Vec<f64> = sorted
        .iter()
        .scan(0.0, |sum, &number| {
            *sum += f64::from(number);
            Some(*sum)
        })
        .collect();
    let sum_to = |end: usize| if end == 0 { 0.0 } else { sums[end - 1] };
    let last = distinct.len() - 1;
    let mut book: [f32; 256] = std::array::from_fn(|i| distinct[i * last / 255]);
    for _ in 0..ROUNDS * 4 {
        let middle = |i: usize| f32::midpoint(book[i], book[i + 1]);
        let end = |i: usize| match i {
            255 => sorted.len(),
            _ => sorted.partition_point(|&number| number < middle(i)),
        };
        let mut first = 0;
        let mut next = book;
        for (i, entry) in next.iter_mut().enumerate() {
            let end = end(i);
            if end > first {
                *entry = ((sum_to(end) - sum_to(first)) / (end - first) as f64) as f32;
            }
            first = end;
        }
        book = next;
    }
    // Sums of large numbers may round past each other.
    book.sort_unstable_by(f32::total_cmp);
    book
}

/// Index of the entry of an ascending book that is nearest to a number.
pub(super) fn nearest(book: &[f32; 256], number: f32) -> u8 {
    let above = book.partition_point(|&entry| entry < number).min(255);
    let below = above.saturating_sub(1);
    let is_below = (number - book[below]).abs() <= (number - book[above]).abs();
    (if is_below { below } else { above }) as u8
}

/// Rows that stand for many, and which of them stands for each.
pub(super) struct Palette {
    /// The rows, one after the other.
    pub(super) rows: Vec<f32>,
    pub(super) labels: Vec<u16>,
}

/// At most `most` rows of `width` numbers (a power of 4 up to 65,536) that stand for `rows`: the square root
/// of `most` of all, and as many of those that each of these stands for.
pub(super) fn palette_of(rows: &[f32], width: usize, most: usize) -> Palette {
    let count = rows.len() / width;
    if count <= most {
        return Palette { rows: rows.to_vec(), labels: (0..count).map(|i| i as u16).collect() };
    }
    let side = most.isqrt();
    let all: Vec<u32> = (0..count as u32).collect();
    let coarse = trained(rows, width, &all, side);
    let assigned: Vec<u16> =
        all.par_iter().map(|&i| closest(&coarse, width, row(rows, width, i))).collect();
    let mut members = vec![Vec::new(); side];
    for (i, label) in (0..).zip(assigned) {
        members[usize::from(label)].push(i);
    }
    let fine: Vec<(Vec<f32>, Vec<u16>)> = members
        .par_iter()
        .map(|members| {
            let fine = trained(rows, width, members, side);
            let label = |&i: &u32| closest(&fine, width, row(rows, width, i));
            let labels = members.iter().map(label).collect();
            (fine, labels)
        })
        .collect();
    let (mut palette, mut labels) = (Vec::new(), vec![0; count]);
    for (members, (fine, own)) in members.iter().zip(fine) {
        let first = (palette.len() / width) as u16;
        for (&i, label) in members.iter().zip(own) {
            labels[i as usize] = first + label;
        }
        palette.extend(fine);
    }
    Palette { rows: palette, labels }
}

fn row(rows: &[f32], width: usize, i: u32) -> &[f32] {
    &rows[i as usize * width..][..width]
}

/// At most `most` rows that stand for `members` of all rows.
fn trained(rows: &[f32], width: usize, members: &[u32], most: usize) -> Vec<f32> {
    let spread = |count: usize| {
        let count = count.min(members.len());
        (0..count).map(move |k| members[k * members.len() / count])
    };
    let mut book: Vec<f32> = spread(most).flat_map(|i| row(rows, width, i).to_vec()).collect();
    let samples: Vec<u32> = spread(most * SAMPLES).collect();
    if samples.len() <= most {
        return book;
    }
    for _ in 0..ROUNDS {
        let label = |&i: &u32| closest(&book, width, row(rows, width, i));
        let labels: Vec<u16> = samples.par_iter().map(label).collect();
        let (mut sums, mut counts) = (vec![0.0_f64; book.len()], vec![0_u32; book.len() / width]);
        for (&i, label) in samples.iter().zip(labels) {
            let entry = usize::from(label);
            counts[entry] += 1;
            let sums = &mut sums[entry * width..][..width];
            sums.iter_mut().zip(row(rows, width, i)).for_each(|(sum, x)| *sum += f64::from(*x));
        }
        for (entry, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            for k in entry * width..(entry + 1) * width {
                book[k] = (sums[k] / f64::from(count)) as f32;
            }
        }
    }
    book
}

/// Index of the row of a book that is closest to another row.
fn closest(book: &[f32], width: usize, to: &[f32]) -> u16 {
    let far = |entry: &[f32]| entry.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let all = (0..).zip(book.chunks_exact(width).map(far));
    let least = |a: (u16, f32), b: (u16, f32)| if b.1 < a.1 { b } else { a };
    all.reduce(least).map_or(0, |(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_numbers_are_kept() {
        let book = book_of_numbers(&[3.0, -1.0, 3.0, 0.5]);
        for number in [3.0, -1.0, 0.5] {
            assert_eq!(book[usize::from(nearest(&book, number))], number);
        }
        assert_eq!(book_of_numbers(&[]), [0.0; 256]);
    }

    #[test]
    fn many_numbers_have_near_ones() {
        // Evenly spread: no entry is further than half a step of 256.
        let numbers: Vec<f32> = (0..10_000).map(|i| i as f32 / 10_000.0).collect();
        let book = book_of_numbers(&numbers);
        let far = numbers.iter().map(|&x| (book[usize::from(nearest(&book, x))] - x).abs());
        let far = far.fold(0.0, f32::max);
        assert!(far < 0.6 / 256.0, "{far}");
    }

    #[test]
    fn rows_of_few_kinds_are_kept() {
        // Nine kinds of rows, of which a palette of 16 can have each.
        let of = |i: usize| [(i % 3) as f32, (i / 3 % 3) as f32];
        let rows: Vec<f32> = (0..1000).flat_map(of).collect();
        let Palette { rows: palette, labels } = palette_of(&rows, 2, 16);
        assert!(palette.len() / 2 <= 16, "{palette:?}");
        for (i, &label) in labels.iter().enumerate() {
            assert_eq!(row(&palette, 2, label.into()), of(i), "row {i}");
        }
    }
}
