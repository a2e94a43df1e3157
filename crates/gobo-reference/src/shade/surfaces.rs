//! The camera's nearest opaque surfaces, and their motion to the next frame: data for compositors.
use super::{super::shading::Lighting, Eye, OfClasses, seen::Seen, solid::NearestCaster};
use crate::{caster_hit::Target, hit::HitTriangle, threads::each, tile::Tile};
use glam::{UVec2, Vec2, Vec3};
use gobo::{
    model::{Class, Scene, Shape, View},
    records::TRIANGLE_BIT,
};

/// An opaque surface at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Point at which its light is looked up, world space less the scene's origin \[m\].
    pub position: Vec3,
    /// Interpolated normal on the side that the eye sees, unit, world space.
    pub normal: Vec3,
    /// Linear rgb.
    pub albedo: Vec3,
    /// Distance from the eye along the camera's axis \[m\].
    pub distance: f32,
    /// `id` of its triangle, particle or strand.
    pub object: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Motion to the next frame, right and down \[pixels\].
    pub motion: Vec2,
}

/// The nearest opaque surface of each pixel, row by row; `None` where there is none. `sample`: index among
/// the scene's samples per pixel. `next`: the scene at the next frame.
pub fn surfaces(scene: &Scene, sample: u32, next: Option<&Scene>) -> Vec<Option<Surface>> {
    let lighting = Lighting::new(scene, &[], &[]);
    let camera = camera(scene, sample);
    let view = camera.to_gpu(0, UVec2::ZERO, 0);
    let world_from_view = camera.view_from_world.inverse();
    let eye = Eye { view, world_from_view, lighting: &lighting, air: None, masks: None };
    let casters = OfClasses::new(scene, Class::SOLID);
    let solid = casters.seen(scene, &camera);
    let next = next.map(|next| Next {
        casters: OfClasses::new(next, Class::SOLID),
        camera: self::camera(next, sample),
    });
    let next = next.as_ref().map(|next| (next.casters.seen(scene, &next.camera), &next.camera));
    let tile_count = camera.tiles().element_product() as usize;
    let size = camera.size;
    let of_tiles = each(tile_count, |index| {
        let tile = Tile::new(&view, index as u32);
        let nearest = eye.nearest(&solid, index, &tile);
        let of_pixel = |(in_tile, pixel): (usize, Vec2)| {
            let found = nearest[in_tile]?;
            let mut surface = eye.surface(&solid, &found, pixel);
            if let Some((casters, camera)) = &next {
                let position = eye.point(pixel, found.hit.depth);
                let moved = position + movement(&solid, casters, &found, pixel);
                surface.motion = pixel_of(camera, moved) - pixel;
            }
            Some(((pixel.y as u32 * size.x + pixel.x as u32) as usize, surface))
        };
        tile.texels().filter_map(of_pixel).collect::<Vec<_>>()
    });
    let mut all = vec![None; size.element_product() as usize];
    for (at, surface) in of_tiles.into_iter().flatten() {
        all[at] = Some(surface);
    }
    all
}

/// Opaque casters and the camera at the next frame.
struct Next {
    casters: OfClasses,
    camera: View,
}

fn camera(scene: &Scene, sample: u32) -> View {
    let whole = View::from_camera(&scene.camera, &scene.held_bounds());
    let of_sample = View::of_samples(scene, &whole).nth(sample as usize);
    of_sample.unwrap_or(whole)
}

/// Position of a point in the camera's picture \[pixels\].
fn pixel_of(camera: &View, point: Vec3) -> Vec2 {
    let seen = camera.view_from_world.transform_point3(point);
    let slope = seen.truncate() / -seen.z;
    camera.size.as_vec2() * 0.5 + camera.scale * Vec2::new(slope.x, -slope.y)
}

/// Motion of a visible point to the next frame \[m\]: triangles, found by their index in the scene, move with
/// their deformation, other casters with their centre; a caster that is not found does not move.
fn movement(now: &Seen<'_>, next: &Seen<'_>, found: &NearestCaster<'_>, pixel: Vec2) -> Vec3 {
    let footprint = found.footprint;
    let index = (footprint.caster & !TRIANGLE_BIT) as usize;
    if footprint.caster & TRIANGLE_BIT != 0 {
        let (before, after) = (&now.records.triangles, &next.records.triangles);
        let is_same = before.len() == after.len() && before[index].id == after[index].id;
        let Some(met) = now.setup(footprint).hit(pixel).filter(|_| is_same) else {
            return Vec3::ZERO;
        };
        let step = |i: usize| {
            let [from, to] = [before, after].map(|all| all[index].positions_u[i].truncate());
            (to - from) * met.barycentric[i]
        };
        return step(0) + step(1) + step(2);
    }
    let (before, after) = (&now.records.casters, &next.records.casters);
    let is_same = before.len() == after.len() && before[index].id == after[index].id;
    if is_same { after[index].center - before[index].center } else { Vec3::ZERO }
}

impl Eye<'_> {
    fn surface(&self, solid: &Seen<'_>, found: &NearestCaster<'_>, pixel: Vec2) -> Surface {
        let point = self.solid_point(solid, found, pixel);
        let footprint = found.footprint;
        let material = if footprint.caster & TRIANGLE_BIT != 0 {
            solid.record(footprint).material
        } else {
            solid.records.casters[footprint.caster as usize].material()
        };
        // A particle has the depth of a disc in the picture and casts shadows as a disc: light is looked up
        // on the sphere.
        let is_sphere = point.reach > 0.0 && found.material.shape != Shape::Capsule;
        let out = if is_sphere { point.reach * point.normal.dot(point.to_eye) } else { 0.0 };
        Surface {
            position: point.position + out * point.to_eye,
            normal: point.normal,
            albedo: point.albedo,
            distance: self.view.near + found.hit.depth * (self.view.far - self.view.near),
            object: Target::new(solid.records(), footprint).id,
            material,
            motion: Vec2::ZERO,
        }
    }
}
