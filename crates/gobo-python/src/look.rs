//! A call's view of a scene: its camera, and the exposure of the picture.
use crate::{
    fault::Fault,
    state::State,
    tables::{scene_of, within},
};
use gobo::{
    Camera, Receiver, ShadowSettings,
    glam::Vec2,
    model::{Lens, Occlusion, Tone},
};
use gobo_scene::Scene;
use toml::Table;

/// Settings of a scene that a call may override.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    camera: Camera,
    exposure: f32,
    samples: u32,
    shift: Vec2,
    occlusion: Occlusion,
    bloom: f32,
    lens: Lens,
    shutter: f32,
    tone: Tone,
    shadow: ShadowSettings,
}

impl Look {
    fn of(scene: &Scene) -> Self {
        Self {
            camera: scene.camera,
            exposure: scene.exposure,
            samples: scene.samples,
            shift: scene.shift,
            occlusion: scene.occlusion,
            bloom: scene.bloom,
            lens: scene.lens,
            shutter: scene.shutter,
            tone: scene.tone,
            shadow: scene.shadow,
        }
    }

    fn put(self, scene: &mut Scene) {
        let Self {
            camera,
            exposure,
            samples,
            shift,
            occlusion,
            bloom,
            lens,
            shutter,
            tone,
            shadow,
        } = self;
        (scene.camera, scene.exposure, scene.samples) = (camera, exposure, samples);
        scene.shift = shift;
        (scene.occlusion, scene.bloom, scene.lens) = (occlusion, bloom, lens);
        (scene.shutter, scene.tone, scene.shadow) = (shutter, tone, shadow);
    }

    /// Applies the values of a `[camera]` table. Without a placed camera, the camera frames the whole scene.
    fn changed(mut self, state: &State, table: &Table) -> Result<Self, Fault> {
        let given = scene_of("camera", &within("camera", table.clone()))?;
        let size = if table.contains_key("size") { given.camera.size } else { self.camera.size };
        if table.contains_key("eye") && table.contains_key("target") {
            self.camera = given.camera;
        } else if !state.has_camera {
            self.camera = gobo_scene::usual_camera(&state.scene, size);
        }
        self.camera.size = size;
        for key in table.keys() {
            match key.as_str() {
                "exposure" => self.exposure = given.exposure,
                "samples" => self.samples = given.samples,
                "shift" => self.shift = given.shift,
                "occlusion" => self.occlusion = given.occlusion,
                "bloom" => self.bloom = given.bloom,
                "lens" | "focus" => self.lens = given.lens,
                "shutter" => self.shutter = given.shutter,
                "tone" => self.tone = given.tone,
                _ => {}
            }
        }
        Ok(self)
    }
}

/// Sets the default camera of calls.
pub(crate) fn place(state: &mut State, table: &Table) -> Result<(), Fault> {
    let look = Look::of(&state.scene).changed(state, table)?;
    look.put(&mut state.scene);
    state.has_camera |= table.contains_key("eye") && table.contains_key("target");
    Ok(())
}

/// Does `work` with a scene, seen by the camera of a `[camera]` table. `curve`: nodes of curves, 0 for none.
pub(crate) fn with<T>(
    state: &mut State,
    table: &Table,
    curve: Option<u32>,
    work: impl FnOnce(&mut State) -> Result<T, Fault>,
) -> Result<T, Fault> {
    let own = Look::of(&state.scene);
    let mut look = own.clone().changed(state, table)?;
    match curve {
        Some(0) => look.shadow.receiver = Receiver::Nearest,
        Some(nodes) => (look.shadow.receiver, look.shadow.nodes) = (Receiver::Curve, nodes),
        None => {}
    }
    look.put(&mut state.scene);
    let result = work(state);
    own.put(&mut state.scene);
    result
}
