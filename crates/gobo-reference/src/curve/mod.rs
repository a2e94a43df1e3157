//! CPU reference of `wgsl/curve/node.wgsl`, `wgsl/curve/list.wgsl` and `wgsl/curve/node.wgsl`: transmittance
//! as a function of depth, along the ray of one texel.
//!
//! A curve is a list of *ramps*, nearest first: between a ramp's start and end, light falls linearly from the
//! value behind the previous ramp to its own. Maps store the transmittance of each (`format`). A pane is a
//! ramp of length 0, a *step*. While a texel has at most K hits, each has a step of its own. A further hit is
//! inserted too, and then the two neighbours with the lowest cost merge: those whose curve deviates least, as
//! an area of light times depth, from the straight line over both.
//!
//! A merged ramp has the first two moments, mean depth and variance, of the light lost in both neighbours. It
//! stays within their span, and no later than the next ramp, as ramps ascend. So a merge keeps the mean of
//! the light over all depths unless the ramp was clamped.
//!
//! **Bound.** The hits of one ramp are neighbours, and the ramp stays within their span unless the next
//! begins before it. So at every depth the error is at most the light lost in one node, or in both where two
//! overlap, plus the rounding of the format: half of 1/65535 of the view's range, and half of 1/4095 of the
//! light.
//!
//! Streaming insertion with a cheapest merge is Salvi et al. 2010 (adaptive volumetric shadow maps). Unlike
//! theirs: in colour, with ramps, and with depths that move.
pub mod bodies;
mod format;
pub mod joined;
pub mod mean;
pub mod soften;
pub mod taken;
pub mod tile;
pub mod two_walks;
pub mod volumes;

use super::resolve::BLACK;
use format::{Storing, storable};
use glam::Vec3;
pub use gobo::records::curve::{DEPTHS, PackedNode, unpack};
use half::f16;

/// Most nodes of a curve.
pub const MAX_NODES: usize = 16;
/// [`BLACK`] in the kernels' fixed point.
pub const DARK: u16 = 64;

/// Node of a curve in registers, while hits are inserted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Node {
    /// Start in the upper 16 bits, end in the lower; 0 for an unused node.
    span: u32,
    /// Light behind: red, green, blue and their mean.
    light: [u16; 4],
    /// Whether it is a single hit, not merged.
    is_alone: bool,
}

impl Node {
    fn start(&self) -> f32 {
        (self.span >> 16) as f32
    }

    fn end(&self) -> f32 {
        (self.span & 0xffff) as f32
    }
}

/// A light depth in fixed point; 0 marks an unused node.
fn fixed(depth: f32) -> u32 {
    ((depth * DEPTHS).round_ties_even() as u32).clamp(1, 65535)
}

/// Affine transfer of a segment of a ray: `L` becomes `L * scale + added`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Factor of the light.
    pub scale: Vec3,
    /// Light that is added behind it.
    pub added: Vec3,
}

impl Affine {
    /// The transfer of no hit.
    pub const NONE: Self = Self { scale: Vec3::ONE, added: Vec3::ZERO };

    /// This transfer followed by `next`.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self { scale: self.scale * next.scale, added: self.added * next.scale + next.added }
    }

    /// Transmittance up to the depth behind which white light has become `light`. Exact while all added light
    /// has the same colour; near white, where `light` is imprecise, `part` of the segment's.
    fn share(self, light: Vec3, part: f32) -> Vec3 {
        let lost = Vec3::ONE - self.scale;
        let rest = Vec3::ONE - self.added / lost.max(Vec3::splat(1e-3));
        let known = Vec3::ONE - (Vec3::ONE - light) / rest.max(Vec3::splat(MIN_REST));
        let even = Vec3::ONE - lost * part;
        let share = Vec3::select(rest.cmpge(Vec3::splat(MIN_REST)), known, even);
        share.max(self.scale).min(Vec3::ONE)
    }
}

/// Least `1 - added colour` from which the transmittance can be recovered from white light.
pub const MIN_REST: f32 = 1.0 / 16.0;

/// Curve of one texel during insertion.
#[derive(Clone, Debug)]
pub struct Streaming {
    nodes: [Node; MAX_NODES],
    count: usize,
    gain: bool,
    /// Whether light may grow from black.
    over: bool,
    /// Light behind all hits.
    passed: Vec3,
    /// The latest start of a hit so far.
    latest: u32,
    /// Number of hits out of order, inside a merged ramp.
    pub disordered: u32,
}

impl Streaming {
    /// An empty curve. `count`: K; `gain`: whether light may grow.
    pub fn new(count: u32, gain: bool) -> Self {
        let mut new = Self {
            nodes: [Node::default(); MAX_NODES],
            count: (count as usize).clamp(2, MAX_NODES),
            gain,
            over: false,
            passed: Vec3::ONE,
            latest: 0,
            disordered: 0,
        };
        let light = new.encode_light(Vec3::ONE);
        new.nodes = [Node { span: 0, light, is_alone: false }; MAX_NODES];
        new
    }

    /// Whether hits may add light (`over`): see [`Self::insert_affine`].
    #[must_use]
    pub fn with_over(self, over: bool) -> Self {
        Self { over, ..self }
    }

    /// Whether the next hit fits without a merge.
    pub fn has_free_node(&self) -> bool {
        self.nodes[0].span == 0
    }

    /// Largest light depth at which a node ends.
    pub fn last_end(&self) -> f32 {
        self.nodes[self.count - 1].end() / DEPTHS
    }

    fn encode(&self, light: f32) -> u16 {
        if self.gain {
            f16::from_f32(light).to_bits()
        } else {
            (light.clamp(0.0, 1.0) * 65535.0).round_ties_even() as u16
        }
    }

    /// Like [`Self::decode`], in fixed-point steps.
    fn level(&self, bits: u16) -> f32 {
        if self.gain { f16::from_bits(bits).to_f32() } else { f32::from(bits) }
    }

    fn decode(&self, bits: u16) -> f32 {
        self.level(bits) * if self.gain { 1.0 } else { 1.0 / 65535.0 }
    }

    fn encode_light(&self, light: Vec3) -> [u16; 4] {
        let mean = (light.x + light.y + light.z) * (1.0 / 3.0);
        let encode = |v| self.encode(v);
        [encode(light.x), encode(light.y), encode(light.z), encode(mean)]
    }

    fn light_of(&self, node: &Node) -> Vec3 {
        let [r, g, b, _] = node.light;
        Vec3::new(self.decode(r), self.decode(g), self.decode(b))
    }

    /// Inserts one hit, or several that spread from light depth `start` to `end`.
    pub fn insert(&mut self, start: f32, end: f32, light: Vec3) {
        self.insert_affine(start, end, light, Vec3::ZERO);
    }

    /// Like [`Self::insert`], with the transfer `L * light + added`. The light added by a late hit scales the
    /// light behind it like a filter of the same effect, and is counted.
    pub fn insert_affine(&mut self, start: f32, end: f32, light: Vec3, added: Vec3) {
        self.insert_span(fixed(start) << 16 | fixed(end), light, added);
    }

    /// Like [`Self::insert`], with light `passed` behind all hits, including the absorption of faint ones.
    pub fn insert_to(&mut self, start: f32, end: f32, light: Vec3, passed: Vec3) {
        self.passed = passed;
        self.place_span(fixed(start) << 16 | fixed(end), light, Vec3::ZERO);
    }

    /// Appends the nodes of the following segment's curve, in order. `whole`: the segment's transfer, if it
    /// may add light.
    pub fn append(&mut self, nodes: &[PackedNode], whole: Option<Affine>) {
        let (mut before, reached) = (Vec3::ONE, self.passed);
        let count = nodes.len() as f32;
        for (i, &node) in (1..).zip(nodes) {
            let (start, length, passed) = unpack(node, self.grows());
            if start > 0.0 {
                let end = (start + length).round_ties_even().min(DEPTHS) as u32;
                let span = (start as u32) << 16 | end;
                if let Some(whole) = whole {
                    before *= passed;
                    let share = whole.share(before, i as f32 / count);
                    self.insert_span(span, Vec3::ZERO, reached * share + (before - share));
                } else {
                    self.insert_span(span, passed, Vec3::ZERO);
                }
            }
        }
    }

    /// Whether the light behind the last node is invisible.
    fn is_dark(&self) -> bool {
        let last = &self.nodes[self.count - 1];
        !self.gain && !self.over && last.light[..3].iter().all(|&light| light < DARK)
    }

    fn insert_span(&mut self, span: u32, light: Vec3, added: Vec3) {
        self.passed = self.passed * light + added;
        self.place_span(span, light, added);
    }

    fn place_span(&mut self, span: u32, light: Vec3, added: Vec3) {
        let (count, start) = (self.count, span >> 16);
        let index = self.nodes[..count].partition_point(|node| node.span <= span);
        // Nothing behind black is visible, so a walk may stop there.
        if index == count && self.is_dark() {
            return;
        }
        let before = if index > 0 { self.nodes[index - 1] } else { Node::default() };
        let reached = if index > 0 { self.light_of(&before) } else { Vec3::ONE };
        let is_late = start < self.latest;
        self.latest = self.latest.max(start);
        let is_inside = before.start() < start as f32 && before.end() > start as f32;
        if is_late && is_inside || index < count && added != Vec3::ZERO {
            self.disordered += 1;
        }
        let mut all = [Node::default(); MAX_NODES + 1];
        all[..index].copy_from_slice(&self.nodes[..index]);
        let behind = if index == count { self.passed } else { reached * light + added };
        all[index] = Node { span, light: self.encode_light(behind), is_alone: true };
        let light = light + added / reached.max(Vec3::splat(BLACK));
        for i in index..count {
            let node = self.nodes[i];
            let light = self.encode_light(self.light_of(&node) * light);
            all[i + 1] = Node { light, ..node };
        }
        self.merge_cheapest(&all[..=count]);
    }

    /// Merges the cheapest pair of `all`, which holds one node too many.
    fn merge_cheapest(&mut self, all: &[Node]) {
        let mean = |i: usize| self.level(all[i].light[3]);
        let full = if self.gain { 1.0 } else { 65535.0 };
        let mut best = (f32::INFINITY, 0, 0.0);
        for i in 0..self.count {
            let before = if i == 0 { full } else { mean(i - 1) };
            let cost = merge_cost(before, [mean(i), mean(i + 1)], [all[i], all[i + 1]]);
            if cost < best.0 {
                best = (cost, i, before);
            }
        }
        let (_, at, before) = best;
        let span = merged_span(before, [mean(at), mean(at + 1)], [all[at], all[at + 1]]);
        let span = all.get(at + 2).map_or(span, |next| in_order(span, next.span));
        // A node that absorbs nothing leaves the other unchanged.
        let is_alone = if before == mean(at) {
            all[at + 1].is_alone
        } else {
            mean(at) == mean(at + 1) && all[at].is_alone
        };
        let merged = Node { span, light: all[at + 1].light, is_alone };
        for i in 0..self.count {
            self.nodes[i] = match i.cmp(&at) {
                std::cmp::Ordering::Less => all[i],
                std::cmp::Ordering::Equal => merged,
                std::cmp::Ordering::Greater => all[i + 1],
            };
        }
    }

    /// Nodes in the format of a map.
    pub fn pack(&self) -> impl Iterator<Item = PackedNode> {
        let nodes = &self.nodes[..self.count];
        let mut light: Vec<_> = nodes.iter().map(|node| self.light_of(node)).collect();
        storable(&mut light, self.grows());
        let mut storing = Storing::new(self.grows());
        nodes.iter().zip(light).map(move |(node, light)| {
            let length = (node.end() - node.start()).max(0.0);
            storing.store(node.span >> 16, length, light)
        })
    }

    /// Whether nodes may amplify.
    fn grows(&self) -> bool {
        self.gain || self.over
    }
}

/// Merge cost: the area between the curve and the straight line over two neighbours, with light `before` in
/// front of both; 0 if one of them absorbs nothing.
fn merge_cost(before: f32, behind: [f32; 2], [a, b]: [Node; 2]) -> f32 {
    let (first, second) = (before - behind[0], behind[0] - behind[1]);
    if first * second == 0.0 {
        return 0.0;
    }
    let both = first + second;
    let first_area = first * (b.end() - a.start());
    (first_area - both * (a.end() - a.start())).abs()
        + (first_area - both * (b.start() - a.start())).abs()
}

/// Span of the ramp with the mean and variance of both, clamped to their common span.
fn merged_span(before: f32, behind: [f32; 2], [a, b]: [Node; 2]) -> u32 {
    let (first, second) = ((before - behind[0]).abs(), (behind[0] - behind[1]).abs());
    if first + second == 0.0 {
        return b.span;
    }
    let per_both = 1.0 / (first + second);
    let (first, second) = (first * per_both, second * per_both);
    // Twice the mean, and twelve times the variance.
    let (middle_a, middle_b) = (a.start() + a.end(), b.start() + b.end());
    let (length_a, length_b) = (a.end() - a.start(), b.end() - b.start());
    let middle = first * middle_a + second * middle_b;
    let (off_a, off_b) = (middle - middle_a, middle - middle_b);
    let spread = first * (length_a * length_a + 3.0 * off_a * off_a)
        + second * (length_b * length_b + 3.0 * off_b * off_b);
    let middle = 0.5 * middle;
    // The first of two overlapping ramps may end last.
    let last = a.end().max(b.end());
    let half = (0.5 * spread.sqrt()).min(middle - a.start()).min(last - middle).max(0.0);
    let start = (middle - half).round_ties_even() as u32;
    let end = (middle + half).round_ties_even() as u32;
    start << 16 | end
}

/// The span, moved so that it is no later than the `next` one.
fn in_order(span: u32, next: u32) -> u32 {
    let (start, end) = ((span >> 16).min(next >> 16), span & 0xffff);
    let end = if start == next >> 16 { end.min(next & 0xffff) } else { end };
    start << 16 | end
}
