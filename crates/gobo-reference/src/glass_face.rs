//! CPU reference of `wgsl/caustics/glass_face.wgsl` and `wgsl/caustics/glass_faces.wgsl`: faces in the space
//! of a light's rays, and the nearest of them in each texel.
use crate::{caustics::place, light_views::LightViews};
use glam::{Vec2, Vec3, Vec4};
use gobo::records::{GlassFace, NO_FACE};

/// Distance in front of a lamp \[m\] from which faces have a position in its map.
pub const AHEAD: f32 = 1e-4;
/// Least weight of a corner, below 0 so that rounding leaves no gap between neighbours.
pub const LEAST_WEIGHT: f32 = -1e-5;
/// Weight of a corner up to which a face's normals are continued beyond it.
pub const FARTHEST_WEIGHT: f32 = 2.0;

/// A map's nearest faces by which light enters, or leaves, a body.
pub(crate) struct NearestFaces {
    /// Light depth; 1 without a face.
    pub(crate) depths: Vec<f32>,
    pub(crate) faces: Vec<u32>,
}

/// A face in the space of the rays.
#[derive(Clone, Copy)]
pub(crate) struct RayFace {
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    pub(crate) ior: f32,
    /// Added to it for blue light, and taken away for red.
    pub(crate) spread: f32,
    /// Normal of its plane, of any length.
    normal: Vec3,
}

impl RayFace {
    pub(crate) fn new(views: &LightViews<'_>, face: &GlassFace) -> Self {
        let corners = face.corners.map(|corner| views.in_rays(corner.truncate()));
        let normals = face.normals.map(|normal: Vec4| views.turned(normal.truncate()));
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        Self { corners, normals, ior: face.corners[0].w, spread: face.corners[1].w, normal }
    }

    pub(crate) fn weights_at(&self, point: Vec3) -> Vec3 {
        let [a, b, c] = self.corners;
        let off = point - a;
        let square = self.normal.length_squared();
        let second = off.cross(c - a).dot(self.normal) / square;
        let third = (b - a).cross(off).dot(self.normal) / square;
        Vec3::new(1.0 - second - third, second, third)
    }

    /// Steps along a ray at which it meets the plane, and the weights of the corners.
    pub(crate) fn meets(&self, start: Vec3, step: Vec3) -> Option<(f32, Vec3)> {
        let slope = self.normal.dot(step);
        let along = self.normal.dot(self.corners[0] - start) / slope;
        let is_met = slope != 0.0 && self.normal.length_squared() > 0.0;
        is_met.then(|| (along, self.weights_at(start + step * along)))
    }

    /// Unit normal at a point, on the side that `ray` comes from.
    pub(crate) fn normal_at(&self, weights: Vec3, ray: Vec3) -> Vec3 {
        let farthest = Vec3::splat(FARTHEST_WEIGHT);
        let weights = weights.clamp(1.0 - farthest, farthest);
        let [a, b, c] = self.normals;
        let round = a * weights.x + b * weights.y + c * weights.z;
        let flat = if self.normal.dot(ray) < 0.0 { self.normal } else { -self.normal };
        let round = if round.dot(flat) < 0.0 { -round } else { round };
        let is_toward = round.dot(ray) < 0.0;
        (if is_toward { round } else { flat }).normalize_or(-ray)
    }

    /// Least and largest position in the map of a view \[texels\].
    fn extent(&self, views: &LightViews<'_>, number: usize) -> (Vec2, Vec2) {
        let view = &views.views[number];
        let end = if view.perspective > 0.0 { -AHEAD } else { f32::INFINITY };
        let corners = self.corners.map(|corner| views.in_view(number, corner));
        let (mut least, mut last) = (view.size, Vec2::ZERO);
        let mut add = |point: Vec3| {
            let place = place(view, point);
            (least, last) = (least.min(place), last.max(place));
        };
        for (i, &corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % 3];
            if corner.z <= end {
                add(corner);
            }
            // An edge that reaches behind the lamp ends in front of it.
            if (corner.z <= end) != (next.z <= end) {
                add(corner.lerp(next, (end - corner.z) / (next.z - corner.z)));
            }
        }
        (least, last)
    }
}

/// The nearest faces of each texel of a view: those by which light enters, then those by which it leaves.
/// Without `opaque` depths, of solid faces: the nearest of either side, then none.
pub(crate) fn nearest_faces(
    views: &LightViews<'_>,
    number: usize,
    faces: &[RayFace],
    opaque: Option<&[f32]>,
) -> [NearestFaces; 2] {
    let view = &views.views[number];
    let texels = view.size.x as usize * view.size.y as usize;
    let none = || NearestFaces { depths: vec![1.0; texels], faces: vec![NO_FACE; texels] };
    let mut nearest = [none(), none()];
    for (index, face) in (0..).zip(faces) {
        let (least, last) = face.extent(views, number);
        let least = least.floor().clamp(Vec2::ZERO, view.size);
        let last = last.ceil().clamp(Vec2::ZERO, view.size);
        for y in least.y as usize..last.y as usize {
            for x in least.x as usize..last.x as usize {
                let texel = Vec2::new(x as f32, y as f32) + 0.5;
                let (start, step) = views.ray(number, texel);
                let Some((along, weights)) = face.meets(start, step) else { continue };
                let at = y * view.size.x as usize + x;
                let z = (along - view.near) / (view.far - view.near);
                let leaves = opaque.is_some() && face.normal.dot(step) > 0.0;
                let list = &mut nearest[usize::from(leaves)];
                if weights.min_element() >= LEAST_WEIGHT
                    && z >= 0.0
                    && z < opaque.map_or(1.0, |opaque| opaque[at])
                    && z < list.depths[at]
                {
                    (list.depths[at], list.faces[at]) = (z, index);
                }
            }
        }
    }
    nearest
}
