//! CPU reference of `wgsl/caustics/*.wgsl`: light that glass refracts onto opaque surfaces.
//!
//! For each texel of a light's map (Wyman and Davis 2006; Szirmay-Kalos et al. 2005): the nearest glass face
//! by which light enters, if it is in front of the opaque surface, bends the texel's rays by its normal; the
//! map's nearest faces by which light leaves bend them again where the rays meet them; where the rays meet
//! the opaque depths, their light is added to four texels. That light is the light of the texel's straight
//! ray there, with its colour and its losses.
use crate::threads::each;
use glam::{Vec2, Vec3, Vec4};
use gobo::records::{CausticTexel, GlassFace, GpuView, NO_FACE, THROWN_BIT, ViewMaps, add_caustic};

/// Doublings of the path inside a body until the ray is outside.
pub const DOUBLINGS: u32 = 16;
/// Halvings that find a crossing.
pub const HALVINGS: u32 = 14;
/// Steps from glass to the far plane.
pub const STEPS: u32 = 64;
/// Distance in front of a lamp \[m\]: a face with a corner closer or behind has no position in its map.
pub const AHEAD: f32 = 1e-4;
/// Least weight of a corner, below 0 so that rounding leaves no gap between neighbours.
pub const LEAST_WEIGHT: f32 = -1e-5;
/// Largest distance of a receiver from the opaque surface that light lands on \[texels\].
pub const NEAR_SURFACE: f32 = 4.0;

/// A map's nearest faces by which light enters, or leaves, a body.
struct NearestFaces {
    /// Light depth; 1 without a face.
    depths: Vec<f32>,
    faces: Vec<u32>,
}

/// A face in a view's space.
#[derive(Clone, Copy)]
struct ViewFace {
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    ior: f32,
    /// Normal of its plane, of any length.
    normal: Vec3,
}

impl ViewFace {
    fn new(view: &GpuView, face: &GlassFace) -> Self {
        let place = |v: Vec4| view.view_from_world.transform_point3(v.truncate());
        let turn = |v: Vec4| view.view_from_world.transform_vector3(v.truncate());
        let corners = face.corners.map(place);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        Self { corners, normals: face.normals.map(turn), ior: face.corners[0].w, normal }
    }

    /// Distance along the axis at which the ray through `texel` meets its plane, and the weights of the
    /// corners.
    fn meets(&self, view: &GpuView, texel: Vec2) -> Option<(f32, Vec3)> {
        let [a, b, c] = self.corners;
        let (start, step) = ray(view, texel);
        let slope = self.normal.dot(step);
        let along = self.normal.dot(a - start) / slope;
        let off = start + step * along - a;
        let square = self.normal.length_squared();
        let second = off.cross(c - a).dot(self.normal) / square;
        let third = (b - a).cross(off).dot(self.normal) / square;
        let weights = Vec3::new(1.0 - second - third, second, third);
        (slope != 0.0 && square > 0.0).then_some((along, weights))
    }

    /// Unit normal at a point, on the side that `ray` comes from.
    fn normal_at(&self, weights: Vec3, ray: Vec3) -> Vec3 {
        let weights = weights.max(Vec3::ZERO);
        let [a, b, c] = self.normals;
        let round = a * weights.x + b * weights.y + c * weights.z;
        let flat = if self.normal.dot(ray) < 0.0 { self.normal } else { -self.normal };
        let round = if round.dot(flat) < 0.0 { -round } else { round };
        let is_toward = round.dot(ray) < 0.0;
        (if is_toward { round } else { flat }).normalize_or(-ray)
    }
}

/// Start of the ray through a point of the map, view space, and its step per metre along the axis.
fn ray(view: &GpuView, texel: Vec2) -> (Vec3, Vec3) {
    let slope = (texel - view.size * 0.5) / view.scale;
    let aside = Vec3::new(slope.x, -slope.y, 0.0);
    if view.perspective > 0.0 { (Vec3::ZERO, aside + Vec3::NEG_Z) } else { (aside, Vec3::NEG_Z) }
}

/// Position in the map of a point in view space \[texels\].
pub(super) fn place(view: &GpuView, point: Vec3) -> Vec2 {
    let spread = view.scale / if view.perspective > 0.0 { (-point.z).max(1e-6) } else { 1.0 };
    Vec2::new(point.x, -point.y) * spread + view.size * 0.5
}

fn depth(view: &GpuView, along: f32) -> f32 {
    (along - view.near) / (view.far - view.near)
}

/// Index of the texel at a position in the map; `None` outside.
pub(super) fn index_at(view: &GpuView, place: Vec2) -> Option<usize> {
    let inside = place.cmpge(Vec2::ZERO).all() && place.cmplt(view.size).all();
    inside.then(|| place.y as usize * view.size.x as usize + place.x as usize)
}

/// Direction refracted by Snell's law; `ratio`: `n1 / n2`; `None` at total reflection. Unit vectors; `normal`
/// is on the ray's side.
fn refracted(ray: Vec3, normal: Vec3, ratio: f32) -> Option<Vec3> {
    let cosine = -ray.dot(normal);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (rest >= 0.0).then(|| (ray * ratio + normal * (ratio * cosine - rest.sqrt())).normalize())
}

/// The nearest faces of each texel: those by which light enters, then those by which it leaves.
fn nearest_faces(view: &GpuView, faces: &[ViewFace], opaque: &[f32]) -> [NearestFaces; 2] {
    let none =
        || NearestFaces { depths: vec![1.0; opaque.len()], faces: vec![NO_FACE; opaque.len()] };
    let mut nearest = [none(), none()];
    for (number, face) in (0..).zip(faces) {
        // A face that reaches behind a lamp has no position in its map.
        if view.perspective > 0.0 && face.corners.iter().any(|corner| -corner.z < AHEAD) {
            continue;
        }
        let places = face.corners.map(|corner| place(view, corner));
        let least = places.into_iter().fold(view.size, Vec2::min).floor().max(Vec2::ZERO);
        let last = places.into_iter().fold(Vec2::ZERO, Vec2::max).ceil().min(view.size);
        for y in least.y as usize..last.y as usize {
            for x in least.x as usize..last.x as usize {
                let texel = Vec2::new(x as f32, y as f32) + 0.5;
                let Some((along, weights)) = face.meets(view, texel) else { continue };
                let (at, z) = (y * view.size.x as usize + x, depth(view, along));
                let (_, step) = ray(view, texel);
                let leaves = face.normal.dot(step) > 0.0;
                let list = &mut nearest[usize::from(leaves)];
                if weights.min_element() >= LEAST_WEIGHT
                    && z >= 0.0
                    && z < opaque[at]
                    && z < list.depths[at]
                {
                    (list.depths[at], list.faces[at]) = (z, number);
                }
            }
        }
    }
    nearest
}

/// Refracting faces of a map, and the opaque surfaces that their light lands on.
struct Glass<'a> {
    view: &'a GpuView,
    faces: &'a [ViewFace],
    enters: &'a NearestFaces,
    leaves: &'a NearestFaces,
    opaque: &'a [f32],
}

impl Glass<'_> {
    /// Position at which the ray through `texel` lands if it enters by `face`.
    fn lands(&self, texel: Vec2, face: &ViewFace) -> Option<Vec2> {
        let (along, weights) = face.meets(self.view, texel)?;
        let (start, step) = ray(self.view, texel);
        let (point, straight) = (start + step * along, step.normalize());
        let inside = refracted(straight, face.normal_at(weights, straight), 1.0 / face.ior)?;
        let Some((point, face)) = self.way_out(point, inside) else {
            return self.meets_opaque(point, inside);
        };
        let (_, weights) = face.meets(self.view, place(self.view, point))?;
        let outside = refracted(inside, face.normal_at(weights, inside), face.ior)?;
        self.meets_opaque(point, outside)
    }

    /// Depth of a point's nearest leaving face, at its texel, minus the point's; below 0 outside of all
    /// bodies.
    fn left(&self, point: Vec3) -> f32 {
        let at = index_at(self.view, place(self.view, point));
        let Some(at) = at.filter(|&at| self.leaves.faces[at] != NO_FACE) else { return -1.0 };
        self.leaves.depths[at] - depth(self.view, -point.z)
    }

    /// Point and face at which a ray inside a body leaves it; `None` for a surface without a body behind it.
    fn way_out(&self, start: Vec3, ray: Vec3) -> Option<(Vec3, &ViewFace)> {
        let at = index_at(self.view, place(self.view, start))?;
        if self.leaves.faces[at] == NO_FACE {
            return None;
        }
        let texel = if self.view.perspective > 0.0 { -start.z } else { 1.0 } / self.view.scale;
        let (mut near, mut far) = (0.0, texel);
        for _ in 0..DOUBLINGS {
            if self.left(start + ray * far) < 0.0 {
                break;
            }
            (near, far) = (far, 2.0 * far);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            let is_out = self.left(start + ray * middle) < 0.0;
            *(if is_out { &mut far } else { &mut near }) = middle;
        }
        let point = start + ray * near;
        let at = index_at(self.view, place(self.view, point))?;
        let face = self.leaves.faces[at];
        (face != NO_FACE).then(|| (point, &self.faces[face as usize]))
    }

    /// Depth of a point minus that of the opaque surface at its texel \[m\]; `None` outside of the map.
    fn behind(&self, point: Vec3) -> Option<f32> {
        let at = index_at(self.view, place(self.view, point))?;
        let along = self.view.near + self.opaque[at] * (self.view.far - self.view.near);
        Some(-point.z - along)
    }

    /// First position at which a ray meets the opaque depths.
    fn meets_opaque(&self, start: Vec3, ray: Vec3) -> Option<Vec2> {
        if ray.z >= 0.0 {
            return None;
        }
        let view = self.view;
        // Slightly beyond the far plane: a texel without a surface is never met.
        let step = (view.far + start.z) / (STEPS as f32 * -ray.z);
        let mut before = false;
        for i in 0..=STEPS {
            let along = step * i as f32;
            let is_behind = self.behind(start + ray * along)? >= 0.0;
            if is_behind && !before {
                let (mut near, mut far) = ((along - step).max(0.0), along);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (near + far);
                    let is_behind = self.behind(start + ray * middle)? >= 0.0;
                    *(if is_behind { &mut far } else { &mut near }) = middle;
                }
                let point = start + ray * far;
                let texel = if view.perspective > 0.0 { -point.z } else { 1.0 } / view.scale;
                let at = index_at(view, place(view, point))?;
                // Past the edge of something nearer, the ray continues behind it.
                let is_surface = self.behind(point)? < NEAR_SURFACE * texel;
                if is_surface && self.opaque[at] < 1.0 {
                    return Some(place(view, point));
                }
            }
            before = is_behind;
        }
        None
    }
}

/// Light that lands in each texel of a view's map. `rays`: along the edge of a texel.
pub fn thrown(
    view: &GpuView,
    maps: &ViewMaps,
    faces: &[GlassFace],
    rays: u32,
) -> Vec<CausticTexel> {
    let faces: Vec<_> = faces.iter().map(|face| ViewFace::new(view, face)).collect();
    let [enters, leaves] = &nearest_faces(view, &faces, &maps.opaque);
    let glass = Glass { view, faces: &faces, enters, leaves, opaque: &maps.opaque };
    let (width, height) = (view.size.x as usize, view.size.y as usize);
    let of_row = |y: usize| {
        let of_texel = |x: usize| {
            let at = y * width + x;
            let face = glass.enters.faces[at];
            let face = (face != NO_FACE).then(|| &faces[face as usize]);
            let all = face.into_iter().flat_map(|face| (0..rays * rays).map(move |i| (i, face)));
            let glass = &glass;
            all.filter_map(move |(i, face)| {
                let part = Vec2::new((i % rays) as f32, (i / rays) as f32) + 0.5;
                let texel = Vec2::new(x as f32, y as f32) + part / rays as f32;
                Some((at, glass.lands(texel, face)?))
            })
        };
        (0..width).flat_map(of_texel).collect::<Vec<_>>()
    };
    let mut sums = vec![CausticTexel::default(); width * height];
    for (at, sum) in sums.iter_mut().enumerate() {
        sum[3] = if enters.faces[at] == NO_FACE { 0 } else { THROWN_BIT };
    }
    for (at, place) in each(height, of_row).into_iter().flatten() {
        let light = Vec3::from_array(maps.filter[at]) / (rays * rays) as f32;
        let corner = (place - 0.5).floor();
        let part = place - 0.5 - corner;
        for (aside, weight) in [
            (Vec2::ZERO, (1.0 - part.x) * (1.0 - part.y)),
            (Vec2::X, part.x * (1.0 - part.y)),
            (Vec2::Y, (1.0 - part.x) * part.y),
            (Vec2::ONE, part.x * part.y),
        ] {
            let inside = (corner + aside).clamp(Vec2::ZERO, view.size - 1.0);
            let to = inside.y as usize * width + inside.x as usize;
            add_caustic(&mut sums[to], light * weight);
        }
    }
    sums
}
