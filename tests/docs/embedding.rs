//! The Rust of docs/embedding.md: compiled here, and compared with the document line by line.
use gobo::{
    Bounds, Camera, Casters, Light, Prepared, ShadowSettings, Shadows, View, host::LightMasks, wgpu,
};

type Done = Result<(), Box<dyn std::error::Error>>;

const SMOKE_WGSL: &str = "";
const SPLATS_WGSL: &str = "";
const FORWARD_WGSL: &str = "";
const SKY_WGSL: &str = "";

/// A host's variables, by their names in the document.
struct Host<'a> {
    adapter_info: wgpu::AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    encoder: wgpu::CommandEncoder,
    pass: wgpu::RenderPass<'a>,
    shadows: Shadows,
    prepared: Prepared,
    masks: LightMasks,
    casters: Casters<'a>,
    views: Vec<View>,
    settings: ShadowSettings,
    lights: Vec<Light>,
    camera: Camera,
    bounds: Bounds,
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    alive: wgpu::Buffer,
    positions: wgpu::Buffer,
    density: wgpu::Texture,
    count: u32,
    pool: rayon::ThreadPool,
    simulation: Recorded,
    place_points: Recorded,
    smoke: Smoke,
}

struct Recorded;

impl Recorded {
    fn record(&self, _: &mut wgpu::CommandEncoder) {}
}

struct Smoke;

impl Smoke {
    fn new(_: &wgpu::Device, _: &Shadows) -> Result<Self, gobo::Error> {
        Ok(Self)
    }
}

fn open() -> Result<(wgpu::Device, wgpu::Queue), gobo::Error> {
    Err(gobo::Error::Superseded)
}

fn draw(_: &mut wgpu::CommandEncoder, _: &wgpu::SurfaceTexture) {}

/// The document's use of the crate.
mod wgpu_profiler {
    use gobo::wgpu::{CommandEncoder, ComputePassTimestampWrites};

    #[derive(Debug)]
    pub(super) struct GpuProfiler;

    #[derive(Debug)]
    pub(super) struct GpuProfilerQuery;

    impl GpuProfiler {
        pub(super) fn begin_pass_query(&self, _: &str, _: &mut CommandEncoder) -> GpuProfilerQuery {
            GpuProfilerQuery
        }

        pub(super) fn end_query(&self, _: &mut CommandEncoder, _: GpuProfilerQuery) {}
    }

    impl GpuProfilerQuery {
        pub(super) fn compute_pass_timestamp_writes(
            &self,
        ) -> Option<ComputePassTimestampWrites<'_>> {
            None
        }
    }
}

/// Each function contains a block of the document, unchanged.
#[rustfmt::skip]
#[allow(
    dead_code,
    unused,
    unused_qualifications,
    clippy::all,
    clippy::pedantic,
    reason = "what a document shows is compiled, not run"
)]
mod blocks {
    use super::*;
    use super::Host as F;

    async fn device(adapter: &wgpu::Adapter, yours: wgpu::Features, your_limits: wgpu::Limits) -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
        use gobo::{ShadowSettings, Tier, wgpu};

        let settings = ShadowSettings::default(); // curves of 8 nodes; with Receiver::Nearest none
        let tier = Tier::of(&adapter); // the best
        let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor {
            required_features: settings.features(tier) | yours,
            required_limits: settings.limits(tier, settings.size).or_better_values_from(&your_limits),
            ..Default::default()
        }).await?;
        Ok((device, queue))
    }

    fn support(device: wgpu::Device, adapter_info: wgpu::AdapterInfo, settings: ShadowSettings) -> Done {
        use gobo::{Support, Tier};

        let support = Support::of(&device, &adapter_info, &settings);
        for missing in &support.missing {
            println!("{missing}"); // the feature TEXTURE_ATOMIC for the native tier
        }
        support.check(Tier::Core)?;  // Error::Unsupported lists all that is missing
        Ok(())
    }

    fn frame(F { mut shadows, mut encoder, casters, settings, lights, camera, bounds, .. }: F<'_>) -> Done {
        use gobo::{View, light_views};

        let views: Vec<View> = lights.iter().enumerate()
            .map(|(i, light)| light_views(i, light, settings.size, Some(&camera), &bounds))
            .collect::<Result<Vec<_>, _>>()?.concat();
        let prepared = shadows.prepare(&casters, &views, &settings)?; // uploads what has changed
        prepared.record(&mut encoder)?;                               // maps of views that see a change
        Ok(())
    }

    fn not_submitted(F { mut shadows, mut encoder, casters, views, settings, device, queue, .. }: F<'_>, surface: wgpu::Surface<'_>, configuration: wgpu::SurfaceConfiguration) -> Done {
        use gobo::wgpu::CurrentSurfaceTexture::{Suboptimal, Success};

        shadows.prepare(&casters, &views, &settings)?.record(&mut encoder)?;
        let (Success(target) | Suboptimal(target)) = surface.get_current_texture() else {
            surface.configure(&device, &configuration); // or a surface anew
            return Ok(());                              // drops the encoder: the next `prepare` has these maps rendered
        };
        draw(&mut encoder, &target);
        queue.submit([encoder.finish()]);
        Ok(())
    }

    fn lost(F { mut shadows, mut masks, mut smoke, casters, views, settings, mut device, mut queue, adapter_info, .. }: F<'_>) -> Done {
        use gobo::{Error, Shadows, host::LightMasks};

        if let Err(Error::Lost(_)) = shadows.prepare(&casters, &views, &settings) {
            (device, queue) = open()?;             // a new adapter, too: the old one may be gone
            shadows = Shadows::new(&device, &queue, &adapter_info)?;
            masks = LightMasks::new();
            smoke = Smoke::new(&device, &shadows)?; // your buffers and bind groups, loaders, simulations
        }
        Ok(())
    }

    fn compile(F { mut shadows, mut encoder, casters, views, settings, pool, .. }: F<'_>) -> Done {
        use gobo::HostInputs;

        for job in shadows.pending(&casters, &views, &settings, &HostInputs::new())? {
            pool.spawn(move || job.run().unwrap_or_else(|error| eprintln!("{}: {error}", job.name())));
        }
        // Frame after frame:
        if shadows.is_ready() {
            shadows.prepare(&casters, &views, &settings)?.record(&mut encoder)?;
        }                                             // else without shadows, or with those of before
        Ok(())
    }

    fn profiler() {
        use gobo::{host::Profiler, wgpu::{CommandEncoder, ComputePassTimestampWrites}};
        use std::sync::Arc;
        use wgpu_profiler::{GpuProfiler, GpuProfilerQuery};

        #[derive(Debug)]
        struct Scopes { profiler: Arc<GpuProfiler>, open: Option<GpuProfilerQuery> }

        impl Profiler for Scopes {
            fn begin(&mut self, encoder: &mut CommandEncoder, label: &'static str) -> Option<ComputePassTimestampWrites<'_>> {
                self.open = Some(self.profiler.begin_pass_query(label, encoder));
                self.open.as_ref()?.compute_pass_timestamp_writes()
            }
            fn end(&mut self, encoder: &mut CommandEncoder) {
                if let Some(query) = self.open.take() { self.profiler.end_query(encoder, query) }
            }
        }
    }

    fn particles(F { mut shadows, mut encoder, casters, views, settings, layout, bind_group, alive, mut simulation, .. }: F<'_>) -> Done {
        use gobo::{CasterCount, HostCasters, HostInputs};

        let loader = shadows.caster_loader("smoke.wgsl", SMOKE_WGSL, &layout)?; // the text above
        let count = CasterCount::Indirect { buffer: &alive, offset: 0, capacity: 200_000 }; // or Fixed(n)
        let sets = [HostCasters::new(&loader, &bind_group, count, &[0])];
        let inputs = HostInputs::new().casters(&sets);
        let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs)?;
        // Frame after frame, until views or materials change:
        simulation.record(&mut encoder);
        prepared.record(&mut encoder)?;
        Ok(())
    }

    fn splats(F { shadows, layout, bind_group, count, .. }: F<'_>) -> Done {
        use gobo::{CasterCount, HostCasters};

        let loader = shadows.gaussian_loader("splats.wgsl", SPLATS_WGSL, &layout)?; // the text above
        let sets = [HostCasters::new(&loader, &bind_group, CasterCount::Fixed(count), &[0])]; // a material of the shape `Gaussian`
        Ok(())
    }

    fn splat_light(F { prepared, mut encoder, lights, count, positions, place_points, .. }: F<'_>, i: usize) -> Done {
        use gobo::host::PointBuffers;

        let points = PointBuffers { count, positions: &positions, normals: None };
        let lit = prepared.light_points(&lights, &[i], &points)?;                 // one light at a time: its own places
        place_points.record(&mut encoder);
        lit.record(&mut encoder);
        lit.shares();                                                             // rgb, splat by splat; a lone one has 1
        Ok(())
    }

    fn grids(F { mut shadows, mut encoder, casters, views, settings, density, mut simulation, .. }: F<'_>, world_from_index: gobo::glam::Affine3A, extinction: gobo::glam::Vec3) -> Done {
        use gobo::{Grid, HostGrid, HostInputs};

        let grid = Grid { world_from_index, factor: 4.0, extinction, material: 0, ..Grid::default() }; // without bricks
        let grids = [HostGrid::new(&density, &grid)];     // three dimensions, TEXTURE_BINDING; its first channel
        let inputs = HostInputs::new().grids(&grids);
        let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs)?;
        // Frame after frame, until views, materials or the grid's transform change:
        simulation.record(&mut encoder);
        prepared.record(&mut encoder)?;
        Ok(())
    }

    fn depths<'a>(sun_depth: wgpu::Texture, spot_depth: wgpu::Texture, spot_clip_from_world: [[f32; 4]; 4], sets: &'a [gobo::HostCasters<'a>]) {
        use gobo::{HostDepth, HostInputs};

        let depths = [
            HostDepth::new(0, &sun_depth).layer(2),       // rendered with views[0].clip_from_world()
            HostDepth::new(3, &spot_depth)
                .clip_from_world(spot_clip_from_world)    // your own: [[f32; 4]; 4], columns
                .instead(),
        ];
        let inputs = HostInputs::new().casters(&sets).depths(&depths);
    }

    fn converted(F { prepared, mut encoder, .. }: F<'_>, clip_from_world: Vec<[[f32; 4]; 4]>) -> Done {
        use gobo::host::{FilterFormat, MapLayout};

        let layout = MapLayout::new(FilterFormat::Rgba16Float).depth_in_alpha(&clip_from_world); // of each view
        let converted = prepared.converted(&layout)?;
        prepared.record(&mut encoder)?;
        converted.record(&mut encoder);   // converted.texture(), an array
        Ok(())
    }

    fn shader(F { prepared, lights, mut pass, .. }: F<'_>) -> Done {
        let text = prepared.maps().wgsl(2, "gobo_")? + FORWARD_WGSL;
        let bound = prepared.bind_lights(&lights, &[0, 1, 2])?; // bound.layout, bound.group
        pass.set_bind_group(2, &bound.group, &[]);
        Ok(())
    }

    fn masks(F { prepared, mut encoder, lights, .. }: F<'_>, clip_from_world: [[f32; 4]; 4], depth: wgpu::Texture, normals: wgpu::Texture) -> Done {
        use gobo::{host::{LightMasks, MaskView}, model::MaskSettings};

        let mut masks = LightMasks::new();                       // once: it keeps its textures
        // Frame after frame:
        let view = MaskView::new(clip_from_world, &depth)        // columns, reversed or infinite as it is
            .normals(&normals);                                  // world space; view_normals, or none
        let settings = MaskSettings { half: true, taps: 11, ..Default::default() };
        masks.prepare(&prepared, &lights, &[0, 1, 2], &view, &settings)?;
        masks.record(&mut encoder);                              // after the maps and your depth pass
        masks.texture();                                         // rgba8unorm, an array, of your depths' size
        masks.slots();                                           // of each chosen light: its layer and channel
        Ok(())
    }

    fn joined<'a>(F { shadows, layout, .. }: F<'_>, view: gobo::host::MaskView<'a>, bind_group: &'a wgpu::BindGroup) -> Done {
        let sky = shadows.shadow_function("sky.wgsl", SKY_WGSL, &layout)?; // once
        let view = view.joined(&sky, &bind_group, &[0]);         // lights, as their indices
        Ok(())
    }

    fn points(F { prepared, mut encoder, lights, count, positions, .. }: F<'_>) -> Done {
        use gobo::host::PointBuffers;

        let points = PointBuffers { count, positions: &positions, normals: None }; // three f32 a vector
        let lit = prepared.light_points(&lights, &[0, 1], &points)?;
        lit.record(&mut encoder);   // after the maps
        lit.shares();               // rgb, point by point, chosen light by chosen light
        Ok(())
    }
}

/// Lines without their indentation.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).collect()
}

/// Rust in the document that is missing in this file.
fn missing(document: &str) -> Vec<String> {
    let compiled = lines(include_str!("embedding.rs"));
    let blocks = document.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next());
    let is_compiled =
        |block: &&str| compiled.windows(block.lines().count()).any(|part| part == lines(block));
    blocks.filter(|block| !is_compiled(block)).map(str::to_owned).collect()
}

#[test]
fn the_code_of_embedding_compiles() {
    let document = include_str!("../../docs/embedding.md");
    assert_eq!(missing(document), [""; 0]);
    assert!(document.matches("```rust\n").count() > 15);
    assert_eq!(missing(&document.replace("light_views", "views_of_light")).len(), 1);
}
