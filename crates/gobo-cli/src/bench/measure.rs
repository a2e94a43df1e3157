//! Measurement of one case, compute and raster: first the maps are compared, then the times are taken in
//! turns.
use super::{
    arguments::{BenchArguments, ReceiverName},
    case::{Case, casters_of},
    check::check,
    clock::{Clock, Times},
    raster::{
        Geometry, Inputs, Precision, Raster, Recipe,
        agree::{Difference, Map, Rounding, agree},
    },
};
use crate::{failure::Failure, report::as_map};
use gobo::{
    Counters, Prepared, Receiver, ShadowSettings, Shadows,
    gpu::{Gpu, KernelTime, Timeline},
    model::{Casters, View},
    shadows::Config,
    wgpu,
};
use half::f16;
use serde::Serialize;
use tracing::debug_span;

/// Results of a case.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    #[serde(flatten)]
    pub(super) case: Case,
    #[serde(flatten)]
    pub(super) compute: Measured,
    #[serde(flatten)]
    pub(super) raster: Option<RasterRow>,
}

/// Times and costs of the maps.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Measured {
    pub(super) runs: u32,
    pub(super) compute_ms: f64,
    pub(super) compute_min: f64,
    pub(super) compute_max: f64,
    /// Phases of the command since the last row, and their times on the wall clock [ms].
    #[serde(serialize_with = "as_map")]
    pub(super) milliseconds: Vec<(&'static str, f64)>,
    /// Stages and their times [ms]; each was waited for, so their sum exceeds a frame's time.
    #[serde(serialize_with = "as_map")]
    pub(super) stages: Vec<(&'static str, f64)>,
    /// Each dispatch was waited for or is a pass of its own, so their sum exceeds the stages'.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) kernels: Vec<KernelRow>,
    /// Buffers and textures, and their sizes [bytes].
    #[serde(serialize_with = "as_map")]
    pub(super) bytes: Vec<(&'static str, u64)>,
    pub(super) pairs: u64,
    pub(super) pairs_needed: u32,
    pub(super) segments: u64,
    pub(super) scattered: u64,
    pub(super) overflowed: u64,
}

/// Dispatches of a kernel in a stage, and the sum of their times \[ms\].
#[derive(Clone, Debug, Serialize)]
pub(super) struct KernelRow {
    pub(super) stage: &'static str,
    pub(super) kernel: &'static str,
    pub(super) dispatches: u32,
    pub(super) ms: f64,
}

/// Results of the raster baseline.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RasterRow {
    /// Median time of the faster recipe [ms].
    pub(super) raster_ms: f64,
    pub(super) raster_min: f64,
    pub(super) raster_max: f64,
    /// `raster_ms / compute_ms`: above 1 if compute is faster.
    pub(super) ratio: f64,
    /// Time of colour and nearest depth in one pass [ms].
    pub(super) raster_one_pass_ms: f64,
    /// Time of a depth pass followed by a colour pass [ms].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) raster_two_pass_ms: Option<f64>,
    /// The faster vertex input of the quads.
    pub(super) raster_geometry: &'static str,
    #[serde(flatten)]
    pub(super) held: Held,
}

/// Largest difference between the maps over all views.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Held {
    /// Difference from both recipes.
    pub(super) difference: Difference,
    /// Difference from a raster pass whose product is 32-bit, if the device can blend it.
    pub(super) difference_float: Option<Difference>,
}

/// Input of both paths.
struct Scene<'a> {
    case: Case,
    inputs: &'a Inputs,
    views: &'a [View],
}

pub(super) struct Bench {
    pub(super) gpu: Gpu,
    pub(super) clock: Clock,
    pub(super) settings: ShadowSettings,
    pub(super) kernels: bool,
    /// Settings of the measured maps.
    pub(super) config: Config,
    runs: u32,
}

const WARM_UP: usize = 2;
/// Frames per geometry; the fastest counts.
const GEOMETRY_TRIES: usize = 4;

impl Bench {
    pub(super) fn new(gpu: Gpu, arguments: &BenchArguments) -> Self {
        // The measured settings are those that were asked for.
        let mut settings = ShadowSettings {
            receiver: match arguments.receiver {
                ReceiverName::Nearest => Receiver::Nearest,
                ReceiverName::Curve => Receiver::Curve,
            },
            nodes: arguments.nodes,
            curve_budget: u64::MAX,
            ..ShadowSettings::default()
        };
        if let Some(pairs) = arguments.pair_budget {
            settings.pair_budget = pairs;
        }
        let (runs, kernels) = (arguments.runs, arguments.kernels);
        let config = Config::new(gpu.tier, &gpu.adapter);
        Self { clock: Clock::new(&gpu), gpu, settings, kernels, config, runs }
    }

    pub(super) fn run(
        &mut self,
        case: Case,
        inputs: &Inputs,
        with_raster: bool,
    ) -> Result<Row, Failure> {
        let (views, materials) = (case.views(), [case.material()]);
        let casters = casters_of(inputs, &materials);
        let prepared = self.prepare(&casters, &views)?;
        let maps = self.read(&prepared, &case)?;
        let comparing = debug_span!("compare").entered();
        for (light, (map, view)) in maps.iter().zip(&views).enumerate() {
            check(map, inputs, view).map_err(|wrong| {
                Failure::Wrong(format!(
                    "{case}: the compute map of light {light} is wrong: {wrong}"
                ))
            })?;
        }
        let scene = Scene { case, inputs, views: &views };
        let raster = with_raster.then(|| self.raster(inputs, &views)).transpose()?;
        let held = raster.as_ref().map(|raster| self.hold(&scene, raster, &maps)).transpose()?;
        drop(maps);
        drop(comparing);

        let Some((raster, held)) = raster.zip(held) else {
            let times = self.times(&prepared, &[])?;
            return self.row(case, &prepared, times[0], None);
        };
        let one_pass = |encoder: &mut _| raster.record(encoder, Recipe::OnePass);
        let two_pass = |encoder: &mut _| raster.record(encoder, Recipe::TwoPass);
        let times = self.times(&prepared, &[&one_pass, &two_pass])?;
        let best = if times[1].median <= times[2].median { times[1] } else { times[2] };
        let row = RasterRow {
            raster_ms: best.median,
            raster_min: best.min,
            raster_max: best.max,
            ratio: best.median / times[0].median,
            raster_one_pass_ms: times[1].median,
            raster_two_pass_ms: Some(times[2].median),
            raster_geometry: match raster.geometry() {
                Geometry::Instances => "instances",
                Geometry::Indexed => "indexed",
            },
            held,
        };
        self.row(case, &prepared, times[0], Some(row))
    }

    /// Frame times of compute first, then of the baselines, measured in turns.
    pub(super) fn times(
        &mut self,
        prepared: &Prepared,
        opponents: &[&dyn Fn(&mut wgpu::CommandEncoder)],
    ) -> Result<Vec<Times>, Failure> {
        let mut times = vec![Vec::new(); 1 + opponents.len()];
        for run in 0..WARM_UP + self.runs as usize {
            let mut frame = vec![self.compute(prepared)?];
            for baseline in opponents {
                frame.push(self.clock.time(&self.gpu, |encoder| baseline(encoder))?);
            }
            if run >= WARM_UP {
                for (times, ms) in times.iter_mut().zip(frame) {
                    times.push(ms);
                }
            }
        }
        Ok(times.into_iter().map(Times::new).collect())
    }

    pub(super) fn row(
        &self,
        case: Case,
        prepared: &Prepared,
        compute: Times,
        raster: Option<RasterRow>,
    ) -> Result<Row, Failure> {
        Ok(Row { case, compute: self.measured(prepared, compute)?, raster })
    }

    pub(super) fn measured(
        &self,
        prepared: &Prepared,
        compute: Times,
    ) -> Result<Measured, Failure> {
        let timeline = self.timed(prepared, self.timeline())?;
        let stages = timeline.read(&self.gpu.device);
        let kernels = if self.kernels { self.kernels(prepared)? } else { Vec::new() };
        let counters = prepared.counters()?;
        Ok(Measured {
            runs: self.runs,
            compute_ms: compute.median,
            compute_min: compute.min,
            compute_max: compute.max,
            milliseconds: Vec::new(),
            stages,
            kernels,
            bytes: prepared.memory().0.clone(),
            pairs: counters.pairs,
            pairs_needed: counters.pairs_needed,
            segments: counters.segments,
            scattered: counters.scattered,
            overflowed: counters.overflowed,
        })
    }

    /// Prepares maps with capacity for all pairs, within the budget, and runs them once.
    pub(super) fn prepare(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
    ) -> Result<Prepared, Failure> {
        let _preparing = debug_span!("prepare").entered();
        let mut known: Option<Counters> = None;
        loop {
            let Gpu { device, queue, kernels, .. } = &self.gpu;
            // New maps each time: reused ones are cleared by a kernel.
            let mut shadows = Shadows::sharing(device, queue, self.config, kernels.clone())?;
            if let Some(counters) = &known {
                shadows.grow_from(counters);
            }
            let prepared = shadows.prepare(casters, views, &self.settings)?;
            self.compute(&prepared)?;
            let counters = prepared.counters()?;
            if !shadows.grow_from(&counters) && known.is_some() {
                return Ok(prepared);
            }
            // The next knows what it needs, as later frames do.
            known = Some(counters);
        }
    }

    /// Time of the whole translucent pass, from casters to maps [ms].
    pub(super) fn compute(&self, prepared: &Prepared) -> Result<f64, Failure> {
        let mut recorded = Ok(());
        let ms = self.clock.time(&self.gpu, |encoder| recorded = prepared.record(encoder))?;
        recorded?;
        Ok(ms)
    }

    fn read(&self, prepared: &Prepared, case: &Case) -> Result<Vec<Map>, Failure> {
        let _reading = debug_span!("read_back").entered();
        let maps = prepared.maps();
        let filters: Vec<[u16; 4]> = self.gpu.try_read_texture(&maps.filters)?;
        let nearests: Vec<f32> = self.gpu.try_read_texture(&maps.nearests)?;
        let atlas = maps.filters.size();
        let views = maps.slots.iter().map(|slot| {
            let first = |y| {
                let row = slot.layer * atlas.height + slot.origin.y + y;
                (row * atlas.width + slot.origin.x) as usize
            };
            let texels = || (0..case.size).flat_map(|y| first(y)..first(y) + case.size as usize);
            let rgb = |at: usize| [0, 1, 2].map(|i| f16::from_bits(filters[at][i]).to_f32());
            Map {
                width: case.size,
                filter: texels().map(rgb).collect(),
                nearest: texels().map(|at| nearests[at]).collect(),
            }
        });
        Ok(views.collect())
    }

    /// Baseline with the faster geometry.
    fn raster(&self, inputs: &Inputs, views: &[View]) -> Result<Raster, Failure> {
        let mut best: Option<(f64, Raster)> = None;
        for geometry in [Geometry::Instances, Geometry::Indexed] {
            let raster = Raster::new(&self.gpu, geometry, Precision::Half, inputs, views);
            let mut ms = f64::INFINITY;
            for _ in 0..GEOMETRY_TRIES {
                let record = |encoder: &mut _| raster.record(encoder, Recipe::OnePass);
                ms = ms.min(self.clock.time(&self.gpu, record)?);
            }
            if best.as_ref().is_none_or(|(least, _)| ms < *least) {
                best = Some((ms, raster));
            }
        }
        Ok(best.expect("there is a geometry").1)
    }

    /// Compares our maps with those of both recipes; and, with a smaller tolerance, with a product of full
    /// precision if the device can blend one.
    fn hold(&self, scene: &Scene<'_>, raster: &Raster, maps: &[Map]) -> Result<Held, Failure> {
        let differs = |light: usize, path: &str, wrong: &str| {
            let case = scene.case;
            Failure::Wrong(format!(
                "{case}: the maps of light {light} differ from {path}, no time is given: {wrong}"
            ))
        };
        let mut held = Held { difference: Difference::default(), difference_float: None };
        if self.gpu.has(wgpu::Features::FLOAT32_BLENDABLE) {
            let Scene { inputs, views, .. } = scene;
            let geometry = raster.geometry();
            let exact = Raster::new(&self.gpu, geometry, Precision::Float, inputs, views);
            self.clock.time(&self.gpu, |encoder| exact.record(encoder, Recipe::OnePass))?;
            let mut largest = Difference::default();
            let theirs = exact.read(&self.gpu, Recipe::OnePass)?;
            for (light, (ours, theirs)) in maps.iter().zip(&theirs).enumerate() {
                let difference = agree(ours, theirs, Rounding::Float)
                    .map_err(|wrong| differs(light, "raster at full precision", &wrong))?;
                largest = largest.max(difference);
            }
            held.difference_float = Some(largest);
        }
        let layers: Vec<_> = scene.views.iter().map(|view| scene.inputs.layers(view)).collect();
        for recipe in [Recipe::OnePass, Recipe::TwoPass] {
            self.clock.time(&self.gpu, |encoder| raster.record(encoder, recipe))?;
            let theirs = raster.read(&self.gpu, recipe)?;
            for (light, (ours, theirs)) in maps.iter().zip(&theirs).enumerate() {
                let difference = agree(ours, theirs, Rounding::Half(&layers[light]))
                    .map_err(|wrong| differs(light, "raster", &wrong))?;
                held.difference = held.difference.max(difference);
            }
        }
        Ok(held)
    }

    fn timeline(&self) -> Timeline {
        let Gpu { device, queue, .. } = &self.gpu;
        if self.clock.has_stamps() {
            Timeline::new(device, queue)
        } else {
            Timeline::stepped(device, queue)
        }
    }

    /// Times the second of two frames.
    fn timed(&self, prepared: &Prepared, mut timeline: Timeline) -> Result<Timeline, Failure> {
        let Gpu { device, queue, .. } = &self.gpu;
        let _kernels = debug_span!("kernels").entered();
        for _ in 0..2 {
            timeline.reset();
            let mut encoder = device.create_command_encoder(&Default::default());
            prepared.record_timed(&mut encoder, &mut timeline)?;
            timeline.finish(&mut encoder);
            queue.submit([encoder.finish()]);
        }
        self.gpu.check()?;
        Ok(timeline)
    }

    fn kernels(&self, prepared: &Prepared) -> Result<Vec<KernelRow>, Failure> {
        let timeline = self.timed(prepared, self.timeline().by_kernel())?;
        let untimed = timeline.untimed_passes();
        if untimed > 0 {
            tracing::warn!(
                "a frame has {untimed} dispatches more than timestamps: they have no time"
            );
        }
        let rows = timeline.read_kernels(&self.gpu.device).into_iter();
        Ok(rows
            .map(|KernelTime { stage, kernel, dispatches, ms }| KernelRow {
                stage,
                kernel,
                dispatches,
                ms,
            })
            .collect())
    }
}
