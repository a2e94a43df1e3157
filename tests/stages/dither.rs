//! Dither patterns: unbiased, independent, and the same on every device.
use crate::common::scenes::{Chance, flat_view};
use gobo::{
    glam::{UVec2, Vec2},
    model::Pattern,
    records::{BLUE_SIZE, blue_ranks},
};
use gobo_reference::dither::{self, PatternPoint, threshold};

/// Edge of the counted area [cells]: a multiple of every pattern's period.
const EDGE: u32 = 64;

/// Cells of an area for a caster whose own space moves by `step` per texel.
fn points(first: UVec2, edge: u32, step: Vec2) -> impl Iterator<Item = PatternPoint> {
    (0..edge * edge).map(move |i| {
        let cell = first + UVec2::new(i % edge, i / edge);
        PatternPoint { cell, on_caster: cell.as_vec2() * step, step }
    })
}

/// Share of an area that a caster of opacity `a` blocks.
fn covered(pattern: Pattern, a: f32, id: u32, edge: u32) -> f32 {
    let step = Vec2::new(0.031, 0.017);
    let blocks = |point: &PatternPoint| a > threshold(pattern, 1, point, id);
    let count = points(UVec2::splat(EDGE * 1000), edge, step).filter(blocks).count();
    count as f32 / (edge * edge) as f32
}

/// Independent draws in an area: the coarser cells of `hashed` are up to 2.83 texels wide.
fn draws(pattern: Pattern) -> f32 {
    let texels = (EDGE * EDGE) as f32;
    if pattern == Pattern::Hashed { texels / 8.0 } else { texels }
}

const IDS: [u32; 8] = [0, 1, 2, 63, 64, 1000, 77_777, u32::MAX];

#[test]
fn the_covered_share_is_the_opacity() {
    for pattern in Pattern::ALL {
        let (mut sum, mut far, mut count) = (0.0, 0, 0);
        for step in 0..=40 {
            let a = step as f32 / 40.0;
            for id in IDS {
                let error = covered(pattern, a, id, EDGE) - a;
                if let Some(levels) = pattern.levels() {
                    assert!(error.abs() <= 1.0 / levels as f32, "{pattern:?} {a} {id}: {error}");
                }
                let sigma = (a * (1.0 - a) / draws(pattern)).sqrt();
                far += usize::from(pattern.levels().is_none() && error.abs() > 3.0 * sigma);
                sum += error;
                count += 1;
            }
        }
        // 0.27 % of a normal distribution lie beyond 3 sigma.
        assert!(far as f32 <= 0.01 * count as f32, "{pattern:?}: {far} of {count}");
        assert!((sum / count as f32).abs() < 0.01, "{pattern:?}: {}", sum / count as f32);
    }
}

#[test]
fn nothing_and_everything_are_exact() {
    for pattern in Pattern::ALL {
        for id in IDS {
            assert_eq!(covered(pattern, 0.0, id, EDGE), 0.0, "{pattern:?}");
            assert_eq!(covered(pattern, 1.0, id, EDGE), 1.0, "{pattern:?}");
        }
    }
}

/// A mean over many casters, because a single `checkerboard` caster picks a level.
#[test]
fn a_fading_caster_vanishes_without_a_step() {
    for pattern in Pattern::ALL {
        let mean =
            |a: f32| (0..1024).map(|id| covered(pattern, a, id * 97, 16)).sum::<f32>() / 1024.0;
        for a in [0.1, 0.03, 0.01, 0.003, 0.001] {
            let share = mean(a);
            assert!((share - a).abs() <= 0.35 * a + 0.0005, "{pattern:?} {a}: {share}");
        }
    }
}

/// Transmittance of two layers.
fn through(pattern: Pattern, a: [f32; 2], ids: [u32; 2], edge: u32) -> f32 {
    let step = Vec2::new(0.031, 0.017);
    let open = |point: &PatternPoint| (0..2).all(|i| a[i] <= threshold(pattern, 1, point, ids[i]));
    let count = points(UVec2::splat(1 << 20), edge, step).filter(open).count();
    count as f32 / (edge * edge) as f32
}

#[test]
fn two_layers_of_a_half_let_a_quarter_through() {
    let mut chance = Chance::new(5);
    let mut pairs = vec![[0, 1], [0, 63], [0, 64], [3, 67], [5, 5 + 64 * 9], [1 << 20, 1 << 21]];
    pairs.extend((0..60).map(|_| [0; 2].map(|_| chance.below(1 << 30) as u32)));
    for pattern in Pattern::ALL {
        for &ids in &pairs {
            let share = through(pattern, [0.5; 2], ids, 256);
            assert!((share - 0.25).abs() < 0.05, "{pattern:?} {ids:?}: {share}");
            // Different Walsh functions: exact over every 16x16 cells.
            if pattern.levels().is_some() && ids[0] % 64 != ids[1] % 64 {
                assert_eq!(through(pattern, [0.5; 2], ids, 16), 0.25, "{pattern:?} {ids:?}");
            }
            let share = through(pattern, [0.3, 0.8], ids, 256);
            assert!((share - 0.7 * 0.2).abs() < 0.05, "{pattern:?} {ids:?}: {share}");
        }
        // One caster with itself: the check can fail.
        assert!(through(pattern, [0.5; 2], [9, 9], 256) > 0.45);
    }
}

#[test]
fn blue_noise_has_each_rank_once_and_no_clusters() {
    let ranks = blue_ranks();
    let mut sorted = ranks.to_vec();
    sorted.sort_unstable();
    assert!(sorted.iter().copied().eq(0..(BLUE_SIZE * BLUE_SIZE) as u16));
    // At 10% no two neighbours are both set; with independent ones a third of them would be.
    let set = |x: u32, y: u32| {
        ranks[(y % BLUE_SIZE * BLUE_SIZE + x % BLUE_SIZE) as usize] < ranks.len() as u16 / 10
    };
    let cells = || (0..BLUE_SIZE * BLUE_SIZE).map(|i| (i % BLUE_SIZE, i / BLUE_SIZE));
    let crowded = cells().filter(|&(x, y)| set(x, y) && (set(x + 1, y) || set(x, y + 1))).count();
    assert_eq!(crowded, 0);
}

#[test]
fn cells_are_as_large_as_asked() {
    let view = flat_view(64, 8.0).to_gpu(0, UVec2::ZERO, 0);
    let at = |x: f32| dither::cell(&view, 4, Vec2::new(x + 0.5, 0.5)).x;
    assert_eq!(at(0.0), at(3.0));
    assert_eq!(at(4.0), at(0.0) + 1);
}
