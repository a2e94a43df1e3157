//! Places of a picture beside edges of shadows.
use crate::{
    model::{Material, Projection, Scene, Transfer, View},
    view::raster::{Image, Nearest, Raster},
};
use glam::{DMat2, DVec2, DVec3, IVec2, UVec2, Vec3};

/// Width of a texel that is narrow enough \[pixels\].
const FINENESS: f64 = 0.6;
/// Pixels of the picture per pixel of the small picture, each way.
const COARSE: u32 = 8;
/// Edge of the small map \[texels\].
const MAP: u32 = 512;
/// Texels of the small map around a place that are searched for an edge.
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
        let map = Raster::new(base, UVec2::splat(MAP));
        let casts = |material: &Material| material.casts && material.transfer != Transfer::None;
        let nearest = map.nearest(self.scene, casts);
        self.seen.hits().filter_map(|hit| self.place(hit, base, &map, &nearest)).collect()
    }

    /// Surfaces at some of the picture's pixels.
    pub(in crate::view) fn hits(&self) -> impl Iterator<Item = &Nearest> {
        self.seen.hits()
    }

    fn place(&self, hit: &Nearest, base: &View, map: &Raster, nearest: &Image) -> Option<Seen> {
        let at = map.texel_of(hit.point)?;
        let receiver = self.receiver(hit, base)?;
        let cell =
            f64::from(base.size.x) / f64::from(MAP) / f64::from(base.scale) * receiver.spread;
        let cover = |texel: IVec2| {
            let hit_there = nearest.at(texel)?;
            let material = self.scene.triangles[hit_there.triangle as usize].material;
            let is_opaque = self.scene.materials[material as usize].transfer.is_opaque();
            let is_in_front = (hit_there.point - hit.point).dot(receiver.normal) > 0.5 * cell;
            is_in_front.then_some(if is_opaque { u32::MAX } else { material })
        };
        let around =
            (-EDGES..=EDGES).flat_map(|y| (-EDGES..=EDGES).map(move |x| at + IVec2::new(x, y)));
        let mut around = around.filter(|&texel| map.contains(texel));
        let covers = cover(at);
        if around.all(|texel| cover(texel) == covers) {
            return None;
        }
        Some(receiver.seen)
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
        let seen = Seen { place, texel: FINENESS / stretch };
        (stretch.is_finite() && stretch > 0.0 && place.is_finite()).then_some(ShownSurface {
            normal,
            spread,
            seen,
        })
    }
}
