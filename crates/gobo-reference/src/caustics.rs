//! CPU reference of `wgsl/caustics/*.wgsl`: light that glass refracts onto opaque surfaces.
//!
//! For each texel of a light's maps (Wyman and Davis 2006; Szirmay-Kalos et al. 2005): the nearest glass face
//! by which light enters, if it is in front of the opaque surface, bends the texel's rays by its normal; the
//! maps' nearest faces by which light leaves bend them again where the rays meet them; where the rays meet
//! the opaque depths, their light is added to the texels between the landing places of neighbouring rays.
//! The light is that of the texel's straight ray, with its colour and its losses. A ray may land in another
//! face of a cube. Where glass disperses light, red, green and blue are refracted apart.
use crate::{
    glass_face::{NearestFaces, RayFace, nearest_faces},
    light_views::LightViews,
    threads::each,
};
use glam::{UVec2, Vec2, Vec3};
use gobo::{
    model::{Scene, View, ViewRole},
    records::{
        CausticTexel, GlassFace, GpuView, NO_FACE, THROWN_BIT, ViewMaps, add_caustic,
        caustic_words, glass_faces,
    },
};

pub use crate::glass_face::{AHEAD, FARTHEST_WEIGHT, LEAST_WEIGHT};

/// Doublings of the path inside a body until the ray is outside.
pub const DOUBLINGS: u32 = 16;
/// Halvings that find a crossing.
pub const HALVINGS: u32 = 14;
/// Steps from glass to the far plane.
pub const STEPS: u32 = 64;
/// Faces that are tried at the point where a ray leaves a body.
pub const EXITS: u32 = 2;
/// Largest distance of a receiver from the opaque surface that light lands on \[texels\].
pub const NEAR_SURFACE: f32 = 4.0;
/// Most points along the edge of a texel that its light is divided into.
pub const MAX_PARTS: u32 = 32;
/// Largest edge of a ray's footprint \[texels\].
pub const MAX_FOOTPRINT: f32 = 64.0;
/// Edge of a footprint where the neighbouring ray lands nowhere, \[texels\].
pub const USUAL_FOOTPRINT: f32 = 8.0;

/// Position in the map of a point in view space \[texels\].
pub(super) fn place(view: &GpuView, point: Vec3) -> Vec2 {
    let spread = view.scale / if view.perspective > 0.0 { (-point.z).max(1e-6) } else { 1.0 };
    Vec2::new(point.x, -point.y) * spread + view.size * 0.5
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

/// A position in the map of a view \[texels\].
#[derive(Clone, Copy)]
struct Landed {
    number: usize,
    at: Vec2,
}

/// Refracting faces of a shadow's maps, and the opaque surfaces that their light lands on.
struct Glass<'a> {
    views: &'a LightViews<'a>,
    faces: &'a [RayFace],
    nearest: &'a [[NearestFaces; 2]],
    opaque: &'a [&'a [f32]],
}

impl Glass<'_> {
    /// Position at which the ray through `texel` of a view lands if it enters by `face`. `shift`: -1 for red
    /// light, 1 for blue.
    fn lands(&self, number: usize, texel: Vec2, face: &RayFace, shift: f32) -> Option<Landed> {
        let (start, step) = self.views.ray(number, texel);
        let (along, weights) = face.meets(start, step)?;
        let (point, straight) = (start + step * along, step.normalize());
        let ratio = 1.0 / (face.ior + shift * face.spread);
        let inside = refracted(straight, face.normal_at(weights, straight), ratio)?;
        let Some((point, face, weights)) = self.way_out(point, inside) else {
            return self.meets_opaque(point, inside);
        };
        let ratio = face.ior + shift * face.spread;
        let outside = refracted(inside, face.normal_at(weights, inside), ratio)?;
        self.meets_opaque(point, outside)
    }

    /// The nearest leaving face at a point's texel.
    fn leaving(&self, point: Vec3) -> Option<(usize, usize)> {
        let seen = self.views.seen(point);
        let index = index_at(&self.views.views[seen.number], seen.place)?;
        let face = self.nearest[seen.number][1].faces[index];
        (face != NO_FACE).then_some((index, face as usize))
    }

    /// Depth of a point's nearest leaving face, at its texel, minus the point's; below 0 outside of all
    /// bodies.
    fn left(&self, point: Vec3) -> f32 {
        let Some((index, _)) = self.leaving(point) else { return -1.0 };
        let seen = self.views.seen(point);
        let view = &self.views.views[seen.number];
        let own = (-seen.point.z - view.near) / (view.far - view.near);
        self.nearest[seen.number][1].depths[index] - own
    }

    /// Point and face at which a ray inside a body leaves it, with the weights of the corners; `None` for a
    /// surface without a body behind it.
    fn way_out(&self, start: Vec3, ray: Vec3) -> Option<(Vec3, &RayFace, Vec3)> {
        self.leaving(start)?;
        let edge = self.views.texel_at(start);
        let (mut near, mut far) = (0.0, edge);
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
        // Depths are those of whole texels; the face's plane is exact.
        let mut left = None;
        let mut point = start + ray * near;
        for _ in 0..EXITS {
            let Some((_, face)) = self.leaving(point) else { continue };
            let face = &self.faces[face];
            let (along, _) = face.meets(start, ray)?;
            let is_near = (along - near).abs() < (4.0 * edge).max(0.5 * near);
            point = start + ray * if is_near { along } else { near };
            left = Some((point, face, face.weights_at(point)));
        }
        left
    }

    /// Depth of the opaque surface at a position in a map, clamped to it \[m\].
    fn opaque_along(&self, number: usize, place: Vec2) -> f32 {
        let view = &self.views.views[number];
        view.near + self.opaque_depth(number, place) * (view.far - view.near)
    }

    fn opaque_depth(&self, number: usize, place: Vec2) -> f32 {
        let view = &self.views.views[number];
        let texel = place.clamp(Vec2::ZERO, view.size - 1.0).as_uvec2();
        self.opaque[number][texel.y as usize * view.size.x as usize + texel.x as usize]
    }

    /// Depth of a point minus that of the opaque surface at its texel \[m\]; `None` outside of the maps.
    fn behind(&self, point: Vec3) -> Option<f32> {
        let seen = self.views.seen(point);
        index_at(&self.views.views[seen.number], seen.place)?;
        Some(-seen.point.z - self.opaque_along(seen.number, seen.place))
    }

    /// Position at which the ray to a point on a surface, as deep as its texel, meets the plane through the
    /// surface's depths around it.
    fn on_plane(&self, point: Vec3, ray: Vec3) -> Option<Landed> {
        let seen = self.views.seen(point);
        let number = seen.number;
        let middle = seen.place.floor() + 0.5;
        let depth = self.opaque_along(number, middle);
        let slope = [Vec2::X, Vec2::Y].map(|axis| {
            let before = depth - self.opaque_along(number, middle - axis);
            let behind = self.opaque_along(number, middle + axis) - depth;
            if before.abs() < behind.abs() { before } else { behind }
        });
        let slope = Vec2::from_array(slope);
        let edge = self.views.texel_at(point);
        let before = self.views.seen_in(number, point - ray * edge);
        let past = -seen.point.z - depth - slope.dot(seen.place - middle);
        let short = -before.point.z - depth - slope.dot(before.place - middle);
        let steps = (past / (past - short).max(0.05 * edge)).clamp(-2.0, 2.0);
        let met = self.views.seen(point - ray * (steps * edge));
        index_at(&self.views.views[met.number], met.place)?;
        Some(Landed { number: met.number, at: met.place })
    }

    /// First position at which a ray meets the opaque depths.
    fn meets_opaque(&self, start: Vec3, ray: Vec3) -> Option<Landed> {
        if !self.views.is_cube() && ray.z >= 0.0 {
            return None;
        }
        let step = self.views.way_to_end(start, ray) / STEPS as f32;
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
                let seen = self.views.seen(point);
                // Past the edge of something nearer, the ray continues behind it.
                let is_surface = self.behind(point)? < NEAR_SURFACE * self.views.texel_at(point);
                if is_surface && self.opaque_depth(seen.number, seen.place) < 1.0 {
                    return self.on_plane(point, ray);
                }
            }
            before = is_behind;
        }
        None
    }

    /// A position beside a map of a cube, in the map of the face that sees it.
    fn on_map(&self, number: usize, at: Vec2) -> Landed {
        let is_beside = index_at(&self.views.views[number], at).is_none();
        if !(self.views.is_cube() && is_beside) {
            return Landed { number, at };
        }
        let seen = self.views.seen(self.views.ray(number, at).1);
        Landed { number: seen.number, at: seen.place }
    }

    /// Adds the light of a ray to `parts`: to the texels around points of its footprint. `rest`: what
    /// rounding left of the texel's light before.
    fn throw(&self, ray: &GlassRay, rest: &mut Vec3, parts: &mut Vec<Part>) {
        let &GlassRay { number, texel, edge, face, shift, light } = ray;
        let Some(landed) = self.lands(number, texel, face, shift) else { return };
        let way = |aside: Vec2| {
            let to = self.lands(number, texel + aside * edge, face, shift);
            let way = to.map_or(aside * USUAL_FOOTPRINT, |to| {
                if to.number == landed.number {
                    return to.at - landed.at;
                }
                let (_, ray) = self.views.ray(to.number, to.at);
                let ray = self.views.in_view(landed.number, ray);
                place(&self.views.views[landed.number], ray) - landed.at
            });
            way * (MAX_FOOTPRINT / way.length().max(1e-6)).min(1.0)
        };
        let (across, down) = (way(Vec2::X), way(Vec2::Y));
        let wide = across.abs().max(down.abs()).max_element();
        let rays = (1.0 / edge).round() as u32;
        let count = (wide.ceil() as u32).clamp(1, MAX_PARTS / rays);
        let spread = self.views.texel_share(number, texel)
            / self.views.texel_share(landed.number, landed.at);
        let light = light * spread / (count * count) as f32;
        for k in 0..count * count {
            let part = Vec2::new((k % count) as f32, (k / count) as f32) + 0.5;
            let part = part / count as f32 - 0.5;
            let Landed { number, at } =
                self.on_map(landed.number, landed.at + across * part.x + down * part.y);
            let size = self.views.views[number].size;
            let corner = (at - 0.5).floor();
            let far = at - 0.5 - corner;
            let near = 1.0 - far;
            for (aside, weight) in [
                (Vec2::ZERO, near.x * near.y),
                (Vec2::X, far.x * near.y),
                (Vec2::Y, near.x * far.y),
                (Vec2::ONE, far.x * far.y),
            ] {
                let inside = (corner + aside).clamp(Vec2::ZERO, size - 1.0);
                let index = inside.y as usize * size.x as usize + inside.x as usize;
                let light = caustic_words(light * weight, rest);
                parts.push(Part { number, index, light });
            }
        }
    }
}

/// Light that lands in a texel.
struct Part {
    number: usize,
    index: usize,
    light: [u32; 3],
}

/// A ray of a texel.
struct GlassRay<'a> {
    number: usize,
    texel: Vec2,
    /// Distance to the next ray \[texels\].
    edge: f32,
    face: &'a RayFace,
    shift: f32,
    light: Vec3,
}

/// Light that lands in each texel of a shadow's views: one view, or the faces of a cube. `filters` and
/// `opaque`: of their maps; `rays`: along the edge of a texel.
pub fn thrown(
    views: &[GpuView],
    filters: &[&[[f32; 3]]],
    opaque: &[&[f32]],
    faces: &[GlassFace],
    rays: u32,
) -> Vec<Vec<CausticTexel>> {
    let views = &LightViews { views };
    let faces: Vec<_> = faces.iter().map(|face| RayFace::new(views, face)).collect();
    let nearest: Vec<_> = (0..views.views.len())
        .map(|number| nearest_faces(views, number, &faces, Some(opaque[number])))
        .collect();
    let glass = Glass { views, faces: &faces, nearest: &nearest, opaque };
    let owned = |[enters, _]: &[NearestFaces; 2]| {
        let start = |&face: &u32| [0, 0, 0, if face == NO_FACE { 0 } else { THROWN_BIT }];
        enters.faces.iter().map(start).collect::<Vec<CausticTexel>>()
    };
    let mut sums: Vec<_> = nearest.iter().map(owned).collect();
    for number in 0..views.views.len() {
        let size = views.views[number].size.as_uvec2();
        let of_row = |y: usize| {
            let mut parts = Vec::new();
            for x in 0..size.x as usize {
                let at = y * size.x as usize + x;
                let face = nearest[number][0].faces[at];
                let Some(face) = faces.get(face as usize) else { continue };
                let edge = 1.0 / rays as f32;
                let whole = Vec3::from_array(filters[number][at]) * (edge * edge);
                let channels = [(-1.0, Vec3::X), (0.0, Vec3::Y), (1.0, Vec3::Z)];
                let all = [(0.0, Vec3::ONE)];
                let channels = if face.spread > 0.0 { &channels[..] } else { &all[..] };
                for &(shift, channel) in channels {
                    let mut rest = Vec3::splat(0.5);
                    for i in 0..rays * rays {
                        let part = Vec2::new((i % rays) as f32, (i / rays) as f32) + 0.5;
                        let texel = Vec2::new(x as f32, y as f32) + part * edge;
                        let light = whole * channel;
                        let ray = GlassRay { number, texel, edge, face, shift, light };
                        glass.throw(&ray, &mut rest, &mut parts);
                    }
                }
            }
            parts
        };
        for part in each(size.y as usize, of_row).into_iter().flatten() {
            add_caustic(&mut sums[part.number][part.index], part.light);
        }
    }
    sums
}

/// Adds the light that glass throws to the maps of all lights that ask for it.
pub(crate) fn throw_all(scene: &Scene, views: &[View], maps: &mut [ViewMaps]) {
    let rays = |view: &View| {
        view.light.and_then(|light| scene.lights.get(light)).map_or(0, |light| light.caustics)
    };
    let is_first = |view: &View| !matches!(view.role, ViewRole::Face(1..));
    let shadows: Vec<_> =
        (0..views.len()).filter(|&i| rays(&views[i]) > 0 && is_first(&views[i])).collect();
    let faces = if shadows.is_empty() { Vec::new() } else { glass_faces(&scene.casters()) };
    for first in shadows {
        let count = if matches!(views[first].role, ViewRole::Face(_)) { 6 } else { 1 };
        let shadow = first..first + count;
        let of_shadow = &maps[shadow.clone()];
        let gpu_views: Vec<_> =
            views[shadow.clone()].iter().map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect();
        let filters: Vec<_> = of_shadow.iter().map(|maps| &maps.filter[..]).collect();
        let opaque: Vec<_> = of_shadow.iter().map(|maps| &maps.opaque[..]).collect();
        let landed = thrown(&gpu_views, &filters, &opaque, &faces, rays(&views[first]));
        maps[shadow].iter_mut().zip(landed).for_each(|(maps, landed)| maps.caustics = landed);
    }
}
