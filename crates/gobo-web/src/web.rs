//! The interface for JavaScript, `gobo-shadows`.
#![allow(clippy::use_self, reason = "JavaScript has the names")]

mod adapter;
mod adding;
mod canvas;
mod files;
mod maps;

use crate::{Knobs, Show, ShowError, picture, stained_glass};
use files::Dropped;
use gobo::{Scene, ShadowSettings, Shadows, Tier, wgpu};
use gobo_scene::{LoadOptions, SceneError, load_as};
use std::sync::{Arc, Mutex, PoisonError};
use wasm_bindgen::prelude::*;

/// Longest edge of a map that a device is opened for \[texels\].
const LARGEST_MAP: u32 = 4096;

/// Error as the program prints it: the problem, and a line with the remedy.
fn failure(error: &impl std::fmt::Display, help: Option<&str>) -> JsError {
    let help = help.map(|help| format!("\n  help: {help}")).unwrap_or_default();
    JsError::new(&format!("{error}{help}"))
}

fn of_scene(error: &SceneError) -> JsError {
    failure(error, error.help())
}

#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
fn of_show(error: ShowError) -> JsError {
    failure(&error, None)
}

/// The device's first error.
type Fault = Arc<Mutex<Option<String>>>;

/// Shadow maps on a WebGPU device of its own.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Gobo {
    instance: wgpu::Instance,
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Shadows of all scenes: kernels are compiled once.
    shadows: Shadows,
    tier: Tier,
    scene: Option<Scene>,
    show: Option<Show>,
    fault: Fault,
}

#[wasm_bindgen]
impl Gobo {
    /// Opens a device: of the tier `subgroups` if the browser supports it, else of `core`.
    ///
    /// @param {string} [tier] `core` or `subgroups`: no better one.
    pub async fn create(tier: Option<String>) -> Result<Gobo, JsError> {
        let most = match tier.as_deref() {
            None | Some("subgroups") => Tier::Subgroups,
            Some("core") => Tier::Core,
            Some(other) => {
                return Err(JsError::new(&format!(
                    "no such tier: {other}\n  help: core or subgroups"
                )));
            }
        };
        let instance = wgpu::Instance::default();
        let (adapter, has_subgroups) = adapter::adapter(&instance, most == Tier::Subgroups).await?;
        let tier = if has_subgroups { Tier::Subgroups } else { Tier::Core };
        let settings = ShadowSettings::default();
        // The device's limits are the adapter's, for large scenes.
        let allowed = adapter.limits();
        let limits = settings.limits(tier, LARGEST_MAP);
        let limits = wgpu::Limits {
            max_buffer_size: allowed.max_buffer_size,
            max_storage_buffer_binding_size: allowed.max_storage_buffer_binding_size,
            max_texture_dimension_2d: allowed.max_texture_dimension_2d,
            ..limits
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("gobo"),
            required_features: settings.features(tier),
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) = adapter.request_device(&descriptor).await?;
        let fault = Fault::default();
        report_faults(&device, &fault);
        let info = adapter.get_info();
        let shadows = Shadows::on_tier(&device, &queue, &info, tier)?;
        let (scene, show) = (None, None);
        Ok(Self { instance, adapter, device, queue, shadows, tier, scene, show, fault })
    }

    /// The device, for other code on it: a `GPUDevice`.
    #[wasm_bindgen(getter, unchecked_return_type = "GPUDevice")]
    pub fn device(&self) -> JsValue {
        self.device.as_webgpu().map_or(JsValue::UNDEFINED, |device| device.clone().into())
    }

    /// `core` or `subgroups`.
    #[wasm_bindgen(getter)]
    pub fn tier(&self) -> String {
        self.tier.name().to_owned()
    }

    /// The first error that the device reported, once.
    pub fn fault(&mut self) -> Option<String> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Makes the stained glass of the page the scene.
    pub fn stained_glass(&mut self) -> Result<(), JsError> {
        let scene = stained_glass().map_err(|error| of_scene(&error))?;
        self.set_scene(scene)
    }

    /// Makes files the scene: one of any kind that the program renders, and those that it names beside it.
    ///
    /// @param files Contents by name: an object of `Uint8Array`s.
    /// @returns {string} The name of the scene's file.
    pub fn open(&mut self, files: &js_sys::Object) -> Result<String, JsError> {
        let dropped = Dropped::new(files)?;
        let path = dropped.scene()?;
        let held = dropped.hold();
        let scene = load_as(&path, &LoadOptions::default()).map_err(|error| of_scene(&error));
        drop(held);
        self.set_scene(scene?)?;
        Ok(path.display().to_string())
    }

    fn set_scene(&mut self, scene: Scene) -> Result<(), JsError> {
        // Frees the former scene first, so that both need not fit.
        self.show = None;
        let shadows = self.shadows.another();
        let show = Show::new(&self.device, &self.queue, shadows, scene).map_err(of_show)?;
        self.scene = None;
        self.show = Some(show);
        Ok(())
    }

    fn shown(&mut self) -> Result<&mut Show, JsError> {
        if let Some(scene) = self.scene.take() {
            self.set_scene(scene)?;
        }
        let none = || JsError::new("there is no scene\n  help: call open or stained_glass first");
        self.show.as_mut().ok_or_else(none)
    }

    /// Contents of the scene in a line, and a line for each thing left out or ignored.
    pub fn contents(&mut self) -> Result<String, JsError> {
        let scene = self.shown()?.scene();
        let counts = [
            (scene.triangles.len(), "triangles"),
            (scene.particles.len(), "particles"),
            (scene.gaussians.len(), "splats"),
            (scene.strands.len(), "strands"),
            (scene.grids.iter().map(|grid| grid.bricks.len()).sum(), "bricks of voxels"),
            (scene.lights.len(), "lights"),
        ];
        let counts = counts.iter().filter(|(count, _)| *count > 0);
        let counts: Vec<_> = counts.map(|(count, what)| format!("{count} {what}")).collect();
        let skipped =
            scene.skipped.iter().map(|(reason, count)| format!("{count} left out: {reason}"));
        let notes = scene.notes.iter().cloned();
        let lines: Vec<_> =
            std::iter::once(counts.join(", ")).chain(skipped).chain(notes).collect();
        Ok(lines.join("\n"))
    }

    /// First picture of the scene: rgba, row by row, of `width * height` pixels.
    pub async fn picture(&mut self, width: u32, height: u32) -> Result<Vec<u8>, JsError> {
        let on = (self.device.clone(), self.queue.clone());
        let show = self.shown()?;
        let knobs = Knobs::default();
        picture((&on.0, &on.1), show, [width, height], &knobs).await.map_err(of_show)
    }
}

/// Keeps the first error of a device, instead of stopping at it.
fn report_faults(device: &wgpu::Device, fault: &Fault) {
    let keep = |fault: &Fault, message: String| {
        fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
    };
    let kept = fault.clone();
    let handler = move |error: wgpu::Error| keep(&kept, error.to_string());
    device.on_uncaptured_error(Arc::new(handler));
    let kept = fault.clone();
    device.set_device_lost_callback(move |reason, message| {
        keep(&kept, format!("the device is lost ({reason:?}): {message}"));
    });
}
