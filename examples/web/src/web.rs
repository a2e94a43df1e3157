//! The scene on a canvas.
use crate::{Knobs, Show};
use gobo::wgpu;
use wasm_bindgen::prelude::*;

/// A canvas that the scene is drawn on.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Canvas {
    surface: wgpu::Surface<'static>,
    show: Show,
    still: Show,
}

#[wasm_bindgen]
impl Canvas {
    /// Opens a device for the canvas.
    pub async fn open(canvas: web_sys::HtmlCanvasElement) -> Result<Canvas, JsError> {
        let (width, height) = (canvas.width(), canvas.height());
        let instance = wgpu::Instance::default();
        let surface = instance.create_surface(wgpu::SurfaceTarget::Canvas(canvas))?;
        let options = wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            ..Default::default()
        };
        let adapter = instance.request_adapter(&options).await?;
        let (device, queue) = adapter.request_device(&Default::default()).await?;
        let config = surface
            .get_default_config(&adapter, width, height)
            .ok_or_else(|| JsError::new("the canvas has no format"))?;
        surface.configure(&device, &config);
        let info = adapter.get_info();
        let show = Show::new(&device, &queue, &info, config.format)?;
        let still = Show::new(&device, &queue, &info, wgpu::TextureFormat::Rgba8Unorm)?;
        Ok(Self { surface, show, still })
    }

    /// Draws a frame.
    pub fn draw(&mut self, turn: f32, opacity: f32, radius: f32) -> Result<(), JsError> {
        use wgpu::CurrentSurfaceTexture::{Success, Suboptimal};
        let (Success(frame) | Suboptimal(frame)) = self.surface.get_current_texture() else {
            return Ok(());
        };
        let target = frame.texture.create_view(&Default::default());
        self.show.draw(&target, &Knobs { turn, opacity, radius })?;
        self.show.queue().present(frame);
        Ok(())
    }

    /// Picture that the test compares with the native one.
    pub async fn picture(&mut self, width: u32, height: u32) -> Result<Vec<u8>, JsError> {
        Ok(self.still.picture([width, height], &Knobs::default()).await?)
    }
}
