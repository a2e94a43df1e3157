//! Twin of `wgsl/driver/accumulate_curve_*.wgsl`: the curves of a tile.
//!
//! In general every hit goes into its texel's curve as it comes. A tile of soft discs may have
//! hundreds of pairs a texel, so its pairs are cut into *slabs* by depth, alike for all texels:
//! what hits a texel in one slab goes in as one ramp from the first of the hits to the last. Only of
//! a texel with few hits does one that fits without a merge go in at once; so few hits stay exact.
use super::{
    Affine, PackedNode, Streaming,
    volumes::{Inside, Ramp},
};
use crate::{
    records::Footprint,
    reference::{
        accumulate::VISIBLE_OPACITY,
        caster_hit::{Hit, Records, Target},
        order::HitOrder,
        resolve,
        scatter::ScatterSums,
        tile::{TEXELS, Tile, TileTexels},
    },
};
use glam::{IVec3, Vec3};

/// Pairs of a slab, at most.
pub const SLAB_PAIRS: usize = 128;

/// Hits of a segment with which a texel still takes them one by one until its curve is full.
pub const fn max_exact_hits(nodes: u32) -> u32 {
    2 * nodes
}

/// A slab's pairs lie within this share of the depths of their segment: 1 over it. `nodes`: K.
pub const fn slab_count(nodes: u32) -> u32 {
    nodes + nodes / 2
}

/// Opacity below which a hit has no place of its own.
pub const TRACE: f32 = 1.0 / 65536.0;

/// Rounding of light between sums in fixed point and products: what differs less is the same.
pub const ROUNDING: f32 = 1.0 / 2048.0;

/// How a batch's curves are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurveModes {
    /// K
    pub nodes: u32,
    /// Light may grow.
    pub gain: bool,
    /// All casters are soft discs of the `filter` transfer.
    pub slabs: bool,
    /// An `over` caster may add light.
    pub over: bool,
    /// Closed meshes absorb along the way through them.
    pub volumes: bool,
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
    light: Affine,
}

impl Open {
    const NONE: Self = Self { start: 2.0, end: 0.0, light: Affine::NONE };

    fn place(&mut self, start: f32, end: f32) {
        (self.start, self.end) = (self.start.min(start), self.end.max(end));
    }
}

#[derive(Clone, Debug)]
struct Texel {
    curve: Streaming,
    open: Open,
    passed: Affine,
    /// `passed` but for volumes.
    surfaces: Affine,
    nearest: f32,
    inside: Inside,
    /// Where the order counts.
    order: HitOrder<Hit>,
}

impl Texel {
    /// A hit in its place; whether it has one of its own.
    fn meet(&mut self, hit: &Hit) -> bool {
        let light = Affine { scale: hit.light, added: hit.added };
        self.open.light = self.open.light.then(light);
        self.passed = self.passed.then(light);
        self.surfaces = self.surfaces.then(light);
        if hit.opacity >= TRACE {
            self.open.place(hit.depth, hit.end);
        }
        hit.opacity >= TRACE
    }

    fn flush(&mut self) {
        if self.open.start <= 1.0 {
            let Open { start, end, light } = self.open;
            self.curve.insert_affine(start, end, light.scale, light.added);
            self.open = Open::NONE;
        }
    }

    fn ramp(&mut self, ramp: Ramp) {
        let light = Affine { scale: ramp.light, added: Vec3::ZERO };
        self.passed = self.passed.then(light);
        self.open.light = self.open.light.then(light);
        self.open.place(ramp.start, ramp.end);
        // Behind a face that comes late the curve was too dark.
        self.curve.disordered += u32::from(ramp.light.max_element() > 1.0);
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
        curve: Streaming::new(modes.nodes, modes.gain).with_over(modes.over),
        open: Open::NONE,
        passed: Affine::NONE,
        surfaces: Affine::NONE,
        nearest: 1.0,
        inside: Inside::default(),
        order: HitOrder::new(Hit::NONE),
    };
    let mut texels = TileTexels::filled(fresh.clone());
    if footprints.len() <= modes.segment {
        walk(records, &tile, footprints, opaque, &mut texels, modes);
    } else {
        for segment in footprints.chunks(modes.segment) {
            let mut partial = TileTexels::filled(fresh.clone());
            walk(records, &tile, segment, opaque, &mut partial, modes);
            for place in 0..TEXELS {
                follow(&mut texels[place], &partial[place], modes);
            }
        }
    }
    for place in 0..TEXELS {
        let rest = scattered.map(|sums| sums.texel(index, place));
        finish(&mut texels[place], rest, modes);
    }
    let mut done = TileTexels::filled(CurveTexel {
        nodes: Vec::new(),
        passed: Vec3::ONE,
        nearest: 1.0,
        disordered: 0,
    });
    for place in 0..TEXELS {
        let Texel { curve, passed, nearest, .. } = &texels[place];
        let (passed, nearest) = (passed.scale + passed.added, *nearest);
        let nodes = curve.pack().collect();
        done[place] = CurveTexel { nodes, passed, nearest, disordered: curve.disordered };
    }
    done
}

/// A segment behind those before it.
fn follow(texel: &mut Texel, segment: &Texel, modes: CurveModes) {
    if modes.volumes
        && let Some(ramp) = texel.inside.follow(&segment.inside)
    {
        texel.ramp(ramp);
        texel.flush();
    }
    let nodes: Vec<_> = segment.curve.pack().collect();
    texel.curve.append(&nodes, modes.over.then_some(segment.passed));
    texel.curve.disordered += segment.curve.disordered;
    texel.passed = texel.passed.then(segment.passed);
    texel.surfaces = texel.surfaces.then(segment.surfaces);
    texel.nearest = texel.nearest.min(segment.nearest);
}

/// What comes behind all pairs: `rest`, optical depth and nearest depth of what had no room.
fn finish(texel: &mut Texel, rest: Option<(IVec3, f32)>, modes: CurveModes) {
    if modes.volumes
        && let Some(ramp) = texel.inside.begin()
    {
        texel.ramp(ramp);
        texel.flush();
    }
    let (tau, nearest) = rest.unwrap_or((IVec3::ZERO, 1.0));
    let mut light = resolve::passed(tau);
    if modes.volumes {
        // The sums of the faces are what nearest-depth mode has.
        let tau = texel.inside.tau.wrapping_add(tau);
        let tau = if modes.gain { tau } else { tau.max(IVec3::ZERO) };
        let is = texel.passed.scale + texel.passed.added;
        let should = (texel.surfaces.scale + texel.surfaces.added) * resolve::passed(tau);
        light = should / is.max(Vec3::splat(1e-9));
        if (light - Vec3::ONE).abs().max_element() < ROUNDING {
            light = Vec3::ONE;
        }
    }
    if light != Vec3::ONE {
        // Pairs are given room front to back: what has none is behind.
        let depth = if nearest < 1.0 { nearest } else { texel.nearest };
        let depth = depth.max(texel.curve.last_end());
        texel.curve.insert(depth, depth, light);
        texel.passed = texel.passed.then(Affine { scale: light, added: Vec3::ZERO });
    }
    texel.nearest = texel.nearest.min(nearest);
    if texel.inside.leaves > 0 {
        // The light is inside.
        texel.nearest = 0.0;
    }
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
    let mut counts = TileTexels::filled(0);
    for target in pairs.iter().map(|pair| Target::new(records, pair.0)).filter(|_| modes.slabs) {
        for (place, at) in tile.texels() {
            let hit = target.hit(at, opaque[place]).filter(|hit| hit.depth < opaque[place]);
            counts[place] += u32::from(hit.is_some_and(|hit| hit.opacity >= TRACE));
        }
    }
    let is_few = |place: usize| counts[place] <= max_exact_hits(modes.nodes);
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
            let texel = &mut texels[place];
            let mut placed = false;
            if modes.volumes
                && let Some(face) = target.face(at, opaque[place])
                && let Some(ramp) = texel.inside.cross(&face)
            {
                texel.ramp(ramp);
                placed = true;
            }
            if let Some(hit) = target.hit(at, opaque[place])
                && hit.depth < opaque[place]
            {
                if hit.opacity >= VISIBLE_OPACITY {
                    texel.nearest = texel.nearest.min(hit.depth);
                }
                if modes.over {
                    let leaves = texel.order.push(hit.depth, hit);
                    placed |= leaves.is_some_and(|(_, hit)| texel.meet(&hit));
                } else {
                    placed |= texel.meet(&hit);
                }
            }
            if placed && (is_few(place) && texel.curve.has_free_node() || !modes.slabs) {
                texel.flush();
            }
        }
    }
    for place in 0..TEXELS {
        let texel = &mut texels[place];
        texel.flush();
        let waiting: Vec<_> = texel.order.drain().collect();
        for (_, hit) in waiting {
            texel.meet(&hit);
            texel.flush();
        }
    }
}
