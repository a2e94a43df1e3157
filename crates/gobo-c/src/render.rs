//! Renderers, frames, and light at points.
use crate::{
    fault::{Fault, array, array_mut, code, free, give, object, object_mut, text},
    frame::HeldFrame,
    scene::HeldScene,
};
use gobo::{Scene, glam::Vec3, host::Backend, model::ReceiverPoint};
use gobo_cli::Needs;
use gobo_picture::{RenderOptions, Renderer};
use std::ffi::{c_char, c_int};

/// Bits of the rendered outputs.
const PICTURE: u32 = 1;
const MAPS: u32 = 2;
/// Farthest coordinate of a point [m].
const FARTHEST: f32 = 1e7;

/// A renderer behind the callers' pointer.
#[derive(Debug)]
pub(crate) struct HeldRenderer(Renderer);

impl HeldRenderer {
    fn check(&self, needs: Needs, scene: &Scene) -> Result<(), Fault> {
        let needs = Needs { backend_is_cpu: !self.0.has_device(), ..needs };
        needs.missing(scene).map_or(Ok(()), |bytes| Err(Fault::memory(bytes)))
    }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_renderer_open(
    backend: u32,
    name: *const c_char,
    renderer: *mut *mut HeldRenderer,
) -> c_int {
    code(|| {
        let backend = match backend {
            0 => Backend::Auto,
            1 => Backend::Vulkan,
            2 => Backend::Metal,
            3 => Backend::Dx12,
            4 => Backend::Gl,
            5 => Backend::Cpu,
            other => return Err(Fault::input(format!("backend is {other}; give 0 to 5"))),
        };
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name")? };
        let made = || Ok(HeldRenderer(Renderer::new(backend, name)?));
        // SAFETY: the caller's promise.
        unsafe { give(renderer, "renderer", made) }
    })
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_renderer_free(renderer: *mut HeldRenderer) {
    // SAFETY: the caller's promise.
    unsafe { free(renderer) }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_render(
    renderer: *mut HeldRenderer,
    scene: *const HeldScene,
    what: u32,
    frame: *mut *mut HeldFrame,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (by, held) = unsafe { (object_mut(renderer, "renderer")?, object(scene, "scene")?) };
        if !(1..=PICTURE | MAPS).contains(&what) {
            let message = format!("what is {what}; give GOBO_PICTURE, GOBO_MAPS or their sum");
            return Err(Fault::input(message));
        }
        let (picture, maps) = (what & PICTURE > 0, what & MAPS > 0);
        by.check(Needs { picture, maps, ..Needs::default() }, &held.scene)?;
        // A picture beside maps is made from them.
        let own = (maps && held.scene.shadow.detail).then(|| {
            let mut scene = held.scene.clone();
            scene.shadow.detail = false;
            scene
        });
        let scene = own.as_ref().unwrap_or(&held.scene);
        let options = RenderOptions {
            maps,
            maps_only: !picture,
            light: picture,
            keep: true,
            ..RenderOptions::default()
        };
        let made = || Ok(HeldFrame::of(by.0.render(scene, &options)?, scene, picture));
        // SAFETY: the caller's promise.
        unsafe { give(frame, "frame", made) }
    })
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_light_points(
    renderer: *mut HeldRenderer,
    scene: *const HeldScene,
    count: usize,
    positions: *const f32,
    normals: *const f32,
    shares: *mut f32,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let (by, held, positions) = unsafe {
            let positions = array(positions.cast::<[f32; 3]>(), count, "positions")?;
            (object_mut(renderer, "renderer")?, object(scene, "scene")?, positions)
        };
        let normals = match normals.is_null() {
            true => None,
            // SAFETY: the caller's promise.
            false => Some(unsafe { array(normals.cast::<[f32; 3]>(), count, "normals")? }),
        };
        let lights = held.scene.lights.len();
        let answers = count.saturating_mul(lights);
        // SAFETY: the caller's promise.
        let out = unsafe { array_mut(shares.cast::<[f32; 3]>(), answers, "shares")? };
        by.check(Needs { points: count as u64, ..Needs::default() }, &held.scene)?;
        let mut points = Vec::new();
        let bytes = count as u64 * size_of::<ReceiverPoint>() as u64;
        points.try_reserve_exact(count).map_err(|_| Fault::memory(bytes))?;
        for (row, &position) in positions.iter().enumerate() {
            let position = Vec3::from(position);
            let normal = normals.map_or(Vec3::ZERO, |normals| normals[row].into());
            let is_near = position.is_finite() && position.abs().max_element() <= FARTHEST;
            // A normal of length zero counts as none.
            let unit = if normal == Vec3::ZERO { Some(normal) } else { normal.try_normalize() };
            let (true, Some(normal)) = (is_near, unit) else {
                let message = format!(
                    "point {row}: positions must be finite and within 1e7 m, normals finite"
                );
                return Err(Fault::input(message));
            };
            points.push(ReceiverPoint { position, normal });
        }
        out.copy_from_slice(&by.0.light_points(&held.scene, &points)?);
        Ok(())
    })
}
