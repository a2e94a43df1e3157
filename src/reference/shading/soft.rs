//! Twin of `wgsl/shade/source_area.wgsl` and `spot.wgsl`: transmittance from an area light to a point.
//!
//! An occluder at distance d from the light hides, from a receiver at distance r, the part of the light
//! whose image through the receiver it covers. In the map that image is a spot with the light's outline,
//! scaled by `scale (1/d - 1/r)`. Each node of a block is filtered over the spot of its own depth, so that
//! every occluder on the way has the penumbra of its distance, in colour. Spots from one power of two of
//! texels to the next are filtered on one level, over windows up to four blocks wide.
//!
//! Levels are evaluated from the widest spots to the sharpest, from the light on. Each gives the light
//! behind its depths as a share of the light before them, and the shares are multiplied: an occluder behind
//! another removes only what the first left. Blocks that no ray from the light's centre reaches hold
//! nothing about the occluders behind; there, the share is the one that the level before measured around
//! it.
use super::{
    Lighting, Receiver,
    levels::{Block, Level},
    outline::Outline,
    receive::{Plane, Surface},
};
use crate::{
    records::{GpuArea, GpuLight, GpuView, PackedNode, level_count},
    reference::curve::{DEPTHS, unpack},
};
use glam::{IVec2, Vec2, Vec2Swizzles as _, Vec3};

/// Radius of the widest spot that a level filters [blocks]: its window is 4.5 blocks wide, that of half
/// the radius 1.6.
pub const WIDEST: f32 = 2.8;
/// Radius up to which a spot reads the map itself instead of a level [texels].
pub const SHARP: f32 = 2.0;
/// Aspect ratio of a rectangle up to which its shorter edge chooses the level; beyond it, the longer edge
/// divided by this does.
pub const LONGEST: f32 = 2.33;
/// Weight of a level's result per light before the level, up to a weight of 1.
pub const EVIDENCE: f32 = 300.0;
/// Least light to divide by.
pub const LEAST: f32 = 1e-4;
/// Smallest change of light that counts as an occluder.
pub const NOTHING: f32 = 1e-3;
/// Distance from a block's middle that a plane's ramp in it spans [blocks]; half a block at the first level,
/// whose blocks don't overlap.
pub const BLOCK_REACH: f32 = 1.0;

/// Cosine between a plane's normal and a ray below which the plane has no depth along it.
const EDGE_ON: f32 = 0.02;

/// Depth of the receiver's plane along the ray through a texel: `1 / d` in a perspective view, `d` in a
/// parallel one, is linear in the texel.
#[derive(Clone, Copy, Debug)]
struct PlaneDepth {
    middle: f32,
    by_texel: Vec2,
}

/// A look-up of one point in one view.
struct Spot<'a> {
    view: &'a GpuView,
    perspective: bool,
    /// Map position of the point [texels].
    place: Vec2,
    /// Along the view's axis [m].
    distance: f32,
    /// [fixed point]
    depth: f32,
    plane: PlaneDepth,
    /// [fixed point]
    bias: f32,
    /// Radius of a spot [texels], times a distance [m] in a perspective view.
    radius: f32,
    /// Half-widths of the spot along the axes of its window, relative to `radius`.
    shape: Vec2,
    /// Whether the window's axes are y and x, so that the second is the longer one.
    turned: bool,
    /// How far the window is sheared along its first axis, per step along its second.
    shear: f32,
    gain: bool,
}

/// Light of a level's blocks, averaged over the window.
#[derive(Default)]
struct Told {
    /// Light before the level's depths, light that they remove, light behind them, and light at the
    /// receiver.
    before: Vec3,
    taken: Vec3,
    behind: Vec3,
    end: Vec3,
    /// The most that can be left of `before`.
    most: Vec3,
    /// First depth behind the level's that removes light.
    next: Option<f32>,
}

/// Nodes of a block, without the second pair if all of it is behind the receiver.
fn nodes_before(block: &Block, end: f32) -> &[PackedNode] {
    let start = (block[1][0] >> 16) as f32;
    if start > 0.0 && start < end { block } else { &block[..2] }
}

impl<'a> Spot<'a> {
    fn new(
        view: &'a GpuView,
        light: &GpuLight,
        area: &GpuArea,
        surface: Surface,
        bias: f32,
        gain: bool,
    ) -> Self {
        let p = view.view_from_world.transform_point3(surface.point);
        let normal = view.view_from_world.transform_vector3(surface.normal);
        let perspective = view.perspective > 0.0;
        let distance = if perspective { (-p.z).max(1e-6) } else { -p.z };
        let spread = view.scale / if perspective { distance } else { 1.0 };
        let range = view.far - view.near;
        let Outline { turned, half, shear } = Outline::new(view, light, area, p, surface.point);
        let radius = half.min_element().max(half.max_element() / LONGEST);
        Self {
            view,
            perspective,
            place: Vec2::new(p.x, -p.y) * spread + view.size * 0.5,
            distance,
            depth: (distance - view.near) / range * DEPTHS,
            plane: plane_depth(view, p, normal, perspective),
            bias: bias / range * DEPTHS,
            radius: radius * view.scale,
            shape: half / radius.max(1e-9),
            turned,
            shear,
            gain,
        }
    }

    fn fixed(&self, distance: f32) -> f32 {
        (distance - self.view.near) / (self.view.far - self.view.near) * DEPTHS
    }

    /// Radius of a spot at a depth in fixed point [texels].
    fn spot(&self, depth: f32) -> f32 {
        let distance = depth / DEPTHS * (self.view.far - self.view.near) + self.view.near;
        if self.perspective {
            self.radius * (1.0 / distance.max(1e-6) - 1.0 / self.distance)
        } else {
            self.radius * (self.distance - distance)
        }
    }

    /// Depth [fixed point] at which a spot has a radius of `spot` texels.
    fn depth_of(&self, spot: f32) -> f32 {
        let radius = self.radius.max(1e-9);
        let distance = if self.perspective {
            1.0 / (1.0 / self.distance + spot / radius)
        } else {
            self.distance - spot / radius
        };
        self.fixed(distance)
    }

    /// Depth [fixed point] of the receiver along the ray through `texel`, the least within `around` texels.
    fn end(&self, texel: Vec2, around: f32) -> f32 {
        let PlaneDepth { middle, by_texel } = self.plane;
        let slack = by_texel.abs().element_sum() * around;
        let linear = middle + by_texel.dot(texel - self.view.size * 0.5);
        let distance =
            if self.perspective { 1.0 / (linear + slack).max(1e-7) } else { linear - slack };
        self.fixed(distance).min(self.depth) - self.bias
    }

    /// A vector along x and y, along the window's axes; and back.
    fn turn(&self, along: Vec2) -> Vec2 {
        if self.turned { along.yx() } else { along }
    }

    /// Window that filters a spot on blocks of an edge, along its axes [blocks]. Together with the overlap of
    /// the blocks and a block's own width it is closest to a disc at a variance slightly above the disc's.
    fn width(&self, spot: f32, edge: f32) -> Vec2 {
        let radius = self.shape * (spot / edge);
        (3.0 * radius * radius - 3.25 + 9.0 / (edge * edge)).max(Vec2::ONE).map(f32::sqrt)
    }

    /// First depth [fixed point] from `from` on at which blocks of a level around the point remove light.
    fn next(&self, level: &Level, edge: f32, from: f32, around: f32) -> Option<f32> {
        let corner = (self.place / edge - 0.5).floor().as_ivec2();
        let mut next = f32::INFINITY;
        for i in 0..4 {
            let at = corner + IVec2::new(i % 2, i / 2);
            let end = self.end((at.as_vec2() + 0.5) * edge, around * edge);
            let mut left = Vec3::ONE;
            for &node in nodes_before(level.block(at), end) {
                let (start, length, light) = unpack(node, self.gain);
                let takes = (left - light).abs().max_element() > NOTHING;
                left = light;
                let first = start.max(from);
                if start > 0.0 && takes && start + length >= from && first < end {
                    next = next.min(first);
                }
            }
        }
        (next < f32::INFINITY).then_some(next)
    }

    /// Evaluates the depths `from` to `to` on a level; `spot` is the radius of their widest spot [texels].
    fn tell(&self, level: &Level, edge: f32, spot: f32, from: f32, to: f32) -> Told {
        let middle = self.turn(self.place / edge - 0.5);
        let width = self.width(spot, edge);
        let half = 0.5 * (width + 1.0);
        let low = (middle.y - half.y).ceil();
        let rows = ((middle.y + half.y).floor() - low + 1.0) as i32;
        let reach = if edge == 2.0 { 1.0 } else { BLOCK_REACH * edge };
        let mut told = Told::default();
        for row in 0..rows {
            let y = low + row as f32;
            let sheared = self.shear * (y - middle.y);
            let first = (middle.x + sheared - half.x).ceil();
            let count = ((middle.x + sheared + half.x).floor() - first + 1.0) as i32;
            for i in 0..count {
                let column = first + i as f32;
                let off = Vec2::new(column - sheared, y) - middle;
                let at = self.turn(Vec2::new(column, y));
                let end = self.end((at + 0.5) * edge, reach);
                let block = level.block(at.as_ivec2());
                self.add_block(&mut told, block, off, edge, width, [from, to, end]);
            }
        }
        // The light left in a narrower window is part of that in the widest: at most as much per area.
        let least = self.width(self.spot(to), edge).min(width);
        told.most = told.behind * (width / least).element_product();
        told
    }

    fn add_block(
        &self,
        told: &mut Told,
        block: &Block,
        off: Vec2,
        edge: f32,
        width: Vec2,
        [from, to, end]: [f32; 3],
    ) {
        let weight = cover(off, width);
        let (mut before, mut behind, mut last) = (Vec3::ONE, Vec3::ONE, Vec3::ONE);
        let mut left = Vec3::ONE;
        for &node in nodes_before(block, end) {
            let (start, length, light) = unpack(node, self.gain);
            let drop = if start > 0.0 { left - light } else { Vec3::ZERO };
            left = light;
            let next = start.max(to);
            if drop.abs().max_element() > NOTHING && start + length > to && next < end {
                told.next = Some(told.next.map_or(next, |least| least.min(next)));
            }
            let share = |depth: f32| ((depth.min(end) - start) / length.max(1e-3)).clamp(0.0, 1.0);
            let shares = [from, to, end].map(share);
            before -= drop * shares[0];
            behind -= drop * shares[1];
            last -= drop * shares[2];
            let spot = self.spot(start + length * 0.5 * (shares[0] + shares[1]));
            let own = cover(off, self.width(spot, edge).min(width));
            told.taken += drop * ((shares[1] - shares[0]) * own);
        }
        told.before += before * weight;
        told.behind += behind * weight;
        told.end += last * weight;
    }
}

/// Share of a window of `width` blocks that covers the block `off` its centre, along its axes, by area.
fn cover(off: Vec2, width: Vec2) -> f32 {
    let over = (0.5 * (width + 1.0) - off.abs()).max(Vec2::ZERO).min(width.min(Vec2::ONE));
    (over / width).element_product()
}

/// Weight of a level's result, per channel.
fn evidence(before: Vec3) -> Vec3 {
    (before * EVIDENCE).clamp(Vec3::ZERO, Vec3::ONE)
}

fn plane_depth(view: &GpuView, p: Vec3, normal: Vec3, perspective: bool) -> PlaneDepth {
    let by_slope = Vec2::new(normal.x, -normal.y) / view.scale;
    // Slope of the plane through `p`; zero where the plane is edge-on or there is no surface.
    let (meets, length) = if perspective { (normal.dot(p), p.length()) } else { (normal.z, 1.0) };
    if meets.abs() < EDGE_ON * length || normal == Vec3::ZERO {
        let distance = if perspective { 1.0 / (-p.z).max(1e-6) } else { -p.z };
        return PlaneDepth { middle: distance, by_texel: Vec2::ZERO };
    }
    if perspective {
        PlaneDepth { middle: -normal.z / meets, by_texel: by_slope / meets }
    } else {
        PlaneDepth { middle: -normal.dot(p) / meets, by_texel: by_slope / meets }
    }
}

impl Lighting<'_> {
    /// [`Self::receive`] for an area light. `point`: lifted off the surface.
    pub(super) fn receive_area(
        &self,
        index: usize,
        light: &GpuLight,
        point: Vec3,
        surface: Surface,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        let Some(area) = light.area().map(|area| &self.records.areas[area]) else {
            return Vec3::ONE;
        };
        let leveled = area.first_leveled as usize + index - light.first_view as usize;
        let view = &self.records.views[index];
        let Some(sharp) = self.taps(index, point) else { return Vec3::ONE };
        if sharp.z > 1.0 + bias / (view.far - view.near) {
            return Vec3::ZERO;
        }
        let range = view.far - view.near;
        let gain = self.maps[index].curve.as_ref().is_some_and(|curve| curve.gain);
        let spot = Spot::new(view, light, area, surface, bias, gain);
        let level = |level| (self.levels.level(leveled, level), (1 << level) as f32);
        let last = level_count(view.size.as_uvec2());
        // Finest level whose blocks are large enough; 0 for the map.
        let level_of = |radius: f32| {
            let filters = |level: &u32| radius <= WIDEST * (1 << level) as f32;
            if radius <= SHARP { 0 } else { (1..last).find(filters).unwrap_or(last) }
        };
        let (mut light, mut sum) = (Vec3::ONE, Vec3::ZERO);
        // Light that reaches the receiver where a level has no light before it.
        let mut around = Vec3::ONE;
        let (mut from, mut number) = (-1.0, last);
        // Next occluder in the window of the level before: each is followed, or it would let light through.
        let mut rest = None;
        while number > 0 {
            let above = (number + 2).min(last);
            let (map, edge) = level(above);
            let Some(next) = rest.or_else(|| spot.next(map, edge, from, 0.0)) else { break };
            let radius = spot.spot(next);
            let found = level_of(radius).min(number);
            if found == 0 || (rest.is_none() && found + 2 < above) {
                number = found;
                continue;
            }
            number = found;
            let (map, edge) = level(number);
            let to = spot.depth_of(if number == 1 { SHARP } else { WIDEST * edge * 0.5 });
            let told = spot.tell(map, edge, radius.min(WIDEST * edge), from, to);
            let known = evidence(told.before);
            let left = (told.before - told.taken).min(told.most);
            let passed = left / told.before.max(Vec3::splat(LEAST));
            sum += light * (Vec3::ONE - known) * around;
            light *= known * passed.max(Vec3::ZERO);
            let known = evidence(told.behind * 10.0);
            around = around.lerp_by(told.end / told.behind.max(Vec3::splat(LEAST)), known);
            rest = told.next;
            from = to;
            number -= 1;
        }
        let (map, edge) = level(1);
        if rest.or_else(|| spot.next(map, edge, from, 0.5)).is_none() {
            return sum + light;
        }
        // Occluders close to the receiver, from the map itself.
        let plane = Plane::new(view, surface);
        let (mut before, mut behind) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..9 {
            let (texel, weight) = sharp.tap(i);
            behind +=
                weight * self.receive_texel(index, texel, sharp.z, plane, bias / range, receiver);
            let split = (from - 1.5) / DEPTHS;
            before += weight * self.light_before(index, texel, split);
        }
        let known = evidence(before);
        let passed = behind / before.max(Vec3::splat(LEAST));
        let passed = if gain { passed } else { passed.min(Vec3::ONE) };
        sum + light * around.lerp_by(passed, known)
    }
}

trait LerpBy {
    fn lerp_by(self, other: Self, share: Self) -> Self;
}

impl LerpBy for Vec3 {
    fn lerp_by(self, other: Self, share: Self) -> Self {
        self + (other - self) * share
    }
}
