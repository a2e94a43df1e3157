//! CPU reference of `wgsl/project/project_particles.wgsl` and `wgsl/project/project_triangles.wgsl`.
use super::brick::BrickExtent;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles as _};
use gobo::{
    model::{Shape, Transfer},
    records::{
        BACK_BIT, CasterRecord, Footprint, GpuMaterial, GpuView, INVISIBLE, MIN_RADIUS,
        TRIANGLE_BIT, TileRect, TriangleRecord, TriangleSetup, octahedral,
    },
};

mod body;
mod tile_rect;

use body::{Appearance, Body};
pub(super) use tile_rect::tile_rect;

/// Margin around a footprint's box, so that rounding never loses a texel \[texels\].
pub const SLACK: f32 = 1.0 / 64.0;
/// A particle is *beside* the view if its depth along the axis is below this share of its distance from the
/// light: its centre has no position in the map.
pub const MIN_COSINE: f32 = 0.05;
/// Position of the line of an edge that is farther away \[texels\]: from there, no texel's position makes a
/// difference in 32 bits.
pub const FAR_EDGE: f32 = 1_099_511_627_776.0;
/// A brick's corners have positions in the map if the nearest is at least this far along the axis, as a share
/// of the farthest.
pub const BRICK_NEAR: f32 = 1e-3;

/// Result of `project` for one caster in one view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// The caster's footprint, which later stages read.
    pub footprint: Footprint,
    /// Quantised smallest depth; [`INVISIBLE`] if the caster touches no texel or is scattered.
    pub key: u32,
    /// Tiles that it may touch.
    pub rect: TileRect,
}

impl Projected {
    /// A caster that touches no texel.
    pub const INVISIBLE: Self = Self {
        footprint: Footprint {
            center: Vec2::ZERO,
            radius: 0.0,
            depth: 0.0,
            red_green: 0,
            blue_slope: 0,
            thin: 0,
            caster: 0,
        },
        key: INVISIBLE,
        rect: TileRect::EMPTY,
    };
}

/// Parameters of projection for a batch of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProjectParams {
    /// Whether particles that touch at most 2x2 texels are scattered. Off with order-dependent blending.
    pub scatter: bool,
    /// Whether casters without shadows are projected too, for the camera.
    pub include_non_casters: bool,
    /// Whether depth keys of perspective views are by distance from the light or the eye: for order-dependent
    /// blending, and for a camera that sees bricks.
    pub by_distance: bool,
}

/// The first of the 2x2 texels around `center` that a scattered caster may touch.
pub fn scatter_texel(center: Vec2) -> Vec2 {
    (center - 0.5).floor()
}

/// A box in the map, from centre to centre inclusive \[texels\].
#[derive(Clone, Copy, Debug)]
pub(super) struct TexelBox {
    pub(super) min: Vec2,
    pub(super) max: Vec2,
}

/// Depth key: quantised monotonically, so that a smaller depth never has a larger key.
pub fn depth_key(depth: f32) -> u32 {
    (depth.clamp(0.0, 1.0) * (INVISIBLE - 1) as f32) as u32
}

/// Projects one particle to view number `view_index` of its batch; `half_edges`: of a brick's box, world
/// space \[m\].
pub fn project_caster(
    view: &GpuView,
    view_index: u32,
    (caster, caster_id): (&CasterRecord, u32),
    material: &GpuMaterial,
    half_edges: Option<[Vec3; 3]>,
    params: ProjectParams,
) -> Projected {
    let shape = material.shape;
    let center = view.view_from_world.transform_point3(caster.center);
    let distance = -center.z;
    let range = view.far - view.near;
    // A sphere, or a box inside it.
    let is_round = shape == Shape::Puff as u32 || half_edges.is_some();
    let body = Body {
        center,
        radius: caster.radius,
        // A quad's diagonal reaches beyond its radius.
        corner: if shape == Shape::Quad as u32 { std::f32::consts::SQRT_2 } else { 1.0 },
        is_round,
    };
    let is_beside = body.is_beside(view);
    let Appearance { texel, radius, grow, mut bounds, depth_reach } = body.appearance(view);
    let mut nearest = (distance - depth_reach - view.near) / range;
    let mut farthest = (distance + depth_reach - view.near) / range;
    // The nearest point of a plane that faces the light is its centre.
    let mut least = center.length() - if is_round { depth_reach } else { 0.0 };
    if let Some(half_edges) = &half_edges {
        let extent = BrickExtent::new(view, half_edges, center);
        // Elsewhere the box of its bounding sphere is used.
        if view.perspective == 0.0 || extent.along[0] > BRICK_NEAR * extent.along[1] {
            bounds = TexelBox { min: extent.min, max: extent.max };
        }
        [nearest, farthest] = extent.along.map(|along| (along - view.near) / range);
        least = extent.least;
    }
    let by_distance = params.by_distance && view.perspective > 0.0;
    let front = if by_distance { view.distance_key(least) } else { nearest };
    let unseen = material.transfer == Transfer::None as u32 && !params.include_non_casters;
    if unseen || farthest < 0.0 || nearest > 1.0 {
        return Projected::INVISIBLE;
    }
    let round = shape != Shape::Quad as u32 && half_edges.is_none() && view.perspective == 0.0;
    let circle = if round { radius + SLACK } else { f32::INFINITY };
    // Only tiles can write opaque depths.
    let scatter = params.scatter && material.transfer < Transfer::Opaque as u32 && !is_beside;
    let Some(rect) = tile_rect(view, view_index, bounds, texel, circle, scatter) else {
        return Projected::INVISIBLE;
    };
    let color = caster.color(material.transfer) * material.tint;
    let thin = 1.0 / (grow * grow);
    let (center, radius, depth) = if is_beside {
        (Vec2::new(center.x, -center.y), -radius, distance)
    } else {
        (texel, radius, (distance - view.near) / range)
    };
    let caster = caster_id;
    let mut footprint =
        Footprint { center, radius, depth, caster, ..Projected::INVISIBLE.footprint };
    footprint.set_opacity(
        color.truncate().min(Vec3::ONE),
        material.transfer,
        thin,
        (1.0 - material.reflectivity) * color.w * thin,
    );
    let key = if rect.is_scattered() { INVISIBLE } else { depth_key(front) };
    Projected { footprint, key, rect }
}

/// Slopes between which a sphere of radius `sphere` at `(x, distance)` appears; unbounded if the eye is
/// inside.
pub(super) fn tangents(x: f32, distance: f32, sphere: f32) -> Vec2 {
    const ENDLESS: f32 = 1e6;
    let t2 = x * x + distance * distance - sphere * sphere;
    if t2 <= 0.0 {
        return Vec2::new(-ENDLESS, ENDLESS);
    }
    let t = t2.sqrt();
    let (low, low_depth) = (x * t - distance * sphere, distance * t + x * sphere);
    let (high, high_depth) = (x * t + distance * sphere, distance * t - x * sphere);
    Vec2::new(
        if low_depth > 0.0 { low / low_depth } else { -ENDLESS },
        if high_depth > 0.0 { high / high_depth } else { ENDLESS },
    )
}

/// Projects one triangle to one view, with its setup. `setup_index`: index of the setup.
pub fn project_triangle(
    view: &GpuView,
    view_index: u32,
    record: &TriangleRecord,
    triangle_id: u32,
    setup_index: u32,
    params: ProjectParams,
) -> (Projected, TriangleSetup) {
    let nothing = (Projected::INVISIBLE, TriangleSetup::default());
    let corners = record.positions_u.map(|p| view.view_from_world.transform_point3(p.xyz()));
    let distances = Vec3::new(-corners[0].z, -corners[1].z, -corners[2].z);
    let depths = (distances - view.near) / (view.far - view.near);
    // The back face of a volume also matters beyond the far plane.
    if depths.max_element() < 0.0 {
        return nothing;
    }
    let half = view.size * 0.5;
    let flat = corners.map(|p| Vec2::new(p.x, -p.y) * view.scale);
    let in_front = distances.to_array().map(|d| view.perspective == 0.0 || d >= view.near);
    let scale = if view.perspective > 0.0 { distances.recip() } else { Vec3::ONE };
    let p: [Vec2; 3] = std::array::from_fn(|i| flat[i] * scale[i] + half);
    let h = std::array::from_fn(|i| (flat[i] + distances[i] * half).extend(distances[i]));
    let mut setup = TriangleSetup {
        weights: scale,
        depths,
        material: record.material,
        uvs: std::array::from_fn(|i| Vec2::new(record.positions_u[i].w, record.v[i])),
        normal: face_normal(record),
        id: record.id,
        colors: record.colors,
        ..TriangleSetup::default()
    };
    if !set_edges(&mut setup, in_front, p, h) {
        return nothing;
    }
    let bounds = if in_front == [true; 3] {
        TexelBox { min: p[0].min(p[1]).min(p[2]), max: p[0].max(p[1]).max(p[2]) }
    } else {
        clipped_box(view, &flat, distances, half)
    };
    let bounds = TexelBox {
        min: bounds.min.clamp(Vec2::NEG_ONE, view.size + 1.0),
        max: bounds.max.clamp(Vec2::NEG_ONE, view.size + 1.0),
    };
    let center = (bounds.min + bounds.max) * 0.5;
    let Some(rect) = tile_rect(view, view_index, bounds, center, f32::INFINITY, false) else {
        return nothing;
    };
    let nearest = depths.min_element().max(0.0);
    let footprint = Footprint {
        center,
        radius: (bounds.max - bounds.min).max_element() * 0.5 + SLACK,
        depth: nearest,
        red_green: setup_index,
        blue_slope: 0,
        thin: 0,
        caster: triangle_id | TRIANGLE_BIT,
    };
    let front = if params.by_distance && view.perspective > 0.0 {
        view.distance_key(least_distance(corners))
    } else {
        nearest
    };
    (Projected { footprint, key: depth_key(front), rect }, setup)
}

/// Sets the edges of a triangle. `in_front`: whether each corner is in front of the near plane and so has a
/// position `p` in the map; `h`: homogeneous positions. Returns false for a triangle that is seen edge-on.
fn set_edges(setup: &mut TriangleSetup, in_front: [bool; 3], p: [Vec2; 3], h: [Vec3; 3]) -> bool {
    let crosses = in_front != [true; 3];
    let turn =
        if crosses { h[0].dot(h[1].cross(h[2])) } else { (p[1] - p[0]).perp_dot(p[2] - p[0]) };
    if turn == 0.0 {
        return false;
    }
    setup.ties = if turn > 0.0 { BACK_BIT } else { 0 };
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let is_line = in_front[j] && in_front[k];
        // Both triangles of a shared edge must start from the same corner, so that their edge functions are
        // exact negatives of each other.
        let forward =
            if is_line { precedes(p[j], p[k]) } else { precedes(h[j].truncate(), h[k].truncate()) };
        let (from, to) = if forward { (j, k) } else { (k, j) };
        let sign = if forward == (turn > 0.0) { 1.0 } else { -1.0 };
        setup.edges[i] = if is_line {
            let along = (p[to] - p[from]) * sign;
            Vec4::new(p[from].x, p[from].y, along.x, along.y)
        } else {
            edge_plane(h[from].cross(h[to]) * sign)
        };
        if crosses {
            setup.weights[i] = if is_line { h[j].z * h[k].z } else { 1.0 };
        }
        setup.ties |= u32::from(sign > 0.0) << i;
    }
    true
}

/// Edge with a corner that has no position in the map: a plane through the eye (Olano and Greer 1997, section
/// 3).
fn edge_plane(plane: Vec3) -> Vec4 {
    let along = Vec2::new(plane.y, -plane.x);
    let constant = plane.z / FAR_EDGE;
    if along.abs().max_element() > constant.abs() {
        let foot = plane.truncate() * (-plane.z / along.length_squared());
        Vec4::new(foot.x, foot.y, along.x, along.y)
    } else {
        // An edge in the plane through the eye across the axis is at infinity: its function is constant.
        Vec4::new(0.0, -FAR_EDGE, constant, 0.0)
    }
}

/// Least distance of a triangle's points from the origin.
fn least_distance(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let mut least = f32::INFINITY;
    let mut is_over = true;
    for i in 0..3 {
        let (from, along) = (corners[i], corners[(i + 1) % 3] - corners[i]);
        let part =
            (-from.dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        least = least.min((from + along * part).length());
        is_over &= normal.dot(along.cross(-from)) >= 0.0;
    }
    let height = normal.dot(a).abs() / normal.length().max(f32::MIN_POSITIVE);
    if is_over { height } else { least }
}

fn precedes(a: Vec2, b: Vec2) -> bool {
    a.x < b.x || (a.x == b.x && a.y < b.y)
}

/// Bounding box in the map of the part of a triangle beyond the near plane.
fn clipped_box(view: &GpuView, flat: &[Vec2; 3], distances: Vec3, half: Vec2) -> TexelBox {
    let mut bounds = TexelBox { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };
    let mut include = |p: Vec2, distance: f32| {
        let texel = p / distance + half;
        bounds = TexelBox { min: bounds.min.min(texel), max: bounds.max.max(texel) };
    };
    for i in 0..3 {
        let j = (i + 1) % 3;
        if distances[i] >= view.near {
            include(flat[i], distances[i]);
        }
        if (distances[i] >= view.near) != (distances[j] >= view.near) {
            let t = (view.near - distances[i]) / (distances[j] - distances[i]);
            include(flat[i] + (flat[j] - flat[i]) * t, view.near);
        }
    }
    bounds
}

fn face_normal(record: &TriangleRecord) -> u32 {
    let [a, b, c] = record.positions_u.map(Vec4::xyz);
    octahedral((b - a).cross(c - a).normalize_or_zero())
}
