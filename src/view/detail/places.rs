//! Places of a picture beside edges of shadows.
use super::{SOFT, window::Window};
use crate::{
    model::{Material, Projection, Scene, Source, Transfer, View},
    view::raster::{Image, Nearest, Raster, SMALL_MAP},
};
use glam::{DMat2, DVec2, DVec3, IVec2, UVec2, Vec3};

/// Width of a texel that is narrow enough \[pixels\].
const FINENESS: f64 = 0.6;
/// Pixels of the picture per pixel of the small picture, each way.
pub(super) const COARSE: u32 = 8;
/// Texels across a penumbra.
pub(in crate::view) const TEXELS: f64 = 3.0;
/// Most small maps of a view, each of a part of the one before.
const MAPS: usize = 4;
/// Texels of a level around a place that are searched for an edge.
const EDGES: i32 = 2;
/// Least cosine at which a surface is measured.
const MIN_COSINE: f64 = 0.1;

/// A place of the picture beside an edge of a shadow.
#[derive(Clone, Copy)]
pub(in crate::view) struct Seen {
    /// On the light's plane: \[m\], or at 1 m along the axis in a perspective view.
    pub(in crate::view) place: DVec2,
    /// Widest texel there that is narrow enough, in the same unit.
    pub(in crate::view) texel: f64,
    /// Radius of the penumbra there: occluders as far aside shade it, in the same unit; 0 without a size.
    pub(super) reach: f64,
}

/// A surface of the picture, seen from a light.
pub(in crate::view) struct ShownSurface {
    /// Toward the eye, unit.
    pub(in crate::view) normal: DVec3,
    /// Depth \[m\]; 1 in a parallel view.
    spread: f64,
    pub(in crate::view) seen: Seen,
}

/// Surfaces of the picture, and the width of its pixels there.
pub(in crate::view) struct ShownPicture<'a> {
    scene: &'a Scene,
    seen: Image,
    eye: DVec3,
    /// Right, up and forward.
    axes: [DVec3; 3],
    /// Width of a pixel at 1 m along the axis \[m\].
    pixel: f64,
}

impl<'a> ShownPicture<'a> {
    pub(in crate::view) fn new(scene: &'a Scene) -> Self {
        let camera = &scene.camera;
        let view = View::from_camera(camera, &scene.held_bounds());
        let is_seen = |material: &Material| material.transfer.is_opaque() && material.visible;
        let seen = Raster::new(&view, camera.size / COARSE).nearest(scene, is_seen);
        let forward = (camera.target - camera.eye).as_dvec3().normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let pixel = (f64::from(camera.fov_y) * 0.5).tan() * 2.0 / f64::from(camera.size.y);
        let axes = [right, right.cross(forward), forward];
        Self { scene, seen, eye: camera.eye.as_dvec3(), axes, pixel }
    }

    /// Places where the picture may show edges of shadows of `base`.
    pub(super) fn places(&self, base: &View) -> Vec<Seen> {
        let received = |hit| Some((hit, self.receiver(hit, base)?));
        let surfaces: Vec<_> = self.seen.hits().filter_map(received).collect();
        let mut maps = vec![SmallMap::new(self.scene, base.clone(), base.scale.recip().into())];
        while maps.len() < MAPS {
            let last = &maps[maps.len() - 1];
            // The texels that are searched reach to the next places.
            let widest = f64::from(COARSE) / f64::from(EDGES);
            let is_coarse = |surface: &ShownSurface| surface.seen.texel * widest < last.cell;
            let fine =
                surfaces.iter().filter(|(hit, surface)| last.sees(hit) && is_coarse(surface));
            let Some(part) =
                Window::of_small_map(fine.map(|(_, surface)| surface.seen.place), SMALL_MAP)
            else {
                break;
            };
            if part.texel > 0.5 * last.cell {
                break;
            }
            maps.push(SmallMap::new(self.scene, part.view(self.scene, base), part.texel));
        }
        let axes = base.light.and_then(|index| {
            let light = &self.scene.lights[index];
            Some(source_axes(base, &light.area()?.part(light.viewpoint_count())))
        });
        let [short, long] = axes.map_or([0.0; 2], |[a, b]| {
            let [a, b] = [a.length(), b.length()];
            [a.min(b), a.max(b)]
        });
        let place = |(hit, surface): &(&Nearest, ShownSurface)| {
            let edge = self.edge(hit, surface, &maps, base.scale.recip().into())?;
            let texel = match axes {
                None => surface.seen.texel,
                Some(_) => (SOFT * surface.seen.texel).max(2.0 * short * edge.nearest / TEXELS),
            };
            let texel = texel.max(edge.off);
            Some(Seen { texel, reach: long * edge.farthest, ..surface.seen })
        };
        surfaces.iter().filter_map(place).collect()
    }

    /// Surfaces at some of the picture's pixels.
    pub(in crate::view) fn hits(&self) -> impl Iterator<Item = &Nearest> {
        self.seen.hits()
    }

    /// The nearest edge of a shadow that texels of the width `coarsest` would mix into the light of a
    /// surface. `maps`: from the whole view to its smallest part.
    fn edge(
        &self,
        hit: &Nearest,
        surface: &ShownSurface,
        maps: &[SmallMap],
        coarsest: f64,
    ) -> Option<Edge> {
        let mut off = 0.0;
        for map in maps.iter().rev() {
            let Some(at) = map.raster.texel_of(hit.point) else { continue };
            for (level, image) in map.levels.iter().enumerate() {
                let cell = map.cell * f64::from(1 << level);
                if off >= coarsest {
                    return None;
                }
                if cell <= off {
                    continue;
                }
                let around = image.around(at >> level as u32);
                if let Some(edge) = self.edge_among(around, hit, surface, map) {
                    return Some(Edge { off, ..edge });
                }
                off = cell;
            }
        }
        None
    }

    /// An edge among the occluders `around` a surface, of which the first is the one in its own texel.
    fn edge_among<'b>(
        &self,
        around: impl Iterator<Item = Option<&'b Nearest>>,
        hit: &Nearest,
        surface: &ShownSurface,
        map: &SmallMap,
    ) -> Option<Edge> {
        let cover = |hit_there: Option<&Nearest>| {
            let Nearest { point, triangle } = *hit_there?;
            let material = self.scene.triangles[triangle as usize].material;
            let is_opaque = self.scene.materials[material as usize].transfer.is_opaque();
            let before = (point - hit.point).dot(surface.normal);
            let occluder = if is_opaque { u32::MAX } else { material };
            (before > 0.5 * map.cell * surface.spread).then_some((occluder, point))
        };
        let mut edge = Edge { off: 0.0, nearest: f64::INFINITY, farthest: 0.0 };
        let mut middle = None;
        let mut is_edge = false;
        for cover in around.map(cover) {
            let occluder = cover.map(|(occluder, _)| occluder);
            is_edge |= occluder != *middle.get_or_insert(occluder);
            if let Some((_, point)) = cover {
                let aside = map.aside(point, hit.point);
                edge.nearest = edge.nearest.min(aside);
                edge.farthest = edge.farthest.max(aside);
            }
        }
        is_edge.then_some(edge)
    }

    /// A surface of the picture, seen from a light; `None` if the light is nearly in its plane.
    pub(in crate::view) fn receiver(&self, hit: &Nearest, base: &View) -> Option<ShownSurface> {
        let is_wide = base.projection == Projection::Perspective;
        let view_from_world = base.view_from_world.as_dmat4();
        let in_light = view_from_world.transform_point3(hit.point);
        let spread = if is_wide { -in_light.z } else { 1.0 };
        let slope = if is_wide { in_light.truncate() / in_light.z } else { DVec2::ZERO };
        let toward = if is_wide { -in_light } else { DVec3::Z };
        let toward = view_from_world.inverse().transform_vector3(toward).normalize();
        let [a, b, c] = self.scene.triangles[hit.triangle as usize].positions.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let away = hit.point - self.eye;
        let normal = if normal.dot(away) > 0.0 { -normal } else { normal };
        if normal.dot(toward) < MIN_COSINE {
            return None;
        }
        // From the light's plane, through the surface, to the picture.
        let tangent = normal.any_orthonormal_vector();
        let tangents = [tangent, normal.cross(tangent)];
        let of_light = |way: DVec3| {
            let moved = view_from_world.transform_vector3(way);
            (moved.truncate() - slope * moved.z) / spread
        };
        let [right, up, forward] = self.axes;
        let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
        let distance = away.dot(forward);
        let of_picture = |way: DVec3| {
            (flat(way) - flat(away) * (way.dot(forward) / distance)) / (distance * self.pixel)
        };
        let light = DMat2::from_cols(of_light(tangents[0]), of_light(tangents[1]));
        let picture = DMat2::from_cols(of_picture(tangents[0]), of_picture(tangents[1]));
        let picture_from_light = picture * light.inverse();
        // The larger singular value.
        let sum =
            picture_from_light.x_axis.length_squared() + picture_from_light.y_axis.length_squared();
        let area = picture_from_light.determinant();
        let stretch = ((sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt()) * 0.5).sqrt();
        let place = in_light.truncate() / spread;
        let seen = Seen { place, texel: FINENESS / stretch, reach: 0.0 };
        (stretch.is_finite() && stretch > 0.0 && place.is_finite()).then_some(ShownSurface {
            normal,
            spread,
            seen,
        })
    }
}

/// An edge of a shadow beside a place.
struct Edge {
    /// Width of texels that do not reach it from the place, in the unit of [`Seen::place`].
    off: f64,
    /// Offsets on the light's plane of rays that pass the occluders, per metre of the source.
    nearest: f64,
    farthest: f64,
}

/// Occluders that a light sees, in a part of its view.
struct SmallMap {
    raster: Raster,
    /// Each with a texel for 2 x 2 of the one before, that of the occluder nearest to the light; the last is
    /// searched nearly whole.
    levels: Vec<Image>,
    /// Edge of a texel, in the unit of [`Seen::place`].
    cell: f64,
    view: View,
}

impl SmallMap {
    /// `texel`: of the view.
    fn new(scene: &Scene, view: View, texel: f64) -> Self {
        let raster = Raster::new(&view, UVec2::splat(SMALL_MAP));
        let casts = |material: &Material| material.casts && material.transfer != Transfer::None;
        let mut levels = vec![raster.nearest(scene, casts)];
        let view_from_world = view.view_from_world.as_dmat4();
        let depth = |hit: &Nearest| -view_from_world.transform_point3(hit.point).z;
        while SMALL_MAP >> levels.len() > 2 * EDGES as u32 + 1 {
            levels.push(levels[levels.len() - 1].halved(depth));
        }
        let cell = texel * f64::from(view.size.x) / f64::from(SMALL_MAP);
        Self { raster, levels, cell, view }
    }

    fn sees(&self, hit: &Nearest) -> bool {
        self.raster.texel_of(hit.point).is_some()
    }

    /// Offset on the light's plane of a ray that passes an occluder, per metre of the source.
    fn aside(&self, occluder: DVec3, receiver: DVec3) -> f64 {
        let view_from_world = self.view.view_from_world.as_dmat4();
        let [near, far] =
            [occluder, receiver].map(|point| -view_from_world.transform_point3(point).z);
        let is_wide = self.view.projection == Projection::Perspective;
        if is_wide { near.recip() - far.recip() } else { far - near }.max(0.0)
    }
}

impl Image {
    /// A texel and those around it, [`EDGES`] each way.
    fn around(&self, at: IVec2) -> impl Iterator<Item = Option<&Nearest>> {
        let steps = (-EDGES..=EDGES).flat_map(|y| (-EDGES..=EDGES).map(move |x| IVec2::new(x, y)));
        let texels = std::iter::once(IVec2::ZERO).chain(steps).map(move |step| at + step);
        texels.filter(|&texel| self.contains(texel)).map(|texel| self.at(texel))
    }
}

/// Half axes of a disc with the variance of a source, along x and y in a view \[m\]; for a sun, slopes.
pub(in crate::view) fn source_axes(view: &View, source: &Source) -> [DVec2; 2] {
    let half_axes = source.half_axes();
    match source {
        Source::Disc { .. } | Source::Rect { .. } => {
            half_axes.map(|axis| view.view_from_world.transform_vector3(axis).as_dvec3().truncate())
        }
        _ => [DVec2::X, DVec2::Y].map(|axis| axis * f64::from(half_axes[0].x)),
    }
}
