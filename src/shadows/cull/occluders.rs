//! Occlusion culling of groups behind large opaque surfaces, as seen from a light.
//!
//! 1. The largest flat polygons of plain opaque triangles are found once ([`OccluderPolygons`]): ground and
//!    walls are quads of two triangles.
//! 2. A view uses the few that are largest in its map ([`Occluders`]).
//! 3. A box is hidden if it is behind the planes and within the outline of one of them.
//!
//! Depths are only evaluated along the rays through texel centres, so an outline need not shrink by texels,
//! only by the rounding error of an edge or a depth, and by the enlargement of `project`.
use super::frustum::{ROUNDING, rigid_axes, widened};
use crate::{
    model::{Bounds, TILE_SIZE},
    records::GpuView,
};
use glam::{DVec2, DVec3, Vec3};

/// Most occluders of a view.
pub const MAX_OCCLUDERS: usize = 16;
/// Most polygons of a scene, from which views choose.
const MAX_POLYGONS: usize = 256;
/// Least area of an occluder in the map [texels²].
const MIN_AREA: f64 = 1024.0;
/// Cosine between the normals of two triangles that form one occluder polygon. It bounds no rounding: a view
/// keeps both planes.
const FLAT: f32 = 0.9999;
/// Enlargement of particles \[texels\]: to a radius of at least 0.7071 texel, and a quad reaches 1.4143 times
/// as far.
const ENLARGED: f64 = 1.0;
/// Extent of a sliver's edge functions, which are noise and may hold up to the end of a tile that its box
/// touches: a tile's diagonal and a texel \[texels\].
const OVERSHOOT: f64 = TILE_SIZE as f64 * 1.4143 + 1.0;
/// Largest share of a triangle's height that rounding may move an edge by.
const WORST_SHARE: f64 = 0.01;
/// Largest ratio of the distance of a box's farthest point to that of its nearest point, or of the far plane;
/// `ROUNDING` covers more.
const DEEPEST: f64 = 4.0;

/// An occluder polygon: a triangle, or two coplanar ones that share an edge and form a convex quad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Polygon {
    /// Corners, world space \[m\], in order; the shared edge of a quad is from 1 to 3. A triangle leaves the
    /// last unused.
    corners: [Vec3; 4],
    count: usize,
    /// Area [m²].
    area: f32,
}

impl Polygon {
    fn of_triangle([a, b, c]: [Vec3; 3]) -> Option<Self> {
        let area = (b - a).cross(c - a).length() * 0.5;
        // Written so that a NaN is refused.
        (area > 0.0 && area.is_finite()).then_some(Self { corners: [a, b, c, c], count: 3, area })
    }

    /// Joins two triangles whose shared corners are equal to the last bit, so that no texel falls between
    /// them.
    fn of_two(first: [Vec3; 3], second: [Vec3; 3]) -> Option<Self> {
        let apex = (0..3).find(|&i| !second.contains(&first[i]))?;
        let other = second.into_iter().find(|corner| !first.contains(corner))?;
        let corners = [first[apex], first[(apex + 1) % 3], other, first[(apex + 2) % 3]];
        if !second.contains(&corners[1]) || !second.contains(&corners[3]) {
            return None;
        }
        let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or_zero();
        let turn = |i: usize| {
            let [a, b, c] = [0, 1, 2].map(|j| corners[(i + j) % 4]);
            (b - a).cross(c - b).normalize_or_zero().dot(normal)
        };
        let area = Self::of_triangle(first)?.area + Self::of_triangle(second)?.area;
        (0..4).all(|i| turn(i) > FLAT).then_some(Self { corners, count: 4, area })
    }
}

/// The largest occluder polygons of a scene.
#[derive(Clone, Debug, Default)]
pub struct OccluderPolygons(Vec<Polygon>);

impl OccluderPolygons {
    /// Polygons of triangles in upload order; `None` for a triangle that is not plain opaque, or where
    /// neighbours must not be joined.
    pub fn new(triangles: impl IntoIterator<Item = Option<[Vec3; 3]>>) -> Self {
        let mut polygons: Vec<Polygon> = Vec::new();
        let mut before = None;
        for triangle in triangles {
            let joined = before.zip(triangle).and_then(|(a, b)| Polygon::of_two(a, b));
            if let Some(joined) = joined {
                *polygons.last_mut().expect("the one before is the last") = joined;
                before = None;
                continue;
            }
            if polygons.len() >= 2 * MAX_POLYGONS {
                keep_largest(&mut polygons, MAX_POLYGONS, |polygon| f64::from(polygon.area));
            }
            let polygon = triangle.and_then(Polygon::of_triangle);
            polygons.extend(polygon);
            before = polygon.and(triangle);
        }
        keep_largest(&mut polygons, MAX_POLYGONS, |polygon| f64::from(polygon.area));
        Self(polygons)
    }
}

fn keep_largest<T>(items: &mut Vec<T>, most: usize, size: impl Fn(&T) -> f64) {
    if items.len() > most {
        items.select_nth_unstable_by(most, |a, b| size(b).total_cmp(&size(a)));
        items.truncate(most);
    }
}

/// A half space with margins: inside is where `normal . x + shift` exceeds them.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: DVec3,
    shift: f64,
    /// Margins for rounding: constant, and per metre of depth in a perspective view.
    fixed: f64,
    rounding: f64,
    /// Change over a texel, per metre of depth in a perspective view.
    texel: f64,
}

impl Plane {
    /// `wide`: largest depth of the box, 1 in an orthographic view; `grown`: enlargement \[texels\].
    fn holds(&self, center: DVec3, half: DVec3, wide: f64, grown: f64) -> bool {
        let least = self.normal.dot(center) + self.shift - self.normal.abs().dot(half);
        least >= (self.rounding + self.texel * grown) * wide + self.fixed
    }
}

#[derive(Clone, Debug)]
struct Occluder {
    /// Planes behind the one or two triangles, then planes through the edges.
    behind: Vec<Plane>,
    edges: Vec<Plane>,
    /// Area in the map [texels²].
    area: f64,
}

/// The occluders of a view.
#[derive(Clone, Debug, Default)]
pub struct Occluders {
    occluders: Vec<Occluder>,
    perspective: bool,
    /// Depth of a point: `normal . x + shift` \[m\].
    depth_normal: DVec3,
    depth_shift: f64,
    /// Farthest depth, as a distance \[m\].
    farthest: f64,
}

impl Occluders {
    /// The polygons as a view sees them.
    pub fn new(polygons: &OccluderPolygons, view: &GpuView) -> Self {
        let Some(frame) = WideView::new(view) else { return Self::default() };
        let mut occluders: Vec<Occluder> =
            polygons.0.iter().filter_map(|polygon| frame.occluder(polygon)).collect();
        keep_largest(&mut occluders, MAX_OCCLUDERS, |occluder| occluder.area);
        occluders.sort_by(|a, b| b.area.total_cmp(&a.area));
        Self {
            occluders,
            perspective: frame.perspective,
            depth_normal: -frame.axes[2],
            depth_shift: -frame.shift.z,
            farthest: frame.near.abs().max(frame.far.abs()),
        }
    }

    /// Whether nothing can be hidden behind them.
    pub fn is_empty(&self) -> bool {
        self.occluders.is_empty()
    }

    /// Whether every texel of the view's map is the same without the contents of the box; false if unknown.
    /// `triangles`: whether the contents are triangles, not particles.
    pub fn hide(&self, bounds: &Bounds, triangles: bool) -> bool {
        if self.occluders.is_empty() || bounds.is_empty() {
            return false;
        }
        let Some(Bounds { min, max }) = widened(bounds) else { return false };
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let depth = self.depth_normal.dot(center) + self.depth_shift;
        let reach = self.depth_normal.abs().dot(half);
        let (nearest, farthest) = (depth - reach, depth + reach);
        let wide = if self.perspective { farthest } else { 1.0 };
        let judged = farthest.abs() <= DEEPEST * self.farthest
            && (!self.perspective || nearest > 0.0 && farthest <= DEEPEST * nearest);
        if !judged {
            return false;
        }
        let grown = if triangles { OVERSHOOT } else { ENLARGED };
        self.occluders.iter().any(|occluder| {
            occluder.behind.iter().all(|plane| {
                let plane = if triangles { self.moved_to(plane, nearest) } else { *plane };
                plane.holds(center, half, wide, grown)
            }) && occluder.edges.iter().all(|edge| edge.holds(center, half, wide, grown))
        })
    }

    /// The plane as if every point were as near as the nearest: depths within a sliver are also noise, but
    /// between the depths of its corners.
    fn moved_to(&self, plane: &Plane, nearest: f64) -> Plane {
        let (share, kept) = if self.perspective { (1.0 / nearest, 1.0) } else { (1.0, nearest) };
        Plane {
            normal: plane.normal - self.depth_normal * share,
            shift: plane.shift - self.depth_shift * share + kept,
            ..*plane
        }
    }
}

/// A polygon in a view.
struct ViewPolygon {
    count: usize,
    /// Corners in view space \[m\], and in the map \[texels\] in the order that makes the area positive.
    at: [DVec3; 4],
    map: [DVec2; 4],
    /// Least and largest depth \[m\].
    depths: [f64; 2],
    /// Area in the map [texels²].
    area: f64,
    /// Largest distance between corners \[texels\].
    farthest: f64,
    /// Factor of rounding in wide maps.
    wide: f64,
    /// Rounding of a depth \[m\], and of a corner \[texels\].
    along: f64,
    corner: f64,
}

/// A view in 64-bit numbers.
struct WideView {
    axes: [DVec3; 3],
    shift: DVec3,
    /// Size of the map \[texels\].
    size: DVec2,
    scale: f64,
    near: f64,
    far: f64,
    perspective: bool,
}

impl WideView {
    fn new(view: &GpuView) -> Option<Self> {
        let (axes, shift) = rigid_axes(view)?;
        let [near, far, scale] = [view.near, view.far, view.scale].map(f64::from);
        let frame = Self {
            axes,
            shift,
            size: view.size.as_dvec2(),
            scale,
            near,
            far,
            perspective: view.perspective > 0.0,
        };
        (far > near && scale > 0.0 && (!frame.perspective || near > 0.0)).then_some(frame)
    }

    /// View-space right, up, and depth.
    fn view_space(&self, point: Vec3) -> DVec3 {
        let point = point.as_dvec3();
        let [x, y, back] = self.axes.map(|axis| axis.dot(point));
        DVec3::new(x + self.shift.x, y + self.shift.y, -(back + self.shift.z))
    }

    /// The plane where a linear function of view space is 0.
    fn plane(&self, of: DVec3, constant: f64) -> Plane {
        let [right, up, back] = self.axes;
        let shift = constant + of.dot(self.shift * DVec3::new(1.0, 1.0, -1.0));
        let normal = right * of.x + up * of.y - back * of.z;
        let fixed = of.length() * f64::from(ROUNDING) * self.shift.abs().element_sum();
        Plane { normal, shift, fixed, rounding: 0.0, texel: of.length() / self.scale }
    }

    /// The polygon in the view; `None` if not wholly in the depth range, edge-on, not finite, or outside the
    /// map.
    fn occluder(&self, polygon: &Polygon) -> Option<Occluder> {
        let outline = self.outline(polygon)?;
        let (behind, edges) = (self.behind(&outline)?, self.edges(&outline)?);
        Some(Occluder { behind, edges, area: outline.area })
    }

    fn outline(&self, polygon: &Polygon) -> Option<ViewPolygon> {
        let rounding = f64::from(ROUNDING);
        let n = polygon.count;
        let mut at = polygon.corners.map(|corner| self.view_space(corner));
        let depths = || at[..n].iter().map(|corner| corner.z);
        let first = depths().fold(f64::INFINITY, f64::min);
        let last = depths().fold(f64::NEG_INFINITY, f64::max);
        let largest = polygon.corners[..n].iter().fold(Vec3::ZERO, |all, c| all.max(c.abs()));
        let coordinates = self.shift.abs().element_sum() + largest.as_dvec3().element_sum();
        // Wide maps lose more precision: terms of discs cancel.
        let spread = (self.size * 0.5 / self.scale).length_squared();
        let wide = if self.perspective { 1.0 + spread } else { 1.0 };
        let along = rounding * wide * (coordinates + self.near.abs() + self.far.abs());
        // Written so that a NaN is refused.
        if !(first > self.near + along && last < self.far - along) {
            return None;
        }
        let middle = self.size * 0.5;
        let mut map = at.map(|corner| {
            let per_metre = self.scale / if self.perspective { corner.z } else { 1.0 };
            DVec2::new(corner.x, -corner.y) * per_metre + middle
        });
        if (map[1] - map[0]).perp_dot(map[n - 1] - map[0]) < 0.0 {
            at[1..n].reverse();
            map[1..n].reverse();
        }
        let low = map[..n].iter().fold(DVec2::INFINITY, |a, &b| a.min(b));
        let high = map[..n].iter().fold(DVec2::NEG_INFINITY, |a, &b| a.max(b));
        let inside = high.min(self.size) - low.max(DVec2::ZERO);
        let whole = (2..n).map(|i| (map[i - 1] - map[0]).perp_dot(map[i] - map[0])).sum::<f64>();
        let area = (whole * 0.5).min(inside.x * inside.y);
        if !(inside.min_element() > 0.0 && area >= MIN_AREA) {
            return None;
        }
        let farthest = map[..n].iter().flat_map(|a| map[..n].iter().map(|b| a.distance(*b)));
        let farthest = farthest.fold(0.0, f64::max);
        let slope = (low.abs().max(high.abs()) + self.size).element_sum() / self.scale;
        let of_corners = if self.perspective { (1.0 + slope) / first } else { 1.0 };
        let reach = (low.abs().max(high.abs()) + self.size).element_sum();
        let corner = rounding * (coordinates * self.scale * of_corners + reach);
        Some(ViewPolygon {
            count: n,
            at,
            map,
            depths: [first, last],
            area,
            farthest,
            wide,
            along,
            corner,
        })
    }

    /// Planes through the edges; `None` unless the outline is convex, since the two triangles then form no
    /// polygon.
    fn edges(&self, outline: &ViewPolygon) -> Option<Vec<Plane>> {
        let &ViewPolygon { count: n, map, farthest, wide, corner, .. } = outline;
        let edge = |i: usize| {
            let (a, b, c) = (map[i], map[(i + 1) % n], map[(i + 2) % n]);
            let turn = (b - a).perp_dot(c - b);
            if turn.is_nan() || turn <= 0.0 {
                return None;
            }
            let length = a.distance(b);
            let inwards = (b - a).perp() / length;
            let constant = inwards.dot(self.size * 0.5 - a);
            let flat = DVec3::new(inwards.x, -inwards.y, 0.0) * self.scale;
            let plane = if self.perspective {
                self.plane(flat + DVec3::Z * constant, 0.0)
            } else {
                self.plane(flat, constant)
            };
            let rounding = corner * (1.0 + 2.0 * farthest / length)
                + f64::from(ROUNDING) * (farthest + wide * self.size.element_sum());
            Some(Plane { rounding, ..plane })
        };
        (0..n).map(edge).collect()
    }

    /// Planes of the one or two triangles; `None` for a sliver.
    fn behind(&self, outline: &ViewPolygon) -> Option<Vec<Plane>> {
        let &ViewPolygon { at, map, depths: [first, last], farthest, along, corner, .. } = outline;
        let triangle = |part: &[usize; 3]| {
            let [a, b, c] = part.map(|i| map[i]);
            let height =
                (b - a).perp_dot(c - a) / a.distance(b).max(b.distance(c)).max(c.distance(a));
            let share = 3.0 * (corner + f64::from(ROUNDING) * farthest) / height;
            if !(share > 0.0 && share <= WORST_SHARE) {
                return None;
            }
            let [a, b, c] = part.map(|i| at[i]);
            let normal = (b - a).cross(c - a);
            let height = normal.dot(a);
            let most = if self.perspective { last / first } else { 1.0 };
            let along = 2.0 * along + share * (last - first) * most;
            // 1 / depth of a plane is linear in a perspective map.
            let (plane, rounding) = if self.perspective {
                (self.plane(normal / height, -1.0), along / (first * first))
            } else {
                (self.plane(normal / normal.z, -height / normal.z), along)
            };
            plane.normal.is_finite().then_some(Plane { rounding, ..plane })
        };
        let parts: &[[usize; 3]] =
            if outline.count == 4 { &[[0, 1, 3], [1, 2, 3]] } else { &[[0, 1, 2]] };
        parts.iter().map(triangle).collect()
    }
}
