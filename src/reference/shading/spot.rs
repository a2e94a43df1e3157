//! Twin of `wgsl/shade/spot.wgsl`: the part of a shadow map that an area light covers, seen from a point through
//! an occluder's depth.
use super::{outline::Outline, receive::Surface};
use crate::{
    records::{GpuArea, GpuLight, GpuView},
    reference::curve::DEPTHS,
};
use glam::{Vec2, Vec2Swizzles as _, Vec3};

/// Radius of the widest spot that a level filters [blocks]: its window is 4.5 blocks wide, that of half
/// the radius 1.6.
pub const WIDEST: f32 = 2.8;
/// Radius up to which a spot reads the map itself instead of a level [texels].
pub const SHARP: f32 = 2.0;
/// Aspect ratio of a rectangle up to which its shorter edge chooses the level; beyond it, the longer edge
/// divided by this does.
pub const LONGEST: f32 = 2.33;
/// Half-width of the range of spots in which two levels, or a level and the map, share an occluder, relative
/// to the radius at which one takes over from the other.
pub const FADE: f32 = 0.125;

/// Cosine between a plane's normal and a ray below which the plane has no depth along it.
pub const EDGE_ON_PLANE: f32 = 0.02;

/// Depth of the receiver's plane along the ray through a texel: `1 / d` in a perspective view, `d` in a
/// parallel one, is linear in the texel.
#[derive(Clone, Copy, Debug)]
struct PlaneDepth {
    middle: f32,
    by_texel: Vec2,
}

/// A look-up of one point in one view.
pub(super) struct Spot<'a> {
    view: &'a GpuView,
    perspective: bool,
    /// Map position of the point [texels].
    pub(super) center: Vec2,
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
    pub(super) shear: f32,
    pub(super) gain: bool,
}

impl<'a> Spot<'a> {
    pub(super) fn new(
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
            center: Vec2::new(p.x, -p.y) * spread + view.size * 0.5,
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
    pub(super) fn radius_at(&self, depth: f32) -> f32 {
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

    /// Depths [fixed point] between which what covers spots of more than `radius` texels fades into what
    /// covers smaller ones.
    pub(super) fn fade_at(&self, radius: f32) -> [f32; 2] {
        [1.0 + FADE, 1.0 - FADE].map(|part| self.depth_of(radius * part))
    }

    /// Depth [fixed point] of the receiver along the ray through `texel`, the least within `around` texels.
    pub(super) fn end(&self, texel: Vec2, around: f32) -> f32 {
        let PlaneDepth { middle, by_texel } = self.plane;
        let slack = by_texel.abs().element_sum() * around;
        let linear = middle + by_texel.dot(texel - self.view.size * 0.5);
        let distance =
            if self.perspective { 1.0 / (linear + slack).max(1e-7) } else { linear - slack };
        self.fixed(distance).min(self.depth) - self.bias
    }

    /// A vector along x and y, along the window's axes; and back.
    pub(super) fn turn(&self, along: Vec2) -> Vec2 {
        if self.turned { along.yx() } else { along }
    }

    /// Windows on blocks of an edge for spots of radii from `widest` to `least` [texels].
    pub(super) fn windows(&self, widest: f32, least: f32, edge: f32) -> Windows {
        let shape = self.shape / edge;
        let by_square = 3.0 * shape * shape;
        let less = 3.25 - 9.0 / (edge * edge);
        // Below that the windows are one block wide.
        let low = (1.0 + less) / by_square.max_element().max(1e-12);
        let wide = widest * widest;
        let narrow = (least * least).max(low).min(wide);
        let squares = [wide, (wide * narrow).sqrt(), narrow];
        // Together with the overlap of the blocks and a block's own width, a window is closest to a disc at a
        // variance slightly above the disc's.
        let width = |square: f32| (by_square * square - less).max(Vec2::ONE).map(f32::sqrt);
        Windows { squares, widths: squares.map(width) }
    }
}

/// Windows on blocks of one edge: the widest, and two narrower ones.
pub(super) struct Windows {
    /// Of the radii of the spots that they filter [texels^2].
    squares: [f32; 3],
    /// Along their axes [blocks].
    pub(super) widths: [Vec2; 3],
}

impl Windows {
    /// Weight of a block `off` their centre for a spot of a radius. A spot between those of two windows is
    /// filtered by both, so that their variance is its own.
    pub(super) fn cover(&self, off: Vec2, radius: f32) -> f32 {
        let covers = self.widths.map(|width| cover(off, width));
        let step = |i: usize| {
            let [wide, narrow] = [self.squares[i], self.squares[i + 1]];
            let narrower = ((wide - radius * radius) / (wide - narrow).max(1e-6)).clamp(0.0, 1.0);
            narrower * (covers[i + 1] - covers[i])
        };
        covers[0] + step(0) + step(1)
    }
}

/// Share of a window of `width` blocks that covers the block `off` its centre, along its axes, by area.
pub(super) fn cover(off: Vec2, width: Vec2) -> f32 {
    let over = (0.5 * (width + 1.0) - off.abs()).max(Vec2::ZERO).min(width.min(Vec2::ONE));
    (over / width).element_product()
}

fn plane_depth(view: &GpuView, p: Vec3, normal: Vec3, perspective: bool) -> PlaneDepth {
    let by_slope = Vec2::new(normal.x, -normal.y) / view.scale;
    // Slope of the plane through `p`; zero where the plane is edge-on or there is no surface.
    let (meets, length) = if perspective { (normal.dot(p), p.length()) } else { (normal.z, 1.0) };
    if meets.abs() < EDGE_ON_PLANE * length || normal == Vec3::ZERO {
        let distance = if perspective { 1.0 / (-p.z).max(1e-6) } else { -p.z };
        return PlaneDepth { middle: distance, by_texel: Vec2::ZERO };
    }
    if perspective {
        PlaneDepth { middle: -normal.z / meets, by_texel: by_slope / meets }
    } else {
        PlaneDepth { middle: -normal.dot(p) / meets, by_texel: by_slope / meets }
    }
}
