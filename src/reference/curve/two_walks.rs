//! CPU reference of `wgsl/curve/ray.wgsl`: curves of soft discs by two walks.
//!
//! The first walk, in any order, has the light behind all hits, how many there are, and the first and the last depth.
//! The second gives each hit a *place* on the ray, half by the light that was lost so far and half by the depth that is
//! gone, and ends the open node where a place passes its cut: where the node began, and an equal part of what was left
//! there; hits of equal depth stay together. A hit which alone takes more than an equal part of the light that is left has a node of its own. Up to K hits
//! each have one: the curve is exact, in any order.
//!
//! A node passes the product of its hits, as a ramp of the mean depth and the variance of the light that they take,
//! within the depths of its first and last hit. So at any depth the error is at most what the nodes that enclose it
//! take, where hits come in order the light lost in one.
use super::{
    MAX_NODES, PackedNode, fixed,
    format::{packed, unpack},
    taken::Taken,
    tile::TRACE,
};
use crate::reference::resolve::BLACK;
use glam::{BVec3, DVec3, Vec3};

/// A hit that has one depth.
#[derive(Clone, Copy, Debug)]
pub struct PointHit {
    /// \[light depth\]
    pub depth: f32,
    /// 1 - transmittance, per channel.
    pub absorbed: Vec3,
    /// What sets depths.
    pub presence: f32,
}

/// Light of a ray during a walk.
#[derive(Clone, Copy, Debug)]
struct Passing {
    light: DVec3,
    /// Presence of the hits since one had a place, if some caster is faint.
    traces: f32,
    faint: bool,
    /// The largest depth of a place so far.
    at: f32,
}

impl Passing {
    const fn new(faint: bool) -> Self {
        Self { light: DVec3::ONE, traces: 0.0, faint, at: 0.0 }
    }

    /// Adds a hit. Returns whether it has a place: behind black only what comes late can change anything.
    fn pass(&mut self, hit: &PointHit) -> bool {
        let acts = !is_dark(self.light.as_vec3()) || hit.depth < self.at;
        self.light *= DVec3::ONE - hit.absorbed.as_dvec3();
        // Many hits below `TRACE` have a depth together.
        self.traces = if self.faint { self.traces + hit.presence } else { hit.presence };
        let placed = self.traces >= TRACE;
        if placed {
            self.traces = 0.0;
        }
        placed && acts
    }
}

fn is_dark(light: Vec3) -> bool {
    light.cmplt(Vec3::splat(BLACK)).all()
}

/// A node that hits join.
#[derive(Clone, Copy, Debug)]
struct Open {
    /// In front of it, behind what is not its own.
    light: Vec3,
    low: f32,
    high: f32,
    taken: Taken,
    /// Place where it began, and where it ends.
    place: f32,
    cut: f32,
}

/// Nodes of a ray in the second walk.
struct Nodes {
    count: u32,
    nodes: Vec<PackedNode>,
    /// What rounding has taken of the nodes so far.
    owed: Vec3,
}

impl Nodes {
    fn write(&mut self, [start, end]: [f32; 2], passed: Vec3) {
        let wanted = (passed * self.owed).min(Vec3::ONE);
        let node = packed(fixed(start), (end - start).max(0.0) * super::DEPTHS, wanted, false);
        let stored = unpack(node, false).2;
        let owed = wanted / stored.max(Vec3::splat(1e-9));
        self.owed = Vec3::select(stored.cmpgt(Vec3::ZERO), owed, Vec3::ONE);
        self.nodes.push(node);
    }

    /// `light`: behind the node.
    fn write_open(&mut self, open: &Open, light: Vec3) {
        let passed = light / open.light.max(Vec3::splat(1e-9));
        let passed = Vec3::select(light.cmplt(Vec3::splat(BLACK)), Vec3::ZERO, passed);
        self.write(open.taken.fitted(open.low, open.high), passed);
    }

    /// Free nodes, and the open one.
    fn left(&self) -> u32 {
        self.count - self.nodes.len() as u32
    }

    fn cut(&self, place: f32) -> f32 {
        place + (1.0 - place) / self.left() as f32
    }
}

/// A curve's nodes, and the light behind it. `faint`: some caster is.
pub fn curve(hits: &[PointHit], nodes: u32, faint: bool) -> (Vec<PackedNode>, Vec3) {
    let (mut count, mut first, mut last) = (0, 1.0_f32, 0.0_f32);
    let mut passing = Passing::new(faint);
    for hit in hits {
        if passing.pass(hit) {
            count += 1;
            first = first.min(hit.depth);
            last = last.max(hit.depth);
            passing.at = last;
        }
    }
    let passed = passing.light.as_vec3();
    let all = 3.0 - passed.element_sum();
    let (by_light, by_depth) = (0.5 / all.max(1e-9), 0.5 / (last - first).max(1e-9));
    let mut written = Nodes { count: nodes, nodes: Vec::with_capacity(MAX_NODES), owed: Vec3::ONE };
    let mut open: Option<Open> = None;
    let mut passing = Passing::new(faint);
    let (mut seen, mut gone) = (0, 0.0);
    for hit in hits {
        let light = passing.light.as_vec3();
        if !passing.pass(hit) {
            continue;
        }
        let behind = passing.light.as_vec3();
        let taken = (light - behind).element_sum();
        let z = hit.depth.max(passing.at);
        let still = count - seen;
        let free = written.left() - u32::from(open.is_some());
        let much = taken * written.left() as f32 > all - gone;
        let fits = free > 1 || free > 0 && (open.is_some() || still == 1);
        if count <= nodes || count > 2 * nodes && much && fits {
            let dark = behind.cmplt(Vec3::splat(BLACK)) & BVec3::splat(hit.depth >= passing.at);
            let own = Vec3::select(dark, Vec3::ZERO, Vec3::ONE - hit.absorbed);
            written.write([hit.depth; 2], own);
            if let Some(open) = &mut open {
                open.light *= Vec3::ONE - hit.absorbed;
                open.place += by_light * taken;
                open.cut = written.cut(open.place);
            }
        } else {
            let place = by_light * (gone + 0.5 * taken) + by_depth * (2.0 * z - passing.at - first);
            if let Some(ended) = open
                && free > 0
                && z > passing.at
                && (place > ended.cut || still <= free)
            {
                written.write_open(&ended, light);
                open = None;
            }
            let begun = by_light * gone + by_depth * (z - first);
            let node = open.get_or_insert_with(|| Open {
                light,
                low: hit.depth,
                high: hit.depth,
                taken: Taken::NONE,
                place: begun,
                cut: written.cut(begun),
            });
            node.low = node.low.min(hit.depth);
            node.high = node.high.max(hit.depth);
            node.taken.add(hit.depth, taken);
        }
        seen += 1;
        gone += taken;
        passing.at = z;
    }
    if let Some(open) = open {
        written.write_open(&open, passing.light.as_vec3());
    }
    written.nodes.resize(nodes as usize, packed(0, 0.0, Vec3::ONE, false));
    (written.nodes, passed)
}
