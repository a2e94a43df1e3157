//! `accumulate` optimised for this CPU: threads over rows of tiles, vectors of eight texels, the tile's
//! texels in the first-level cache. It walks the lists that the kernel walks.
//!
//! Like the kernel for soft discs it reads 32-byte footprints by their index and decodes them on the fly.
//! Unlike it, it visits only those rows and halves of rows that a disc's box touches, and has no early
//! termination: at opacity 0.02 no texel is saturated before its list ends.
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use gobo::{model::TILE_SIZE, records::Footprint};
use gobo_reference::accumulate::VISIBLE_PRESENCE;
use std::sync::Mutex;

const TILE: usize = TILE_SIZE as usize;
const LANES: usize = 8;
/// Transmittance below which the light is written as 0.
const BLACK: f32 = 1.0 / 1024.0;

/// Output of `bin`: a tile's pairs are `pairs[starts[tile]..starts[tile + 1]]`, front to back.
pub(crate) struct Lists {
    pub(crate) footprints: Vec<Footprint>,
    pub(crate) pairs: Vec<u32>,
    pub(crate) starts: Vec<u32>,
    /// Tiles in a row of the map.
    pub(crate) tiles_x: usize,
}

/// Red, green and blue of F, and D.
pub(crate) type Texel = [f32; 4];

/// A row of 16 texels in registers' order.
#[derive(Clone, Copy)]
struct Row {
    red: [f32; TILE],
    green: [f32; TILE],
    blue: [f32; TILE],
    nearest: [f32; TILE],
}

const EMPTY: Row =
    Row { red: [1.0; TILE], green: [1.0; TILE], blue: [1.0; TILE], nearest: [1.0; TILE] };

/// Fills `map`, row by row of the map.
pub(crate) fn accumulate(level: Level, threads: usize, lists: &Lists, map: &mut [Texel]) {
    let strips = Mutex::new(map.chunks_exact_mut(lists.tiles_x * TILE * TILE).enumerate());
    let work = || {
        loop {
            let next = strips.lock().expect("no thread panics").next();
            let Some((y, strip)) = next else { return };
            dispatch!(level, simd => fill_strip(simd, lists, y, strip));
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
}

#[inline(always)]
fn fill_strip<S: Simd>(simd: S, lists: &Lists, y: usize, strip: &mut [Texel]) {
    let width = lists.tiles_x * TILE;
    for x in 0..lists.tiles_x {
        let tile = y * lists.tiles_x + x;
        let mut rows = [EMPTY; TILE];
        let corner = [(x * TILE) as f32, (y * TILE) as f32];
        for &pair in &lists.pairs[lists.starts[tile] as usize..lists.starts[tile + 1] as usize] {
            visit(simd, &lists.footprints[pair as usize], corner, &mut rows);
        }
        for (row, texels) in rows.iter().zip(strip.chunks_exact_mut(width)) {
            for (i, texel) in texels[x * TILE..][..TILE].iter_mut().enumerate() {
                let light = [row.red[i], row.green[i], row.blue[i]];
                let [red, green, blue] = light.map(|v| if v < BLACK { 0.0 } else { v });
                *texel = [red, green, blue, row.nearest[i]];
            }
        }
    }
}

#[inline(always)]
fn visit<S: Simd>(simd: S, footprint: &Footprint, corner: [f32; 2], rows: &mut [Row; TILE]) {
    let radius = footprint.radius;
    let slope = from_half(footprint.blue_slope >> 16);
    let absorbed = [footprint.red_green, footprint.red_green >> 16, footprint.blue_slope]
        .map(|bits| slope * (1.0 - (bits & 0xffff) as f32 * (1.0 / 65535.0)));
    let bend = 1.0 / (radius * radius);
    let (x, y) = (footprint.center.x - corner[0], footprint.center.y - corner[1]);
    // Texel i has its centre at i + 0.5.
    let first = |at: f32| (at - radius - 0.5).max(0.0) as usize;
    let end = |at: f32| ((at + radius + 0.5).max(0.0) as usize).min(TILE);
    let (x_first, x_end) = (first(x), end(x));
    let touched = rows.get_mut(first(y)..end(y)).unwrap_or_default();
    let mut dy = first(y) as f32 + 0.5 - y;
    let centers = f32x8::simd_from(simd, [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);
    // 1 - (dx / radius)^2
    let along = |half: usize| {
        let dx = centers + ((half * LANES) as f32 - x);
        (dx * dx).mul_add(f32x8::splat(simd, -bend), f32x8::splat(simd, 1.0))
    };
    let disc = Disc {
        absorbed: absorbed.map(|v| f32x8::splat(simd, -v)),
        visible: f32x8::splat(simd, VISIBLE_PRESENCE / slope),
        depth: f32x8::splat(simd, footprint.depth),
    };
    let halves = (along(0), along(1));
    match (x_first < LANES, x_end > LANES) {
        (true, true) => {
            for row in touched {
                let aside = f32x8::splat(simd, dy * dy * bend);
                meet(simd, &disc, halves.0 - aside, row, 0);
                meet(simd, &disc, halves.1 - aside, row, LANES);
                dy += 1.0;
            }
        }
        (left, _) => {
            let (along, at) = if left { (halves.0, 0) } else { (halves.1, LANES) };
            for row in touched {
                meet(simd, &disc, along - f32x8::splat(simd, dy * dy * bend), row, at);
                dy += 1.0;
            }
        }
    }
}

struct Disc<S: Simd> {
    /// Opacity at the centre times (1 - c), negative.
    absorbed: [f32x8<S>; 3],
    /// Least profile of a hit that sets D.
    visible: f32x8<S>,
    depth: f32x8<S>,
}

/// `rest`: 1 - (q / r)^2 of eight texels.
#[inline(always)]
fn meet<S: Simd>(simd: S, disc: &Disc<S>, rest: f32x8<S>, row: &mut Row, at: usize) {
    let rest = rest.max(f32x8::splat(simd, 0.0));
    let profile = rest * rest;
    for (light, absorbed) in
        [&mut row.red, &mut row.green, &mut row.blue].into_iter().zip(disc.absorbed)
    {
        let texels = &mut light[at..at + LANES];
        let passed = f32x8::from_slice(simd, texels);
        (passed * profile).mul_add(absorbed, passed).store_slice(texels);
    }
    let texels = &mut row.nearest[at..at + LANES];
    let nearest = f32x8::from_slice(simd, texels);
    let seen = profile.simd_ge(disc.visible);
    // Not a choice between old and new: compilers make that a masked store, slow on AMD's CPUs.
    nearest.min(seen.select(disc.depth, f32x8::splat(simd, 1.0))).store_slice(texels);
}

/// f32 of a finite non-negative half: a product moves the exponent's bias.
#[inline(always)]
fn from_half(bits: u32) -> f32 {
    f32::from_bits((bits & 0x7fff) << 13) * f32::from_bits(0x7780_0000)
}
