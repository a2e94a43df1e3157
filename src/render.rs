//! Scenes to frames, on a GPU or on the CPU.
use crate::{
    error::Error,
    gpu::{Backend, Gpu, Selection, Timeline},
    model::Scene,
    model::{Class, Counters, View},
    picture::{
        PictureRoom,
        debug::{self, DebugMode},
    },
    records::{CurveMap, NO_OWNER, Picture, ViewMaps, stored_tag},
    reference,
    shadows::{CasterSet, Config, ListCounters, Pipeline, Prepared},
    stage::sort::pair_limit,
    view::{atlas::AtlasLimits, fitted_views},
};
use half::f16;

/// One frame's results and what they cost.
#[derive(Clone, Debug)]
pub struct Frame {
    pub picture: Picture,
    /// Those that were asked for.
    pub debug: Vec<(DebugMode, Picture)>,
    /// Empty unless maps were asked for.
    pub maps: Vec<ViewMaps>,
    pub counters: Counters,
    /// Stage and its time [ms], in order.
    pub stages: Vec<(&'static str, f64)>,
    /// Buffer or texture and its size [bytes].
    pub memory: Vec<(&'static str, u64)>,
}

/// Renders scenes on one device.
#[derive(Debug)]
pub struct Renderer {
    engine: Engine,
    debug: Vec<DebugMode>,
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
    keep: bool,
    /// Whether pictures keep their linear light.
    linear: bool,
    /// Of the frame before, where its maps are kept.
    kept: Option<(CasterSet, Prepared)>,
}

impl Renderer {
    /// `adapter`: part of the adapter's name; case does not matter.
    pub fn new(backend: Backend, adapter: Option<&str>) -> Result<Self, Error> {
        if backend == Backend::Cpu {
            return Ok(Self { engine: Engine::Cpu, debug: Vec::new() });
        }
        let selection = Selection { backend, adapter: adapter.map(str::to_owned), tier: None };
        Self::on(Gpu::new(&selection)?)
    }

    /// On a device that is already open.
    pub fn on(gpu: Gpu) -> Result<Self, Error> {
        let pipeline = Pipeline::new(&gpu.device, Config::new(gpu.tier, &gpu.adapter))?;
        // A software adapter stamps when it records, not when the work is done.
        let timeline = if gpu.adapter.device_type == wgpu::DeviceType::Cpu {
            Timeline::stepped(&gpu.device, &gpu.queue)
        } else {
            Timeline::new(&gpu.device, &gpu.queue)
        };
        let engine =
            Engine::Gpu(Box::new(GpuEngine {
            gpu,
            pipeline,
            timeline,
            keep: false,
            linear: false,
            kept: None,
        }));
        Ok(Self { engine, debug: Vec::new() })
    }

    /// Whether the maps of a frame stay for the next one, which then renders only the views that
    /// see a change. Off at first; the twin renders all views in any case.
    pub fn keep_maps(&mut self, keep: bool) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.keep = keep;
            engine.kept = None;
        }
    }

    /// Whether the next pictures keep their linear light too; those of the twin always do.
    pub fn set_linear(&mut self, linear: bool) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.linear = linear;
        }
    }

    /// What the next frames show beside the picture. The CPU twin has none of it.
    pub fn set_debug(&mut self, modes: &[DebugMode]) {
        self.debug = modes.to_vec();
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

    /// For tests: whether groups behind opaque surfaces are left out, which changes no bit.
    pub fn set_hide(&mut self, hide: bool) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.pipeline.set_hide(hide);
        }
    }

    /// For tests: whether soft discs wait in a queue ([`Config::queued`]) where they may, which
    /// changes no bit.
    pub fn set_queued(&mut self, queued: bool) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.pipeline.set_queued(queued);
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
            Engine::Gpu(engine) => engine.render(scene, maps, &self.debug),
            Engine::Cpu => Ok(render_on_cpu(scene, maps)),
        }
    }
}

fn render_on_cpu(scene: &Scene, maps: bool) -> Frame {
    let (views, shrunk) = fitted_views(scene, &AtlasLimits::CORE);
    let clock = std::time::Instant::now();
    let (view_maps, mut counters) = reference::render_maps(scene, &views);
    counters.shrunk = shrunk as u64;
    let maps_ms = clock.elapsed().as_secs_f64() * 1e3;
    let picture = reference::render_picture(scene, &views, &view_maps);
    let picture_ms = clock.elapsed().as_secs_f64() * 1e3 - maps_ms;
    Frame {
        picture,
        debug: Vec::new(),
        maps: if maps { view_maps } else { Vec::new() },
        counters,
        stages: vec![("maps", maps_ms), ("picture", picture_ms)],
        memory: Vec::new(),
    }
}

impl GpuEngine {
    fn render(
        &mut self,
        scene: &Scene,
        with_maps: bool,
        debug: &[DebugMode],
    ) -> Result<Frame, Error> {
        let Self { gpu, pipeline, timeline, keep, linear, kept } = self;
        let (views, shrunk) = fitted_views(scene, &AtlasLimits::of(&gpu.device.limits()));
        let budget = scene.shadow.pair_budget.min(pair_limit(&gpu.device));
        pipeline.set_pair_budget(budget);
        pipeline.set_soften(scene.shadow.soften);
        pipeline.set_colored(scene.shadow.colored);
        pipeline.set_nodes(scene.shadow.curve_nodes());
        let Scene { particles, triangles, materials, textures, .. } = scene;
        let (casters, mut earlier) = kept.take().unzip();
        let casters = casters.and_then(|mut casters| {
            casters.update(&gpu.queue, particles, triangles, materials, textures).then_some(casters)
        });
        let casters = match casters {
            Some(casters) => casters,
            None => {
                CasterSet::new(&gpu.device, &gpu.queue, particles, triangles, materials, textures)?
            }
        };
        let mut pairs = None;
        let (prepared, opaque, translucent, mut stages) = loop {
            let (device, queue) = (&gpu.device, &gpu.queue);
            let mut prepared = match earlier.take() {
                Some(earlier) => {
                    pipeline.prepare_again(device, queue, &casters, &views, pairs, earlier)?
                }
                None => pipeline.prepare(device, queue, &casters, &views, pairs)?,
            };
            submit(gpu, timeline, |encoder, timeline| {
                prepared.record(pipeline.kernels(), encoder, timeline);
            });
            let (opaque, translucent) = prepared.read_counters(&gpu.device, &gpu.queue)?;
            gpu.check()?;
            let needed = opaque.pairs_needed.max(translucent.pairs_needed);
            let room = prepared.pair_capacity();
            if needed <= room || room >= budget {
                break (prepared, opaque, translucent, timeline.read(&gpu.device));
            }
            pairs = Some(needed);
            prepared.forget();
            earlier = Some(prepared);
        };
        let maps =
            if with_maps { read_maps(gpu, &prepared, &views, casters.owners)? } else { Vec::new() };
        let mut memory = prepared.memory.clone();
        let mut room = PictureRoom::default();
        let mut overflowed = 0;
        let prepared_picture = loop {
            let picture = pipeline.prepare_picture(
                &gpu.device,
                &gpu.queue,
                &casters,
                scene,
                &views,
                &prepared.maps,
                room,
            )?;
            submit(gpu, timeline, |encoder, timeline| {
                picture.record(pipeline.kernels(), encoder, timeline);
            });
            let Some(needs) = picture.needs(gpu, budget)? else { break picture };
            // Of the most that the budget allows at a time.
            if overflowed == 0 && needs.is_in_parts() {
                let [solid, clear] = picture.read_counters(gpu)?;
                overflowed = u64::from(solid.overflowed + clear.overflowed);
            }
            room = needs;
        };
        let of_picture: f64 = timeline.read(&gpu.device).iter().map(|(_, ms)| ms).sum();
        stages.push(("picture", of_picture));
        for &(name, bytes) in &prepared_picture.memory.0 {
            memory.add(name, bytes);
        }
        let mut picture = prepared_picture.read(gpu)?;
        if *linear {
            let radiance = prepared_picture.read_radiance(gpu)?;
            picture.light = radiance.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        }
        let clusters = prepared_picture.read_cluster_counters(gpu)?;
        let mut shown = Vec::new();
        for &mode in debug {
            let image = match mode {
                DebugMode::Clusters => debug::clusters(gpu, &prepared_picture, scene, &picture)?,
                DebugMode::Cascades => {
                    debug::cascades(gpu, &prepared_picture, scene, &views, &picture)?
                }
                DebugMode::Atlas => debug::atlas(gpu, &prepared.maps, &views)?,
                DebugMode::Cost => {
                    pipeline.set_count_cost(true);
                    let costs = pipeline.prepare_picture(
                        &gpu.device,
                        &gpu.queue,
                        &casters,
                        scene,
                        &views,
                        &prepared.maps,
                        room,
                    );
                    pipeline.set_count_cost(false);
                    let costs = costs?;
                    submit(gpu, timeline, |encoder, timeline| {
                        costs.record(pipeline.kernels(), encoder, timeline);
                    });
                    debug::cost(&picture, &costs.read_costs(gpu)?)
                }
            };
            shown.push((mode, image));
        }
        gpu.check()?;
        let of_maps = counters(scene, &opaque, &translucent);
        let counters = Counters {
            views_rendered: prepared.rendered_count() as u64,
            views_kept: (prepared.view_count() - prepared.rendered_count()) as u64,
            culled: prepared.culled_count(),
            hidden: prepared.hidden_count(),
            unordered: u64::from(translucent.overflowed)
                * u64::from(casters.span(Class::FILTERING).features.over),
            shrunk: shrunk as u64,
            cluster_lights: clusters.needed.into(),
            clusters_overflowed: clusters.overflowed.into(),
            overflowed: of_maps.overflowed + overflowed,
            ..of_maps
        };
        if *keep {
            *kept = Some((casters, prepared));
        }
        Ok(Frame { picture, debug: shown, maps, counters, stages, memory: memory.0 })
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
        disordered: sum(|c| c.disordered),
        skipped: scene.skipped.clone(),
        ..Counters::default()
    }
}

fn read_maps(
    gpu: &Gpu,
    prepared: &Prepared,
    views: &[View],
    owners: bool,
) -> Result<Vec<ViewMaps>, Error> {
    let maps = &prepared.maps;
    let filters: Vec<[u16; 4]> = gpu.try_read_texture(&maps.filters)?;
    let nearests: Vec<f32> = gpu.try_read_texture(&maps.nearests)?;
    let opaques: Vec<f32> = gpu.try_read_texture(&maps.opaques)?;
    let colored: Vec<[f32; 4]> = match &maps.colored {
        Some(colored) => gpu.try_read_texture(colored)?,
        None => Vec::new(),
    };
    let curves: Vec<[[u32; 2]; 2]> =
        if maps.nodes > 0 { gpu.try_read_texture(&maps.curves)? } else { Vec::new() };
    let atlas = maps.filters.size();
    let layer = (atlas.width * atlas.height) as usize;
    let nodes_of = |texel: usize| {
        let (z, rest) = (texel / layer, texel % layer);
        let pairs = maps.nodes as usize / 2;
        (0..pairs).flat_map(|pair| curves[(z * pairs + pair) * layer + rest]).collect::<Vec<_>>()
    };
    let view_maps = views.iter().zip(&maps.places).map(|(view, place)| {
        let texels = || {
            (0..view.size.y).flat_map(move |y| {
                let row = place.layer * atlas.height + place.origin.y + y;
                let first = (row * atlas.width + place.origin.x) as usize;
                first..first + view.size.x as usize
            })
        };
        let owner = |t: usize| match nearests[t] {
            1.0 => NO_OWNER,
            nearest => stored_tag(f16::from_bits(filters[t][3]).to_f32(), nearest),
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
            curve: (maps.nodes > 0).then(|| CurveMap {
                nodes: maps.nodes as usize,
                gain: maps.gain,
                packed: texels().flat_map(nodes_of).collect(),
            }),
            owner: if owners { texels().map(owner).collect() } else { Vec::new() },
        }
    });
    Ok(view_maps.collect())
}
