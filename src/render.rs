//! Scenes to frames, on a GPU or on the CPU.
use crate::{
    counters::Counters,
    cpu,
    error::Error,
    frame::{Frame, ViewMaps},
    gpu::{Backend, Gpu, Selection, Timeline},
    pipeline::{CasterSet, Config, ListCounters, Pipeline, Prepared},
    scene::Scene,
    view::{View, shadow_views},
};
use half::f16;

/// Renders scenes on one device.
#[derive(Debug)]
pub struct Renderer {
    engine: Engine,
}

#[derive(Debug)]
enum Engine {
    Gpu(Box<GpuEngine>),
    Cpu,
}

#[derive(Debug)]
struct GpuEngine {
    gpu: Gpu,
    pipeline: Pipeline,
    timeline: Timeline,
}

impl Renderer {
    /// `adapter`: part of the adapter's name; case does not matter.
    pub fn new(backend: Backend, adapter: Option<&str>) -> Result<Self, Error> {
        if backend == Backend::Cpu {
            return Ok(Self { engine: Engine::Cpu });
        }
        let selection = Selection { backend, adapter: adapter.map(str::to_owned), tier: None };
        Ok(Self::on(Gpu::new(&selection)?))
    }

    /// On a device that is already open.
    pub fn on(gpu: Gpu) -> Self {
        let pipeline = Pipeline::new(&gpu.device, Config::new(gpu.tier, &gpu.adapter));
        // A software adapter stamps when it records, not when the work is done.
        let timeline = if gpu.adapter.device_type == wgpu::DeviceType::Cpu {
            Timeline::stepped(&gpu.device, &gpu.queue)
        } else {
            Timeline::new(&gpu.device, &gpu.queue)
        };
        Self { engine: Engine::Gpu(Box::new(GpuEngine { gpu, pipeline, timeline })) }
    }

    /// What renders, for people.
    pub fn device(&self) -> String {
        match &self.engine {
            Engine::Gpu(engine) => {
                let gpu = &engine.gpu;
                format!("{} ({}; {})", gpu.adapter.name, gpu.adapter.backend, gpu.tier_reason)
            }
            Engine::Cpu => "the CPU twin".to_owned(),
        }
    }

    /// Whether particles of at most 2x2 texels skip sort and bin; what is usual depends on the
    /// adapter ([`Config::scatter_tiny`]). The CPU twin has one path only.
    pub fn set_scatter_tiny(&mut self, scatter: bool) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.pipeline.set_scatter_tiny(scatter);
        }
    }

    /// One frame. The views' maps are read back only with `maps`.
    pub fn render(&mut self, scene: &Scene, maps: bool) -> Result<Frame, Error> {
        match &mut self.engine {
            Engine::Gpu(engine) => engine.render(scene, maps),
            Engine::Cpu => Ok(render_on_cpu(scene, maps)),
        }
    }
}

fn render_on_cpu(scene: &Scene, maps: bool) -> Frame {
    let views = shadow_views(scene);
    let clock = std::time::Instant::now();
    let (view_maps, counters) = cpu::render_maps(scene, &views);
    let maps_ms = clock.elapsed().as_secs_f64() * 1e3;
    let picture = cpu::render_picture(scene, &views, &view_maps);
    let picture_ms = clock.elapsed().as_secs_f64() * 1e3 - maps_ms;
    Frame {
        picture,
        maps: if maps { view_maps } else { Vec::new() },
        counters,
        stages: vec![("maps", maps_ms), ("picture", picture_ms)],
        memory: Vec::new(),
    }
}

impl GpuEngine {
    fn render(&mut self, scene: &Scene, with_maps: bool) -> Result<Frame, Error> {
        let Self { gpu, pipeline, timeline } = self;
        let views = shadow_views(scene);
        pipeline.set_pair_budget(scene.shadow.pair_budget);
        pipeline.set_soften(scene.shadow.soften);
        pipeline.set_colored(scene.shadow.colored);
        let Scene { particles, triangles, materials, textures, .. } = scene;
        let casters =
            CasterSet::new(&gpu.device, &gpu.queue, particles, triangles, materials, textures)?;
        let mut pairs = None;
        let (prepared, opaque, translucent, mut stages) = loop {
            let prepared = pipeline.prepare(&gpu.device, &gpu.queue, &casters, &views, pairs)?;
            submit(gpu, timeline, |encoder, timeline| {
                prepared.record(pipeline.kernels(), encoder, timeline);
            });
            let (opaque, translucent) = prepared.read_counters(&gpu.device, &gpu.queue)?;
            gpu.check()?;
            let needed = opaque.pairs_needed.max(translucent.pairs_needed);
            let room = prepared.pair_capacity();
            if needed <= room || room >= scene.shadow.pair_budget {
                break (prepared, opaque, translucent, timeline.read(&gpu.device));
            }
            pairs = Some(needed);
        };
        let maps = if with_maps { read_maps(gpu, &prepared, &views)? } else { Vec::new() };
        let mut memory = prepared.memory.clone();
        let mut pairs = None;
        let picture = loop {
            let picture = pipeline.prepare_picture(
                &gpu.device,
                &gpu.queue,
                &casters,
                scene,
                &views,
                &prepared.maps,
                pairs,
            )?;
            submit(gpu, timeline, |encoder, timeline| {
                picture.record(pipeline.kernels(), encoder, timeline);
            });
            let lists = picture.read_counters(&gpu.device, &gpu.queue)?;
            let needed = lists[0].pairs_needed.max(lists[1].pairs_needed);
            let room = picture.pair_capacity();
            if needed <= room || room >= scene.shadow.pair_budget {
                break picture;
            }
            pairs = Some(needed);
        };
        let of_picture: f64 = timeline.read(&gpu.device).iter().map(|(_, ms)| ms).sum();
        stages.push(("picture", of_picture));
        for &(name, bytes) in &picture.memory.0 {
            memory.add(name, bytes);
        }
        let picture = picture.read(gpu)?;
        gpu.check()?;
        Ok(Frame {
            picture,
            maps,
            counters: counters(scene, &opaque, &translucent),
            stages,
            memory: memory.0,
        })
    }
}

/// Records, submits and starts the clock of the stages anew.
fn submit(
    gpu: &Gpu,
    timeline: &mut Timeline,
    record: impl FnOnce(&mut wgpu::CommandEncoder, &mut Timeline),
) {
    timeline.reset();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    record(&mut encoder, timeline);
    timeline.finish(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
}

fn counters(scene: &Scene, opaque: &ListCounters, translucent: &ListCounters) -> Counters {
    let sum = |of: fn(&ListCounters) -> u32| u64::from(of(opaque)) + u64::from(of(translucent));
    Counters {
        casters: (scene.particles.len() + scene.triangles.len()) as u64,
        visible: sum(|c| c.visible + c.scattered),
        pairs: sum(|c| c.pair_count),
        segments: sum(|c| c.segment_count),
        scattered: sum(|c| c.scattered + c.overflowed),
        overflowed: sum(|c| c.overflowed),
        skipped: scene.skipped.clone(),
    }
}

fn read_maps(gpu: &Gpu, prepared: &Prepared, views: &[View]) -> Result<Vec<ViewMaps>, Error> {
    let maps = &prepared.maps;
    let filters: Vec<[u16; 4]> = gpu.try_read_texture(&maps.filters)?;
    let nearests: Vec<f32> = gpu.try_read_texture(&maps.nearests)?;
    let opaques: Vec<f32> = gpu.try_read_texture(&maps.opaques)?;
    let colored: Vec<[f32; 4]> = match &maps.colored {
        Some(colored) => gpu.try_read_texture(colored)?,
        None => Vec::new(),
    };
    let atlas = maps.filters.size();
    let view_maps = views.iter().zip(&maps.places).map(|(view, place)| {
        let texels = || {
            (0..view.size.y).flat_map(move |y| {
                let row = place.layer * atlas.height + place.origin.y + y;
                let first = (row * atlas.width + place.origin.x) as usize;
                first..first + view.size.x as usize
            })
        };
        let rgb = |t: usize| [0, 1, 2].map(|i| f16::from_bits(filters[t][i]).to_f32());
        ViewMaps {
            view: view.clone(),
            filter: texels().map(rgb).collect(),
            nearest: texels().map(|t| nearests[t]).collect(),
            opaque: texels().map(|t| opaques[t]).collect(),
            colored: texels()
                .filter_map(|t| colored.get(t))
                .map(|&[r, g, b, _]| [r, g, b])
                .collect(),
        }
    });
    Ok(view_maps.collect())
}
