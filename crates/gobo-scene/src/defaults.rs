//! Defaults of a scene file.
use super::{
    Bounds, Camera, Scene,
    particles::FARTHEST,
    room::Interior,
    shapes::{self, KindOfShape},
    subject::{Subject, is_sheet},
};
use glam::{IVec3, Mat4, Quat, UVec2, UVec3, Vec2, Vec3, Vec4};
use gobo::model::{
    BRICK_EDGE, Brick, Density, Grid, ImageSun, Light, LightKind, Material, Source, SunDisc,
    Transfer,
};
use rayon::prelude::*;

/// A scene without casters and lights; all else has the defaults of a scene file.
pub fn empty_scene() -> Scene {
    Scene { camera: camera(&Bounds::EMPTY), ..Scene::default() }
}

/// A camera that frames the scene's contents in a picture of `size` pixels: the camera of a model or particle
/// file that is rendered on its own.
pub fn usual_camera(scene: &Scene, size: UVec2) -> Camera {
    let usual = Camera { size, ..camera(&contents(scene)) };
    framed(usual, scene, false)
}

/// Material of a particle file that is rendered on its own.
pub(super) const PARTICLE_MATERIAL: &str = r#"
[[material]]
name = "particles"
tint = [0.35, 0.6, 0.9, 0.35]
"#;

/// Volume of an `OpenVDB` file that is rendered on its own.
pub(super) const VOLUME: &str = "[[volume]]\n";

/// Material of a point cloud that is rendered on its own: scanned surfaces are opaque.
pub(super) const POINTS_MATERIAL: &str = r#"
[[material]]
name = "particles"
transfer = "opaque"
profile = "flat"
"#;

/// Splats of a file with levels of detail that is rendered on its own.
pub(super) const SPLATS: &str = "[[splats]]\nrotation = [180, 0, 0]\n";

/// [`sun`] in the format of a scene file.
pub(super) const SUN: &str = r#"
[[light]]
name = "sun"
kind = "directional"
direction = [-0.4, -1, -0.3]
intensity = 3
"#;

pub(super) fn sun() -> Light {
    Light {
        name: "sun".to_owned(),
        kind: LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        intensity: 3.0,
        ..Light::default()
    }
}

/// The sun of an environment's image as a light.
pub(super) fn sun_of_image(sun: &ImageSun) -> Light {
    let intensity = sun.irradiance.max_element();
    Light {
        name: "sun".to_owned(),
        kind: LightKind::Directional { direction: sun.direction },
        color: sun.irradiance / intensity,
        intensity,
        source: Some(Source::Sun { angle: sun.angle }),
        ..Light::default()
    }
}

/// Box around the visible contents. In a scene of splats alone it leaves out a thousandth of the centres at
/// each side: captures are surrounded by large, faint splats. In a scene of volumes alone it holds what is
/// dense: bricks reach up to eight voxels further.
pub(super) fn contents(scene: &Scene) -> Bounds {
    let Scene { gaussians, particles, triangles, emissions, grids, strands, .. } = scene;
    let others = [particles.len(), triangles.len(), emissions.len(), strands.len()];
    if others != [0; 4] || gaussians.is_empty() == grids.is_empty() {
        return scene.bounds();
    }
    if gaussians.is_empty() {
        let dense = grids.iter().fold(Bounds::EMPTY, |all, grid| all.with(&dense_part(grid)));
        return if dense.is_empty() { scene.bounds() } else { dense };
    }
    let mut bounds = Bounds { min: Vec3::ZERO, max: Vec3::ZERO };
    let left_out = gaussians.len() / 1000;
    let mut along: Vec<f32> = Vec::with_capacity(gaussians.len());
    for axis in 0..3 {
        along.clear();
        along.extend(gaussians.iter().map(|gaussian| gaussian.center[axis]));
        along.sort_unstable_by(f32::total_cmp);
        bounds.min[axis] = along[left_out];
        bounds.max[axis] = along[along.len() - 1 - left_out];
    }
    // With few splats, or a flat cloud, the box holds all splats.
    if (bounds.max - bounds.min).min_element() > 0.0 && left_out > 0 {
        bounds
    } else {
        scene.bounds()
    }
}

/// Bounds of the voxels with a density, each half a voxel around its place.
fn dense_part(grid: &Grid) -> Bounds {
    let around = |corners: [Vec3; 8]| {
        corners.into_iter().fold(Bounds::EMPTY, |all, corner| all.with_sphere(corner, 0.0))
    };
    let dense = |brick: &Brick| {
        let voxels = match &brick.density {
            Density::Constant { .. } => return around(grid.corners(brick)),
            Density::Voxels(voxels) => voxels.bits(),
        };
        let edge = BRICK_EDGE as u32;
        let at = |i: u32| UVec3::new(i % edge, i / edge % edge, i / (edge * edge)).as_ivec3();
        let dense = (0..).zip(voxels).filter(|(_, density)| **density != 0);
        let none = [IVec3::MAX, IVec3::MIN];
        let [low, high] = dense.fold(none, |[low, high], (i, _)| [low.min(at(i)), high.max(at(i))]);
        if low.x > high.x {
            return Bounds::EMPTY;
        }
        let [min, max] = [low, high].map(|voxel| (brick.origin + voxel).as_vec3());
        let voxels = Bounds { min: min - 0.5, max: max + 0.5 };
        around(voxels.corners().map(|corner| grid.world_from_index.transform_point3(corner)))
    };
    grid.bricks.par_iter().map(dense).reduce(|| Bounds::EMPTY, |a, b| a.with(&b))
}

/// Size of the picture unless the scene file sets it [pixels].
pub(super) const PICTURE: UVec2 = UVec2::new(960, 540);

/// Samples per pixel unless the scene file sets them.
pub(super) const SAMPLES: u32 = 4;

/// A three-quarter view from slightly above that contains the whole box.
pub(super) fn camera(bounds: &Bounds) -> Camera {
    let mut camera = Camera {
        eye: Vec3::ONE,
        target: bounds.or_unit().center(),
        up: Vec3::Y,
        fov_y: 45f32.to_radians(),
        size: PICTURE,
    };
    camera.eye = eye(&camera, bounds);
    camera
}

/// Position from which the sphere around the box fits into the picture.
pub(super) fn eye(camera: &Camera, bounds: &Bounds) -> Vec3 {
    let radius = bounds.or_unit().radius().max(1e-3);
    let aspect = camera.size.x as f32 / camera.size.y as f32;
    let half = (camera.fov_y * 0.5).tan() * aspect.min(1.0);
    let distance = radius * (1.0 + half * half).sqrt() / half;
    // Far from the origin a short distance would be lost in rounding.
    let distance = distance.max(camera.target.abs().max_element() * 1e-4);
    camera.target + Vec3::new(0.55, 0.45, 0.8).normalize() * distance
}

/// Share of the picture's width or height that the contents of a single file fill.
const FILLED: f32 = 0.75;
/// Directions from which what is flat and upright is seen: above the ground, and off its front [degrees].
const FRONT_ABOVE: f32 = 23.5;
const FRONT_ASIDE: f32 = 20.0;
/// Least angle of view of a closed room from within [degrees].
const ROOM_FOV: f32 = 65.0;
/// Irradiance of its lamp at a distance of the square root of its floor's area [the sun's]: white walls do
/// not burn.
const LAMP: f32 = 0.08;

/// The camera of a single file, moved so that its contents fill [`FILLED`] of the picture's width or height.
/// It looks down 25 degrees, so that the horizon is out of sight, and up to 40 at flat contents.
/// `keeps_target`: the target stays where it is, which need not be the middle.
pub(super) fn framed(camera: Camera, scene: &Scene, keeps_target: bool) -> Camera {
    let subject = Subject::new(scene, contents(scene).or_unit());
    let outside = framed_outside(camera, &subject, keeps_target);
    let room = Interior::of(&subject, &outside).filter(|_| !keeps_target);
    room.map_or(outside, |room| Camera {
        eye: room.eye,
        target: room.target,
        fov_y: camera.fov_y.max(ROOM_FOV.to_radians()),
        ..camera
    })
}

fn framed_outside(mut camera: Camera, subject: &Subject<'_>, keeps_target: bool) -> Camera {
    let bounds = subject.bounds;
    let size = bounds.max - bounds.min;
    let flatness = 1.0 - size.y / size.max_element().max(f32::MIN_POSITIVE);
    let aside = Vec3::new(0.55, 0.0, 0.8).normalize();
    let front = subject.front(aside);
    let above = if front.is_some() { FRONT_ABOVE } else { 25.0 + 15.0 * flatness };
    let (sin, cos) = f32::to_radians(above).sin_cos();
    let aside = front.map_or(aside, |front| {
        let turned = |degrees: f32| Quat::from_rotation_y(degrees.to_radians()) * front;
        let sides = [FRONT_ASIDE, -FRONT_ASIDE].map(turned);
        if sides[0].dot(aside) >= sides[1].dot(aside) { sides[0] } else { sides[1] }
    });
    let away = aside * cos + Vec3::Y * sin;
    let right =
        camera.up.cross(away).try_normalize().unwrap_or_else(|| away.any_orthonormal_vector());
    let up = away.cross(right);
    if !keeps_target {
        camera.target = bounds.center();
    }
    let slope = (camera.fov_y * 0.5).tan() * FILLED;
    let slopes = Vec2::new(slope * camera.size.x as f32 / camera.size.y as f32, slope);
    // Distances at which everything is inside the right and upper border, and inside the left and lower one.
    let (mut high, mut low) = (Vec2::NEG_INFINITY, Vec2::NEG_INFINITY);
    for_each_sphere(subject, |center, radius| {
        let at = center - camera.target;
        let place = Vec2::new(at.dot(right), at.dot(up)) / slopes;
        let reach = radius * (1.0 + slopes.powf(-2.0)).map(f32::sqrt) + at.dot(away);
        high = high.max(reach + place);
        low = low.max(reach - place);
    });
    if !keeps_target {
        let shift = (high - low) * 0.5 * slopes;
        camera.target += right * shift.x + up * shift.y;
        high = (high + low) * 0.5;
        low = high;
    }
    // Far from the origin a short distance would be lost in rounding.
    let least = camera.target.abs().max_element() * 1e-4;
    let distance = high.max(low).max_element().max(least).max(1e-3);
    camera.eye = camera.target + away * distance;
    camera
}

/// Calls `visit` with spheres that hold the visible contents: corners of triangles and particles, or else the
/// corners of `bounds`.
fn for_each_sphere(subject: &Subject<'_>, mut visit: impl FnMut(Vec3, f32)) {
    let Scene { gaussians, particles, triangles, emissions, grids, .. } = subject.scene;
    if particles.is_empty() && triangles.is_empty()
        || !(gaussians.is_empty() && emissions.is_empty() && grids.is_empty())
    {
        return subject.bounds.corners().into_iter().for_each(|corner| visit(corner, 0.0));
    }
    particles.iter().for_each(|particle| visit(particle.center, particle.radius));
    let corners = subject.triangles().flat_map(|triangle| triangle.positions);
    corners.for_each(|corner| visit(corner, 0.0));
}

/// Extent of the ground \[sizes of the scene\]: the camera sees its edge less than a degree below the
/// horizon.
const GROUND: f32 = 100.0;

/// Adds a grey floor just under a bare model or particle file to receive its shadow; under an environment
/// image, one that only catches shadows. Adds none if it would hide the model from its own camera, or the
/// model has a floor. The floor casts no shadow, so that shadow maps fit the model.
pub(super) fn add_ground(scene: &mut Scene, camera: Option<&Camera>, catcher: bool) {
    let bounds = contents(scene);
    if bounds.is_empty() || has_floor(scene, &bounds) || Subject::new(scene, bounds).has_ground() {
        return;
    }
    let extent = (bounds.max - bounds.min).max_element().max(1e-3);
    let center = bounds.center();
    let place = Vec3::new(center.x, bounds.min.y - extent * 1e-3, center.z);
    let is_inside = |eye: Vec3| eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all();
    if camera.is_some_and(|camera| camera.eye.y <= place.y || is_inside(camera.eye)) {
        return;
    }
    // Corners stay within the largest coordinates of a scene.
    let left = FARTHEST - place.abs().max_element();
    let edge = (extent * 2.0 * GROUND).min(2.0 * left).max(extent);
    let transform = Mat4::from_translation(place) * Mat4::from_scale(Vec3::splat(edge));
    let material = scene.materials.len() as u32;
    scene.materials.push(Material {
        name: "ground".to_owned(),
        transfer: Transfer::Opaque,
        tint: Vec4::new(0.42, 0.415, 0.405, 1.0),
        casts: false,
        catcher,
        ..Material::default()
    });
    scene.triangles.extend(shapes::shape(KindOfShape::Plane, 0, transform, material, u32::MAX));
}

/// Whether upward opaque surfaces in the lowest twentieth of the height cover half of the area: those of a
/// room, or of a model on a base. A flat scene has no floor: all of it is low; nor has a cloth.
fn has_floor(scene: &Scene, bounds: &Bounds) -> bool {
    let size = bounds.max - bounds.min;
    if size.y < 0.1 * size.max_element() || is_sheet(&scene.triangles) {
        return false;
    }
    let low = bounds.min.y + 0.05 * size.y;
    let covered: f32 = scene
        .triangles
        .iter()
        .filter(|t| scene.materials[t.material as usize].transfer.is_opaque())
        .filter(|t| t.positions.iter().all(|p| p.y <= low))
        .filter(|t| t.normals.iter().map(|n| n.y).sum::<f32>() > 2.7)
        .map(|t| {
            let [a, b, c] = t.positions;
            0.5 * (b - a).cross(c - a).y.abs()
        })
        .sum();
    covered > 0.0 && covered >= 0.5 * size.x * size.z
}

/// Makes the default light of a file that is a closed room, if it is one, a lamp under its ceiling, as bright
/// as its floor is large.
pub(super) fn hang_lamp(light: &mut Light, scene: &Scene) -> bool {
    let subject = Subject::new(scene, contents(scene).or_unit());
    let usual = camera(&subject.bounds);
    let Some(room) = Interior::of(&subject, &framed_outside(usual, &subject, false)) else {
        return false;
    };
    let size = subject.bounds.max - subject.bounds.min;
    light.kind = LightKind::Point { position: room.lamp };
    light.source = Some(Source::Sphere { radius: 0.03 * size.min_element() });
    light.intensity *= LAMP * size.x * size.z;
    true
}

/// Turns the default light of a file: over the viewer's left shoulder, so low that the shadow falls into view
/// beside its caster; as large as the sun.
pub(super) fn aim_sun(light: &mut Light, camera: &Camera) {
    light.source = light.source.or(Some(Source::Sun { angle: SunDisc::USUAL_ANGLE }));
    let forward = camera.target - camera.eye;
    let flat = Vec3::new(forward.x, 0.0, forward.z).try_normalize().unwrap_or(Vec3::NEG_Z);
    let right = flat.cross(Vec3::Y);
    let direction = (right * 0.85 + flat * 0.3 - Vec3::Y).normalize();
    light.kind = LightKind::Directional { direction };
}
