//! Blue noise by void and cluster (Ulichney 1993): a rank per cell of a tile that repeats.
use super::pcg;
use std::sync::OnceLock;

/// Edge of the tile \[cells\].
pub const BLUE_SIZE: u32 = 64;
const COUNT: usize = (BLUE_SIZE * BLUE_SIZE) as usize;
/// Standard deviation of the Gaussian that measures clusters \[cells\].
const SIGMA: f32 = 1.5;
/// Radius where the Gaussian has fallen below 1e-5 \[cells\].
const REACH: i32 = 8;

/// Rank of each cell, row by row: each of 0..4096 once. Made at the first call.
pub fn blue_ranks() -> &'static [u16] {
    static RANKS: OnceLock<Vec<u16>> = OnceLock::new();
    RANKS.get_or_init(void_and_cluster)
}

struct Tile {
    set: Vec<bool>,
    /// Sum of the Gaussians of the set cells, at each cell.
    energy: Vec<f32>,
    kernel: Vec<f32>,
}

impl Tile {
    fn new() -> Self {
        let span = -REACH..=REACH;
        let weight = |x: i32, y: i32| (-((x * x + y * y) as f32) / (2.0 * SIGMA * SIGMA)).exp();
        Self {
            set: vec![false; COUNT],
            energy: vec![0.0; COUNT],
            kernel: span.clone().flat_map(|y| span.clone().map(move |x| weight(x, y))).collect(),
        }
    }

    fn put(&mut self, cell: usize, set: bool) {
        self.set[cell] = set;
        let sign = if set { 1.0 } else { -1.0 };
        let size = BLUE_SIZE as i32;
        let (x, y) = (cell as i32 % size, cell as i32 / size);
        let mut weights = self.kernel.iter();
        for dy in -REACH..=REACH {
            let row = (y + dy).rem_euclid(size) * size;
            for dx in -REACH..=REACH {
                let at = row + (x + dx).rem_euclid(size);
                self.energy[at as usize] += sign * weights.next().expect("a weight per cell");
            }
        }
    }

    /// The tightest cluster among set cells, or the largest void among the others.
    fn extreme(&self, set: bool) -> usize {
        let sign = if set { 1.0 } else { -1.0 };
        let cells = (0..COUNT).filter(|&cell| self.set[cell] == set);
        cells
            .fold((usize::MAX, f32::NEG_INFINITY), |best, cell| {
                let energy = sign * self.energy[cell];
                if energy > best.1 { (cell, energy) } else { best }
            })
            .0
    }
}

fn void_and_cluster() -> Vec<u16> {
    let mut tile = Tile::new();
    let first = COUNT / 10;
    let mut seed = 1;
    for _ in 0..first {
        seed = pcg(seed);
        let free = (0..COUNT).map(|i| (seed as usize + i) % COUNT).find(|&cell| !tile.set[cell]);
        tile.put(free.expect("a tenth of the cells"), true);
    }
    // Moves the tightest cluster to the largest void until it comes back.
    loop {
        let cluster = tile.extreme(true);
        tile.put(cluster, false);
        let void = tile.extreme(false);
        tile.put(void, true);
        if void == cluster {
            break;
        }
    }
    let mut ranks = vec![0; COUNT];
    let start = tile.set.clone();
    for rank in (0..first).rev() {
        let cell = tile.extreme(true);
        tile.put(cell, false);
        ranks[cell] = rank as u16;
    }
    let mut tile = Tile::new();
    for cell in (0..COUNT).filter(|&cell| start[cell]) {
        tile.put(cell, true);
    }
    // Past half the cells, the largest void is also the tightest cluster of empty cells: since the weights
    // add up to a constant, phases two and three of the paper are one.
    for rank in first..COUNT {
        let cell = tile.extreme(false);
        tile.put(cell, true);
        ranks[cell] = rank as u16;
    }
    ranks
}
