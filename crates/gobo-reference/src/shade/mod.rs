//! CPU reference of `wgsl/shade/shade_*.wgsl`: the lit picture. The camera is one more view, whose casters
//! are shaded instead of summed.
mod composite;
mod details;
mod layers;
mod mean_picture;
mod near_surface;
mod seen;
mod solid;
mod strand;
mod surfaces;

use super::{
    air::{AirBefore, AirVolume},
    area::{Fit, mean_over_points},
    bloom::bloomed,
    brick::{own_shadow, voxel_value},
    brick_light::{Lattice, points_of},
    mask::{MaskInput, Masks, SeenSurface},
    occlude::is_solid,
    occlusion::{Surroundings, occluded},
    refraction::refracted_picture,
    shading::{Coat, Gloss, Lighting, Point, PointKind, Receiver, world_point},
    threads::each,
    tile::{Tile, TileTexels},
};
use crate::records::{AirParams, OcclusionRadius};
use gobo::{
    model::{
        BRICK_SIZE, Casters, Class, Gaussian, Grid, Material, Particle, Scene, Shape, Strand,
        Triangle, View, black_body,
    },
    records::{FormerSlots, GpuView, ImageDetail, MaskSlots, Picture, TRIANGLE_BIT, ViewMaps},
};
pub use mean_picture::MeanPicture;
pub use surfaces::{Surface, surfaces};

use composite::{Blended, seen_color};
use glam::{Mat4, UVec2, Vec2, Vec3};
use seen::Seen;
use std::ops::RangeInclusive;

/// Transmittance below which nothing behind is visible.
pub const FAINT: f32 = 1.0 / 1024.0;

/// The lit picture; `maps` of `views`: the shadow views of the scene's lights. `fit`: fits views to the
/// points of area lights.
pub fn render_picture(scene: &Scene, views: &[View], maps: &[ViewMaps], fit: Fit<'_>) -> Picture {
    render_samples(scene, views, maps, fit, None)
}

/// Like [`render_picture`]; `only`: index of the only sample of each pixel.
pub fn render_samples(
    scene: &Scene,
    views: &[View],
    maps: &[ViewMaps],
    fit: Fit<'_>,
    only: Option<u32>,
) -> Picture {
    let camera = View::from_camera(&scene.camera, &scene.held_bounds());
    // All samples in one call, so that the maps of a light's points are rendered once.
    let light = mean_over_points(scene, views, maps, fit, |points| {
        let lighting = Lighting::of_points(scene, points);
        let cameras = (0..).zip(View::of_samples(scene, &camera));
        let cameras = cameras.filter(|&(sample, _)| only.is_none_or(|only| only == sample));
        cameras
            .map(|(_, camera)| camera)
            .flat_map(|camera| render_sample(scene, &lighting, &camera))
            .collect()
    });
    let mut mean = MeanPicture::new(scene);
    for sample in light.chunks(scene.camera.size.element_product() as usize) {
        match scene.bloom {
            0.0 => mean.add(sample.iter().copied()),
            share => mean.add(bloomed(scene.camera.size, sample, share)),
        }
    }
    mean.picture()
}

/// Shadow masks of the picture in their stored format; for area lights, those of their points. `None` if the
/// scene has no mask settings.
pub fn picture_masks(scene: &Scene, views: &[View], maps: &[ViewMaps]) -> Option<Masks> {
    let camera = View::from_camera(&scene.camera, &scene.held_bounds());
    let lighting = Lighting::new(scene, views, maps);
    let view = camera.to_gpu(0, UVec2::ZERO, 0);
    let world_from_view = camera.view_from_world.inverse();
    let eye = Eye { view, world_from_view, lighting: &lighting, air: None, masks: None };
    let solid = OfClasses::new(scene, Class::SOLID);
    eye.picture_masks(scene, &camera, &solid.seen(scene, &camera))
}

/// Linear light of one sample per pixel, row by row.
fn render_sample(scene: &Scene, lighting: &Lighting<'_>, camera: &View) -> Vec<Vec3> {
    let view = camera.to_gpu(0, UVec2::ZERO, 0);
    let world_from_view = camera.view_from_world.inverse();
    let air = scene
        .air
        .as_ref()
        .map(|air| AirParams::new(air, scene.mean_ambient(), scene.samples))
        .map(|air| AirVolume::new(&view, &world_from_view, lighting, &air));
    let mut eye = Eye { view, world_from_view, lighting, air, masks: None };
    let [solid, blended] = [Class::SOLID, Class::BLENDED].map(|of| OfClasses::new(scene, of));
    let [solid, blended] = [&solid, &blended].map(|casters| casters.seen(scene, camera));
    let lit = Lit {
        casters: each(blended.casters.footprints.len(), |i| eye.light_caster(&blended, i)),
        lattices: each(blended.records.bricks.records.len(), |i| eye.light_brick(&blended, i)),
    };
    let tile_count = (view.tiles_x * camera.tiles().y) as usize;
    let size = scene.camera.size;
    eye.masks = eye.picture_masks(scene, camera, &solid);
    let tiles = each(tile_count, |index| {
        let tile = Tile::new(&view, index as u32);
        let surfaces = eye.surfaces(&solid, index, &tile);
        (eye.composite(&blended, &lit, index, &tile, &surfaces), surfaces)
    });
    let count = size.element_product() as usize;
    let (mut light, mut seen) = (vec![Vec3::ZERO; count], vec![Surroundings::NONE; count]);
    let (mut behind, mut bends) = (vec![(Vec3::ZERO, 1.0); count], vec![None; count]);
    for (index, (colors, surfaces)) in tiles.iter().enumerate() {
        for (in_tile, pixel) in Tile::new(&view, index as u32).texels() {
            let at = pixel.as_uvec2();
            let at = (at.y * size.x + at.x) as usize;
            let Blended { light: color, ambient, bend } = colors[in_tile];
            (light[at], bends[at]) = (color, bend);
            behind[at] = (surfaces[in_tile].light, surfaces[in_tile].around.depth);
            seen[at] = Surroundings { light: ambient, ..surfaces[in_tile].around };
        }
    }
    if scene.materials.iter().any(Material::refracts) {
        light = refracted_picture(size, &light, &behind, &bends);
    }
    match OcclusionRadius::new(scene.occlusion, scene.camera.fov_y) {
        Some(radius) => occluded(&view, &world_from_view, radius, &seen, &light),
        None => light,
    }
}

/// Background of a pixel's translucent casters.
#[derive(Clone, Copy)]
struct Behind {
    light: Vec3,
    /// Id of its object, if it is a triangle.
    object: Option<u32>,
    /// The opaque surface, with the ambient light that it sends to the eye.
    around: Surroundings,
}

/// Light of translucent particles, and lattices of bricks by the index of their records.
struct Lit {
    casters: Vec<Vec3>,
    lattices: Vec<Option<Lattice>>,
}

/// Casters of some classes, in the order of the classes.
struct OfClasses {
    particles: Vec<Particle>,
    gaussians: Vec<Gaussian>,
    triangles: Vec<Triangle>,
    grids: Vec<Grid>,
    strands: Vec<Strand>,
}

impl OfClasses {
    fn new(scene: &Scene, classes: RangeInclusive<Class>) -> Self {
        let class = |material: u32| Class::of(&scene.materials[material as usize]);
        let is = |material: u32| classes.contains(&class(material));
        let mut particles = scene.particles.clone();
        particles.retain(|p| is(p.material));
        particles.shrink_to_fit();
        particles.sort_by_key(|p| class(p.material));
        let mut gaussians = scene.gaussians.clone();
        gaussians.retain(|g| is(g.material));
        gaussians.shrink_to_fit();
        gaussians.sort_by_key(|g| class(g.material));
        let mut triangles = scene.triangles.clone();
        triangles.retain(|t| is(t.material));
        triangles.shrink_to_fit();
        triangles.sort_by_key(|t| class(t.material));
        let grids = scene.grids.iter().filter(|grid| is(grid.material)).cloned().collect();
        let strands = scene.strands.iter().filter(|s| is(s.material)).cloned().collect();
        Self { particles, gaussians, triangles, grids, strands }
    }

    fn seen<'a>(&'a self, scene: &'a Scene, camera: &View) -> Seen<'a> {
        let Self { particles, gaussians, triangles, grids, strands } = self;
        let detail = ImageDetail::new(scene.samples, camera.sample_offset());
        let casters =
            Casters { particles, gaussians, triangles, grids, strands, ..scene.casters() };
        Seen::new(casters, &scene.shadow, &camera.to_gpu(0, UVec2::ZERO, 0), detail)
    }
}

/// The camera and the lighting of its scene.
struct Eye<'a> {
    view: GpuView,
    world_from_view: Mat4,
    lighting: &'a Lighting<'a>,
    air: Option<AirVolume>,
    masks: Option<Masks>,
}

impl Eye<'_> {
    /// Shadow masks; `None` if the scene has no mask settings.
    fn picture_masks(&self, scene: &Scene, camera: &View, solid: &Seen<'_>) -> Option<Masks> {
        let settings = scene.mask.as_ref()?;
        let tiles = camera.tiles().element_product() as usize;
        let points = each(tiles, |index| {
            self.solid_points(solid, index, &Tile::new(&self.view, index as u32))
        });
        let size = camera.size;
        let none = SeenSurface { object: None, depth: 1.0, point: None };
        let mut seen = vec![none; size.element_product() as usize];
        for (index, points) in points.into_iter().enumerate() {
            for (in_tile, pixel) in Tile::new(&self.view, index as u32).texels() {
                let at = pixel.as_uvec2();
                seen[(at.y * size.x + at.x) as usize] = points[in_tile];
            }
        }
        let slots = MaskSlots::new(scene, settings, camera, &FormerSlots::new());
        let lighting = self.lighting;
        Some(MaskInput { settings, camera, lighting, seen: &seen }.masks(slots))
    }

    fn point(&self, pixel: Vec2, depth: f32) -> Vec3 {
        world_point(&self.view, &self.world_from_view, pixel, depth)
    }

    fn air_before(&self, pixel: Vec2, depth: f32) -> AirBefore {
        self.air.as_ref().map_or(AirBefore::CLEAR, |air| air.at(pixel, depth))
    }

    fn position(&self) -> Vec3 {
        self.world_from_view.w_axis.truncate()
    }

    fn light_caster(&self, blended: &Seen<'_>, footprint: usize) -> Vec3 {
        let caster = blended.casters.footprints[footprint].caster;
        if blended.casters.rects[footprint].tiles(None).next().is_none()
            || caster & TRIANGLE_BIT != 0
        {
            return Vec3::ZERO;
        }
        let caster = &blended.records.casters[caster as usize];
        let material = &blended.records.materials[caster.material() as usize];
        if material.shape == Shape::Capsule {
            let record = &blended.records.capsules.records[caster.id as usize];
            return self.lighting.light(&self.strand(caster, record, material), None);
        }
        let point = Point {
            kind: PointKind::Particle,
            position: caster.center,
            pixel: UVec2::ZERO,
            face: Vec3::ZERO,
            normal: Vec3::ZERO,
            to_eye: Vec3::ZERO,
            // It does not shadow itself: the bias is its radius.
            reach: caster.radius,
            receiver: Receiver::new(material, caster.id),
            albedo: Vec3::ONE,
            roughness: 1.0,
            gloss: Gloss::SOLID,
            emission: Vec3::ZERO,
            metallic: 0.0,
            far: Vec3::ZERO,
            coat: Coat::NONE,
        };
        self.lighting.light(&point, None)
    }

    /// Light of a brick's lattice; `None` where the camera does not see the brick, and for the record of a
    /// grid.
    fn light_brick(&self, blended: &Seen<'_>, record: usize) -> Option<Lattice> {
        let bricks = &blended.records.bricks;
        if !bricks.brick_records().contains(&(record as u32)) {
            return None;
        }
        let brick = &bricks.records[record];
        let grid = bricks.grid(brick);
        let material = &blended.records.materials[grid.material as usize];
        let points = points_of(bricks, brick, &self.view)?;
        let [x, y, z] = bricks.half_edges(record as u32).map(Vec3::length);
        let temperatures = bricks.temperatures_of(brick);
        let is_own_shadow = self.lighting.has_curves() && grid.is_own_shadow(material);
        let light = |(place, position): (Vec3, Vec3)| {
            let kelvin =
                temperatures.map_or(0.0, |all| voxel_value(all, place * BRICK_SIZE as f32));
            let point = Point {
                kind: PointKind::Brick { anisotropy: grid.anisotropy },
                position,
                pixel: UVec2::ZERO,
                face: Vec3::ZERO,
                normal: Vec3::ZERO,
                to_eye: (self.position() - position).normalize_or_zero(),
                // A curve holds the shadow of a point's own brick, too.
                reach: if self.lighting.has_curves() { 0.0 } else { x + y + z },
                receiver: Receiver::new(material, 0),
                albedo: material.tint.truncate(),
                roughness: 1.0,
                gloss: Gloss::SOLID,
                emission: grid.emission * black_body(kelvin),
                metallic: 0.0,
                far: Vec3::ZERO,
                coat: Coat::NONE,
            };
            if !is_own_shadow {
                return self.lighting.light(&point, None);
            }
            self.lighting.light_in_body(&point, |toward, end| {
                own_shadow(bricks, brick, position, toward, end)
            })
        };
        let light = points.into_iter().map(light).collect();
        Some(Lattice { edge: grid.lattice_edge, light })
    }

    /// The opaque casters, or the sky.
    fn surfaces(&self, solid: &Seen<'_>, index: usize, tile: &Tile) -> TileTexels<Behind> {
        let points = self.solid_points(solid, index, tile);
        let none = Behind { light: Vec3::ZERO, object: None, around: Surroundings::NONE };
        let mut surfaces = TileTexels::filled(none);
        for (in_tile, pixel) in tile.texels() {
            let SeenSurface { object, depth, point } = points[in_tile];
            let before = self.air_before(pixel, depth);
            let mut around = Surroundings { depth, ..Surroundings::NONE };
            let color = match point {
                Some(point) => {
                    // Particles have the depth of their discs, not of spheres.
                    around.normal = if point.reach > 0.0 { Vec3::ZERO } else { point.face };
                    around.light = self.lighting.ambient_of(&point) * before.left;
                    self.lighting.light(&point, self.masks.as_ref())
                }
                None => {
                    let away = self.point(pixel, 1.0) - self.position();
                    self.lighting.radiance_around(away.normalize(), 0.0)
                }
            };
            surfaces[in_tile] =
                Behind { light: color * before.left + before.light, object, around };
        }
        surfaces
    }
}
