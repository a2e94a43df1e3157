//! A scene on a canvas.
use super::{Gobo, of_show};
use crate::{Knobs, show::Step};
use gobo::{Receiver, wgpu};
use wasm_bindgen::prelude::*;

/// A canvas that the scene of a `Gobo` is drawn on.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Canvas {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    knobs: Knobs,
}

/// Progress of making kernels and passes.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Made {
    step: Step,
}

#[wasm_bindgen]
impl Made {
    /// Name of the last kernel or pass.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.step.name.to_owned()
    }

    /// Number made so far.
    #[wasm_bindgen(getter)]
    pub fn made(&self) -> usize {
        self.step.made
    }

    /// Number of all.
    #[wasm_bindgen(getter)]
    pub fn all(&self) -> usize {
        self.step.all
    }
}

#[wasm_bindgen]
impl Canvas {
    /// Takes over a canvas.
    #[wasm_bindgen(constructor)]
    pub fn new(gobo: &Gobo, canvas: web_sys::HtmlCanvasElement) -> Result<Canvas, JsError> {
        let (width, height) = (canvas.width(), canvas.height());
        let surface = gobo.instance.create_surface(wgpu::SurfaceTarget::Canvas(canvas))?;
        let config = surface
            .get_default_config(&gobo.adapter, width.max(1), height.max(1))
            .ok_or_else(|| JsError::new("the canvas has no format"))?;
        surface.configure(&gobo.device, &config);
        Ok(Self { surface, config, knobs: Knobs::default() })
    }

    /// Follows a new size of the canvas \[pixels\].
    pub fn resize(&mut self, gobo: &Gobo, width: u32, height: u32) {
        (self.config.width, self.config.height) = (width.max(1), height.max(1));
        self.surface.configure(&gobo.device, &self.config);
    }

    /// Turns the camera about its target, lifts it \[radians\], and sets its distance, as a multiple of the
    /// first picture's.
    pub fn set_camera(&mut self, turn: f32, lift: f32, zoom: f32) {
        let finite = |value: f32, usual: f32| if value.is_finite() { value } else { usual };
        self.knobs.turn = finite(turn, 0.0);
        self.knobs.lift = finite(lift, 0.0);
        self.knobs.zoom = finite(zoom, 1.0);
    }

    /// Turns and lifts the first light \[radians\].
    pub fn set_sun(&mut self, turn: f32, lift: f32) {
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        (self.knobs.sun_turn, self.knobs.sun_lift) = (finite(turn), finite(lift));
    }

    /// Reads shadows from the whole curve, or from the nearest depth alone.
    pub fn set_curve(&mut self, curve: bool) {
        self.knobs.receiver = if curve { Receiver::Curve } else { Receiver::Nearest };
    }

    /// Sets the longest edge of shadow maps \[texels\].
    pub fn set_most_texels(&self, gobo: &mut Gobo, most: u32) -> Result<(), JsError> {
        gobo.shown()?.set_most_texels(most.clamp(16, super::LARGEST_MAP));
        Ok(())
    }

    /// Makes the next kernel or pass that a frame needs; `undefined` once all are made.
    pub fn make(&self, gobo: &mut Gobo) -> Result<Option<Made>, JsError> {
        let size = [self.config.width, self.config.height];
        let step = gobo.shown()?.step(&self.knobs, size).map_err(of_show)?;
        Ok(step.map(|step| Made { step }))
    }

    /// Draws a frame; all kernels and passes must be made. Returns whether shadow maps were rendered, too.
    pub fn draw(&self, gobo: &mut Gobo) -> Result<bool, JsError> {
        use wgpu::CurrentSurfaceTexture::{Suboptimal, Success};
        let size = [self.config.width, self.config.height];
        let (Success(frame) | Suboptimal(frame)) = self.surface.get_current_texture() else {
            return Ok(false);
        };
        let target = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let show = gobo.shown()?;
        let drawn = show.draw(&target, self.config.format, size, &self.knobs).map_err(of_show)?;
        gobo.queue.present(frame);
        Ok(drawn)
    }
}
