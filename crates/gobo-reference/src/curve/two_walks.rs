//! CPU reference of `wgsl/curve/ray.wgsl`: curves by two walks over hits that only filter light.
//!
//! The first walk, in any order, finds the light behind all hits, their number, their first and last depth,
//! and the number of *pairs* of neighbours in each bin of cost. Up to K hits each have a node: the curve is
//! exact, in any order. Up to [`FEW`] times as many, the cheapest pairs are joined, as many as must be; the
//! cost is the area of the light that both take times the depth between them. Beyond, the second walk gives
//! each hit a *place* on the ray: half by the light lost so far, half by the depth passed, in which the gap
//! in front of the hit counts three times. The open node ends where a place passes its cut: the node's start
//! plus an equal part of the rest there. A hit that alone takes more than an equal part of the light that is
//! left has a node of its own. Hits of equal depth stay together.
//!
//! A node passes the product of its hits, as a ramp with the mean depth and the variance of their lost light,
//! within the depths of its first and last hit. So the error at any depth is at most the loss of the nodes
//! that enclose it; where hits come in order, the light lost in one.
use super::{
    MAX_NODES, PackedNode,
    bodies::{MIN_BEND, SHORTEST},
    fixed,
    taken::Taken,
    tile::TRACE,
};
use crate::resolve::BLACK;
use glam::{BVec3, DVec3, Vec3};
use gobo::records::curve::{packed, unpack};

/// Pairs are joined by cost while there are at most this many hits per node.
pub const FEW: u32 = 6;
/// Most hits whose pairs are joined by cost.
pub const MOST_FEW: u32 = 64;
/// Bins of the pairs' costs, about half an octave each; the last holds all from 3/4 up.
pub const COST_BINS: usize = 32;

/// Least depth between the hits of a pair.
pub const LEAST_GAP: f32 = 1.0 / 256.0;

/// A hit of a ray.
#[derive(Clone, Copy, Debug)]
pub struct RayHit {
    /// Depths at which the hit begins to take light and has taken all \[light depth\].
    pub start: f32,
    /// Light depth at which it has taken all.
    pub end: f32,
    /// 1 - transmittance, per channel.
    pub absorbed: Vec3,
    /// Strength by which the hit sets depths.
    pub presence: f32,
}

/// Properties of a curve by two walks.
#[derive(Clone, Copy, Debug)]
pub struct RayModes {
    /// Nodes of the curve (K).
    pub nodes: u32,
    /// The cheapest pairs of few hits are joined.
    pub few: bool,
    /// Some caster is faint: hits below [`TRACE`] share a place.
    pub faint: bool,
    /// Light may grow.
    pub grows: bool,
    /// All free nodes but this many go to the most bent hits; `None` without bodies.
    pub bodies: Option<u32>,
}

/// Least light under a root: black counts as this.
pub const LEAST_ROOTED: f32 = 1.0 / 2048.0;

/// Light of a ray during a walk.
#[derive(Clone, Copy, Debug)]
struct Passing {
    light: DVec3,
    /// Presence of the hits since the last with a place, if some caster is faint.
    traces: f32,
    modes: RayModes,
    /// The largest depth of a place so far.
    at: f32,
    /// Light that the hit at the last place took, summed over the channels.
    taken: f32,
}

/// A hit at its place.
#[derive(Clone, Copy, Debug)]
struct PlacedHit {
    /// Light in front of the hit, and behind.
    light: Vec3,
    behind: Vec3,
    /// The largest depth so far.
    z: f32,
    taken: f32,
    /// Bin of the cost of joining it to the hit before.
    bin: usize,
}

impl Passing {
    const fn new(modes: RayModes) -> Self {
        Self { light: DVec3::ONE, traces: 0.0, modes, at: 0.0, taken: 0.0 }
    }

    /// Adds a hit. `None` if it has no place: behind black only late hits can change anything.
    fn pass(&mut self, hit: &RayHit) -> Option<PlacedHit> {
        let light = self.light.as_vec3();
        let acts = self.modes.grows || !is_dark(light) || hit.start < self.at;
        self.light *= DVec3::ONE - hit.absorbed.as_dvec3();
        // Many hits below `TRACE` share a depth.
        self.traces = if self.modes.faint { self.traces + hit.presence } else { hit.presence };
        if self.traces < TRACE {
            return None;
        }
        self.traces = 0.0;
        let behind = self.light.as_vec3();
        let taken = (light - behind).abs().element_sum();
        let z = hit.start.max(self.at);
        let bin = bin((self.taken + taken) * gap(self.at, z));
        acts.then_some(PlacedHit { light, behind, z, taken, bin })
    }

    fn go_on(&mut self, placed: &PlacedHit) {
        (self.at, self.taken) = (placed.z, placed.taken);
    }
}

fn is_dark(light: Vec3) -> bool {
    light.cmplt(Vec3::splat(BLACK)).all()
}

/// Depth between two hits in a pair's cost: joining strong hits that are close together costs something, too.
fn gap(at: f32, z: f32) -> f32 {
    if z > at { z - at + LEAST_GAP } else { 0.0 }
}

/// Bin of a pair's cost.
fn bin(cost: f32) -> usize {
    let half_octaves = (cost.to_bits() >> 22) as usize;
    half_octaves.saturating_sub(2 * 127 - COST_BINS).min(COST_BINS - 1)
}

/// A node that hits join.
#[derive(Clone, Copy, Debug)]
struct OpenNode {
    /// Light in front of it, behind the nodes before.
    light: Vec3,
    low: f32,
    high: f32,
    taken: Taken,
    /// Place where it began, and place where it ends.
    place: f32,
    cut: f32,
}

/// Nodes of a ray in the second walk.
struct Nodes {
    modes: RayModes,
    nodes: Vec<PackedNode>,
    /// Rounding of the nodes so far, to be corrected.
    owed: Vec3,
}

impl Nodes {
    fn write(&mut self, [start, end]: [f32; 2], passed: Vec3) {
        let most = if self.modes.grows { f32::MAX } else { 1.0 };
        let wanted = (passed * self.owed).min(Vec3::splat(most));
        let length = (end - start).max(0.0) * super::DEPTHS;
        let node = packed(fixed(start), length, wanted, self.modes.grows);
        let stored = unpack(node, self.modes.grows).2;
        let owed = wanted / stored.max(Vec3::splat(1e-9));
        self.owed = Vec3::select(stored.cmpgt(Vec3::ZERO), owed, Vec3::ONE);
        self.nodes.push(node);
    }

    /// Writes a hit, in `parts` equal parts.
    fn write_parts(&mut self, [start, end]: [f32; 2], passed: Vec3, parts: u32) {
        let root = passed.max(Vec3::splat(LEAST_ROOTED)).powf(1.0 / parts as f32);
        let length = (end - start) / parts as f32;
        for part in 0..parts {
            let is_last = part + 1 == parts;
            let dark = passed.cmplt(Vec3::splat(LEAST_ROOTED)) & BVec3::splat(is_last);
            let own = Vec3::select(dark, Vec3::ZERO, root);
            let start = start + part as f32 * length;
            self.write([start, start + length], if parts == 1 { passed } else { own });
        }
    }

    /// `light`: behind the node.
    fn write_open(&mut self, open: &OpenNode, light: Vec3) {
        let passed = light / open.light.max(Vec3::splat(1e-9));
        let dark = light.cmplt(Vec3::splat(BLACK)) & BVec3::splat(!self.modes.grows);
        let passed = Vec3::select(dark, Vec3::ZERO, passed);
        self.write(open.taken.fitted(open.low, open.high), passed);
    }

    /// Number of free nodes, with the open one.
    fn left(&self) -> u32 {
        self.modes.nodes - self.nodes.len() as u32
    }

    fn cut(&self, place: f32) -> f32 {
        place + (1.0 - place) / self.left() as f32
    }
}

/// Free nodes for bodies, in which light falls exponentially: several ramps approximate that better than one.
#[derive(Clone, Copy, Debug)]
struct Bends {
    /// Sum over the remaining hits of the difference between the roots of the light in front of the hit and
    /// behind.
    sum: f32,
    spare: u32,
}

impl Bends {
    fn of(hit: &RayHit, placed: &PlacedHit) -> f32 {
        let root = |light: Vec3| light.max(Vec3::ZERO).map(f32::sqrt);
        let bend = (root(placed.light) - root(placed.behind)).abs().max_element();
        let is_long = fixed(hit.end) >= fixed(hit.start) + SHORTEST;
        if is_long && bend > MIN_BEND { bend } else { 0.0 }
    }

    /// Number of ramps of the next hit.
    fn parts(&mut self, bend: f32) -> u32 {
        let share = bend / self.sum.max(1e-9) * self.spare as f32;
        let more = (share.round_ties_even() as u32).min(self.spare);
        self.sum -= bend;
        self.spare -= more;
        1 + more
    }
}

/// Joined pairs: those in bins below `bin`, and `equal` of those in it.
#[derive(Clone, Copy, Debug)]
struct Joined {
    bin: usize,
    equal: u32,
}

impl Joined {
    /// The `most` cheapest pairs.
    fn cheapest(bins: [u32; COST_BINS], most: u32) -> Self {
        let mut joined = Self { bin: 0, equal: most };
        while joined.bin + 1 < COST_BINS && bins[joined.bin] < joined.equal {
            joined.equal -= bins[joined.bin];
            joined.bin += 1;
        }
        joined
    }

    /// Whether the next pair is joined.
    fn has(&mut self, bin: usize) -> bool {
        let is_equal = bin == self.bin && self.equal > 0;
        self.equal -= u32::from(is_equal);
        bin < self.bin || is_equal
    }
}

/// A curve's nodes, and the light behind it.
pub fn curve(hits: &[RayHit], modes: RayModes) -> (Vec<PackedNode>, Vec3) {
    let (mut count, mut first, mut last, mut all, mut bends) = (0, 1.0_f32, 0.0_f32, 0.0, 0.0);
    let mut bins = [0; COST_BINS];
    let mut passing = Passing::new(modes);
    for hit in hits {
        if let Some(placed) = passing.pass(hit) {
            bins[placed.bin] += u32::from(count > 0);
            count += 1;
            first = first.min(hit.start);
            last = placed.z;
            all += placed.taken;
            bends += Bends::of(hit, &placed);
            passing.go_on(&placed);
        }
    }
    let passed = passing.light.as_vec3();
    let nodes = modes.nodes;
    let by_cost = modes.few && count <= (FEW * nodes).min(MOST_FEW);
    let spare = modes.bodies.map_or(0, |kept| nodes.saturating_sub(count + kept));
    let mut bends = Bends { sum: bends, spare };
    let mut joined = Joined::cheapest(bins, count.saturating_sub(nodes));
    let (by_light, by_depth) = (0.5 / all.max(1e-9), 0.5 / (last - first).max(1e-9));
    let mut written = Nodes { modes, nodes: Vec::with_capacity(MAX_NODES), owed: Vec3::ONE };
    let mut open: Option<OpenNode> = None;
    let mut passing = Passing::new(modes);
    let (mut seen, mut gone) = (0, 0.0);
    for hit in hits {
        let Some(placed) = passing.pass(hit) else { continue };
        let PlacedHit { light, behind, z, taken, .. } = placed;
        let joins = seen > 0 && joined.has(placed.bin);
        let still = count - seen;
        let free = written.left() - u32::from(open.is_some());
        let much = taken * written.left() as f32 > all - gone;
        let fits = free > 1 || free > 0 && (open.is_some() || still == 1);
        if count <= nodes || !by_cost && much && fits {
            let is_last = hit.start >= passing.at && !modes.grows;
            let dark = behind.cmplt(Vec3::splat(BLACK)) & BVec3::splat(is_last);
            let own = Vec3::select(dark, Vec3::ZERO, Vec3::ONE - hit.absorbed);
            let parts = bends.parts(Bends::of(hit, &placed));
            written.write_parts([hit.start, hit.end], own, parts);
            if let Some(open) = &mut open {
                open.light *= Vec3::ONE - hit.absorbed;
                open.place += by_light * taken;
                open.cut = written.cut(open.place);
            }
        } else {
            let place =
                by_light * (gone + 0.5 * taken) + by_depth * (3.0 * z - 2.0 * passing.at - first);
            if let Some(ended) = open {
                let passes = if by_cost { !joins } else { place > ended.cut };
                if free > 0 && z > passing.at && (passes || still <= free) {
                    written.write_open(&ended, light);
                    open = None;
                }
            }
            let begun = by_light * gone + by_depth * (z - first);
            let node = open.get_or_insert_with(|| OpenNode {
                light,
                low: hit.start,
                high: hit.end,
                taken: Taken::NONE,
                place: begun,
                cut: written.cut(begun),
            });
            node.low = node.low.min(hit.start);
            node.high = node.high.max(hit.end);
            node.taken.add_between([hit.start, hit.end], taken);
        }
        seen += 1;
        gone += taken;
        passing.go_on(&placed);
    }
    if let Some(open) = open {
        written.write_open(&open, passing.light.as_vec3());
    }
    written.nodes.resize(nodes as usize, packed(0, 0.0, Vec3::ONE, modes.grows));
    (written.nodes, passed)
}
