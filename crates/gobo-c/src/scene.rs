//! Scenes: from texts, files and arrays.
use crate::fault::{Fault, array, code, free, give, needed_text, object, object_mut, text};
use gobo::{
    Camera, Light, LightKind, Particle, Shape, Triangle,
    glam::{UVec2, Vec3},
    model::{InvalidLight, Scene},
};
use gobo_scene as scene;
use gobo_scene::{Limit, LoadOptions};
use std::{
    ffi::{c_char, c_int},
    path::Path,
};

/// Farthest coordinate of a scene [m].
const FARTHEST: f32 = 1e7;

/// A scene behind the callers' pointer.
#[derive(Debug)]
pub(crate) struct HeldScene {
    pub(crate) scene: Scene,
    /// Id of the next caster: only dither patterns depend on it.
    next_id: u32,
}

/// `gobo_light` of the header.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct CLight {
    pub(crate) kind: u32,
    pub(crate) position: [f32; 3],
    pub(crate) direction: [f32; 3],
    pub(crate) angle: f32,
    pub(crate) color: [f32; 3],
    pub(crate) intensity: f32,
    pub(crate) map_size: u32,
}

/// `gobo_camera` of the header.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct CCamera {
    pub(crate) eye: [f32; 3],
    pub(crate) target: [f32; 3],
    pub(crate) up: [f32; 3],
    pub(crate) fov_y: f32,
    pub(crate) size: [u32; 2],
}

fn held(scene: Scene) -> HeldScene {
    HeldScene { next_id: scene.particles.len() as u32, scene }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_from_text(
    text: *const c_char,
    path: *const c_char,
    scene: *mut *mut HeldScene,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (contents, path) =
            unsafe { (needed_text(text, "text")?, crate::fault::text(path, "path")?) };
        let path = Path::new(path.unwrap_or("scene.toml"));
        let made = || Ok(held(scene::load_text(contents, path, &LoadOptions::default())?));
        // SAFETY: the caller's promise.
        unsafe { give(scene, "scene", made) }
    })
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_load(
    path: *const c_char,
    scene: *mut *mut HeldScene,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let path = unsafe { needed_text(path, "path")? };
        // SAFETY: the caller's promise.
        unsafe { give(scene, "scene", || Ok(held(scene::load(Path::new(path))?))) }
    })
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_free(scene: *mut HeldScene) {
    // SAFETY: the caller's promise.
    unsafe { free(scene) }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_set_time(scene: *mut HeldScene, seconds: f64) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let held = unsafe { object_mut(scene, "scene")? };
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(Fault::input(format!("seconds is {seconds}; give 0 or more")));
        }
        held.scene.set_time(seconds);
        Ok(())
    })
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_set_camera(
    scene: *mut HeldScene,
    camera: *const CCamera,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (held, given) = unsafe { (object_mut(scene, "scene")?, *object(camera, "camera")?) };
        let origin = held.scene.origin;
        let [eye, target, up] = [given.eye, given.target, given.up].map(Vec3::from);
        let size = UVec2::from(given.size);
        let is_near = |at: Vec3| at.is_finite() && at.abs().max_element() <= FARTHEST;
        let looks = (target - eye).normalize_or_zero().cross(up) != Vec3::ZERO;
        let is_cone = given.fov_y > 0.0 && given.fov_y < std::f32::consts::PI;
        let has_pixels = size.min_element() > 0 && size.max_element() <= 16_384;
        if !(is_near(eye) && is_near(target) && up.is_finite() && looks && is_cone && has_pixels) {
            let message = "the camera's numbers must be finite and within 1e7 m; it must look \
                           somewhere, not along up, \
                           with a field of view between 0 and pi and 1 to 16384 pixels a side";
            return Err(Fault::input(message));
        }
        let (eye, target) = (eye - origin, target - origin);
        held.scene.camera = Camera { eye, target, up, fov_y: given.fov_y, size };
        Ok(())
    })
}

impl HeldScene {
    fn material(&self, name: &str) -> Result<u32, Fault> {
        let materials = &self.scene.materials;
        let found = materials.iter().rposition(|material| material.name == name);
        let index = found.ok_or_else(|| {
            let known: Vec<_> = materials.iter().take(20).map(|m| m.name.as_str()).collect();
            Fault::input(format!("no material is named {name:?}; there are {}", known.join(", ")))
        })?;
        Ok(index as u32)
    }

    fn check_limit(limit: Limit, have: usize, more: usize) -> Result<(), Fault> {
        let (all, most) = ((have as u64).saturating_add(more as u64), limit.most());
        if all <= most {
            return Ok(());
        }
        Err(Fault::input(format!("{all} {}, but a scene has at most {most}", limit.noun())))
    }

    /// Adds the valid ones of `count`; `make` makes each from its number and its id. Returns the number of
    /// invalid ones; `has_count`: whether the caller accepts any.
    fn add<T>(
        &mut self,
        count: usize,
        has_count: bool,
        items: impl Fn(&mut Scene) -> &mut Vec<T>,
        make: impl Fn(usize, u32) -> Result<T, (&'static str, &'static str)>,
    ) -> Result<usize, Fault> {
        let list = items(&mut self.scene);
        let have = list.len();
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        list.try_reserve(count).map_err(|_| Fault::memory(bytes))?;
        let mut left_out = 0;
        for row in 0..count {
            match make(row, self.next_id.wrapping_add(row as u32)) {
                Ok(item) => list.push(item),
                Err(_) if has_count => left_out += 1,
                Err((what, problem)) => {
                    list.truncate(have);
                    return Err(Fault::input(format!("{what} {row} cannot be used: {problem}")));
                }
            }
        }
        self.next_id = self.next_id.wrapping_add(count as u32);
        Ok(left_out)
    }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_add_particles(
    scene: *mut HeldScene,
    count: usize,
    centers: *const f32,
    radii: *const f32,
    colors: *const f32,
    material: *const c_char,
    left_out: *mut usize,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (held, centers, radii, name) = unsafe {
            let centers = array(centers.cast::<[f32; 3]>(), count, "centers")?;
            let radii = array(radii, count, "radii")?;
            (object_mut(scene, "scene")?, centers, radii, needed_text(material, "material")?)
        };
        let colors = match colors.is_null() {
            true => None,
            // SAFETY: the caller's promise.
            false => Some(unsafe { array(colors.cast::<[f32; 4]>(), count, "colors")? }),
        };
        if held.scene.motions.iter().any(|motion| motion.moves_particles()) {
            let message = "the scene has emitters, whose particles come last; add none to it";
            return Err(Fault::input(message));
        }
        let material = held.material(name)?;
        let made_of = &held.scene.materials[material as usize];
        if !matches!(made_of.shape, Shape::Disc | Shape::Quad | Shape::Puff) {
            return Err(Fault::input(format!("the material {name:?} is not for particles")));
        }
        let (max_color, origin) = (made_of.transfer.max_color(), held.scene.origin);
        HeldScene::check_limit(Limit::Particles, held.scene.particles.len(), count)?;
        let make = |row: usize, id| {
            let (center, radius) = (Vec3::from(centers[row]) - origin, radii[row]);
            let color = colors.map_or([1.0; 4], |colors| colors[row]).into();
            let particle = Particle { center, radius, color, material, id, rotation: 0.0 };
            particle.problem(max_color).map_or(Ok(particle), |problem| Err(("particle", problem)))
        };
        let skipped = held.add(count, !left_out.is_null(), |scene| &mut scene.particles, make)?;
        // SAFETY: the caller's promise.
        unsafe { tell(left_out, skipped) };
        Ok(())
    })
}

/// # Safety
/// `out` is NULL, or valid for a write.
unsafe fn tell(out: *mut usize, count: usize) {
    if !out.is_null() {
        // SAFETY: not NULL; the rest is the caller's promise.
        unsafe { out.write(count) };
    }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_add_triangles(
    scene: *mut HeldScene,
    count: usize,
    corners: *const f32,
    material: *const c_char,
    left_out: *mut usize,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (held, corners, name) = unsafe {
            let corners = array(corners.cast::<[[f32; 3]; 3]>(), count, "corners")?;
            (object_mut(scene, "scene")?, corners, needed_text(material, "material")?)
        };
        let (material, origin) = (held.material(name)?, held.scene.origin);
        HeldScene::check_limit(Limit::Triangles, held.scene.triangles.len(), count)?;
        let make = |row: usize, id| {
            let [a, b, c] = corners[row].map(|corner| Vec3::from(corner) - origin);
            let is_near = |at: Vec3| at.is_finite() && at.abs().max_element() <= FARTHEST;
            if ![a, b, c].into_iter().all(is_near) {
                return Err(("triangle", "not finite, or too far"));
            }
            if (b - a).cross(c - a) == Vec3::ZERO {
                return Err(("triangle", "without an area"));
            }
            Ok(Triangle { id, ..Triangle::flat([a, b, c], material) })
        };
        let skipped = held.add(count, !left_out.is_null(), |scene| &mut scene.triangles, make)?;
        // SAFETY: the caller's promise.
        unsafe { tell(left_out, skipped) };
        Ok(())
    })
}

/// The light of a scene file that states nothing but its kind.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn gobo_light_default() -> CLight {
    CLight {
        kind: 0,
        position: [0.0; 3],
        direction: [0.0, -1.0, 0.0],
        angle: 1.0,
        color: [1.0; 3],
        intensity: 1.0,
        map_size: 0,
    }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_add_light(
    scene: *mut HeldScene,
    light: *const CLight,
    name: *const c_char,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (held, given, name) =
            unsafe { (object_mut(scene, "scene")?, *object(light, "light")?, text(name, "name")?) };
        let index = held.scene.lights.len();
        HeldScene::check_limit(Limit::Lights, index, 1)?;
        let position = Vec3::from(given.position) - held.scene.origin;
        let direction = Vec3::from(given.direction);
        let kind = match given.kind {
            0 => LightKind::Directional { direction },
            1 => LightKind::Spot { position, direction, angle: given.angle },
            2 => LightKind::Point { position },
            other => {
                return Err(Fault::input(format!("the light's kind is {other}; give 0, 1 or 2")));
            }
        };
        if given.map_size != 0 && !(16..=4096).contains(&given.map_size) {
            let message =
                format!("the light's map_size is {}; give 16 to 4096, or 0", given.map_size);
            return Err(Fault::input(message));
        }
        let light = Light {
            name: name.unwrap_or("light").to_owned(),
            kind,
            color: given.color.into(),
            intensity: given.intensity,
            size: (given.map_size > 0).then_some(given.map_size),
            ..Light::default()
        };
        light.check(index).map_err(|error: InvalidLight| Fault::input(error.to_string()))?;
        held.scene.lights.push(light);
        Ok(())
    })
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_scene_light_count(scene: *const HeldScene) -> usize {
    // SAFETY: the caller's promise.
    unsafe { scene.as_ref() }.map_or(0, |held| held.scene.lights.len())
}
