//! Twin of `wgsl/accumulate_curve_*.wgsl`: the curves of a tile.
//!
//! In general every hit goes into its texel's curve as it comes. A tile of soft discs may have
//! hundreds of pairs a texel, so its pairs are cut into *slabs* by depth, alike for all texels:
//! what hits a texel in one slab goes in as one ramp from the first of the hits to the last. Only
//! where the next hit fits without a merge does it go in at once; so few hits stay exact.
use super::{PackedNode, Streaming};
use crate::{
    cpu::{
        accumulate::{ScatterSums, VISIBLE_OPACITY},
        caster_hit::{Records, Target},
        resolve,
        tile::{TEXELS, Tile, TileTexels},
    },
    footprint::Footprint,
};
use glam::Vec3;

/// Pairs of a slab, at most.
pub const SLAB_PAIRS: usize = 128;

/// A slab's pairs lie within this share of the depths of their segment: 1 over it. `nodes`: K.
pub const fn slab_count(nodes: u32) -> u32 {
    nodes + nodes / 2
}

/// Opacity below which a hit has no place of its own.
const TRACE: f32 = 1.0 / 65536.0;

/// How a batch's curves are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurveModes {
    /// K
    pub nodes: u32,
    /// Light may grow.
    pub gain: bool,
    /// All casters are soft discs of the `filter` transfer.
    pub slabs: bool,
    /// Pairs of a segment.
    pub segment: usize,
}

/// A texel after its tile was walked.
#[derive(Clone, Debug)]
pub struct CurveTexel {
    pub nodes: Vec<PackedNode>,
    /// Product of the hits.
    pub passed: Vec3,
    /// `D`
    pub nearest: f32,
    pub disordered: u32,
}

/// Hits that have not gone into the curve.
#[derive(Clone, Copy, Debug)]
struct Open {
    start: f32,
    end: f32,
    light: Vec3,
}

impl Open {
    const NONE: Self = Self { start: 2.0, end: 0.0, light: Vec3::ONE };
}

#[derive(Clone, Debug)]
struct Texel {
    curve: Streaming,
    open: Open,
    passed: Vec3,
    nearest: f32,
}

impl Texel {
    fn flush(&mut self) {
        if self.open.start <= 1.0 {
            self.curve.insert(self.open.start, self.open.end, self.open.light);
            self.open = Open::NONE;
        }
    }
}

/// `footprints` with their depth keys: the pairs of tile number `index` of the view, front to back.
pub fn curves(
    records: Records<'_>,
    index: u32,
    footprints: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
    scattered: Option<&ScatterSums>,
    modes: CurveModes,
) -> TileTexels<CurveTexel> {
    let tile = Tile::new(records.view, index);
    let fresh = Texel {
        curve: Streaming::new(modes.nodes, modes.gain),
        open: Open::NONE,
        passed: Vec3::ONE,
        nearest: 1.0,
    };
    let mut texels = TileTexels::filled(fresh.clone());
    if footprints.len() <= modes.segment {
        walk(records, &tile, footprints, opaque, &mut texels, modes);
    } else {
        for segment in footprints.chunks(modes.segment) {
            let mut partial = TileTexels::filled(fresh.clone());
            walk(records, &tile, segment, opaque, &mut partial, modes);
            for place in 0..TEXELS {
                let (texel, partial) = (&mut texels[place], &partial[place]);
                texel.curve.append(partial.curve.pack());
                texel.curve.disordered += partial.curve.disordered;
                texel.passed *= partial.passed;
                texel.nearest = texel.nearest.min(partial.nearest);
            }
        }
    }
    if let Some(sums) = scattered {
        for place in 0..TEXELS {
            let (texel, (tau, nearest)) = (&mut texels[place], sums.texel(index, place));
            let light = resolve::passed(tau);
            if light != Vec3::ONE {
                // Pairs are given room front to back: what has none is behind.
                let depth = if nearest < 1.0 { nearest } else { texel.nearest };
                let depth = depth.max(texel.curve.last_end());
                texel.curve.insert(depth, depth, light);
                texel.passed *= light;
            }
            texel.nearest = texel.nearest.min(nearest);
        }
    }
    let mut done = TileTexels::filled(CurveTexel {
        nodes: Vec::new(),
        passed: Vec3::ONE,
        nearest: 1.0,
        disordered: 0,
    });
    for place in 0..TEXELS {
        let Texel { curve, passed, nearest, .. } = &texels[place];
        let nodes = curve.pack().collect();
        let (passed, nearest, disordered) = (*passed, *nearest, curve.disordered);
        done[place] = CurveTexel { nodes, passed, nearest, disordered };
    }
    done
}

fn walk(
    records: Records<'_>,
    tile: &Tile,
    pairs: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
    texels: &mut TileTexels<Texel>,
    modes: CurveModes,
) {
    let keys = (pairs.first().map_or(0, |p| p.1), pairs.last().map_or(0, |p| p.1));
    let reach = (keys.1 - keys.0) / slab_count(modes.nodes);
    let mut first = 0;
    for (i, &(footprint, key)) in pairs.iter().enumerate() {
        if i - first >= SLAB_PAIRS || key - pairs[first].1 > reach {
            (0..TEXELS).for_each(|place| texels[place].flush());
            first = i;
        }
        let target = Target::new(records, footprint);
        if !target.filters() {
            continue;
        }
        for (place, at) in tile.texels() {
            let Some(hit) = target.hit(at, opaque[place]).filter(|hit| hit.depth < opaque[place])
            else {
                continue;
            };
            let Texel { curve, open, passed, nearest } = &mut texels[place];
            open.light *= hit.light;
            let placed = hit.opacity >= TRACE;
            if placed {
                (open.start, open.end) = (open.start.min(hit.depth), open.end.max(hit.depth));
            }
            *passed *= hit.light;
            if hit.opacity >= VISIBLE_OPACITY {
                *nearest = nearest.min(hit.depth);
            }
            if placed && (curve.is_young() || !modes.slabs) {
                texels[place].flush();
            }
        }
    }
    (0..TEXELS).for_each(|place| texels[place].flush());
}
