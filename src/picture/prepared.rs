//! The picture: the camera is one more view, whose lists are shaded instead of summed.
use super::{air::PreparedAir, clusters::Clusters};
use crate::{
    error::Error,
    gpu::{Allocator, Gpu, Memory, Timeline},
    model::Scene,
    model::{TILE_SIZE, View},
    records::Picture,
    shadows::{
        CasterSet, Maps, Pipeline,
        context::{Context, view_uniform},
        kernels::{Kernels, Variant},
        list::{List, ListCounters},
        plan::Plan,
        scratch::{Scratch, partial_count},
    },
    stage::{
        bin::{Dispatch, SEGMENT_LENGTH, tile_grid},
        cluster::{ClusterCounters, Grid},
        hits::Features,
        shade::{CASTER_LANES, PictureParams},
    },
};
use glam::UVec2;
use half::f16;
use std::sync::Arc;

/// Words of a pixel whose linear light is kept.
const LINEAR_WORDS: u32 = 3;
use wgpu::{BindGroup, Buffer, BufferUsages, Texture, TextureFormat, TextureUsages};

/// A picture, bound and ready to be recorded after the maps it is lit through.
#[derive(Debug)]
pub struct PreparedPicture {
    scratch: Arc<Scratch>,
    clusters: Clusters,
    surface_texture: Texture,
    lit_texture: Texture,
    size: UVec2,
    tile_count: u32,
    solid: List,
    clear: List,
    solid_features: Features,
    clear_features: Features,
    seen: BindGroup,
    surfaces: BindGroup,
    casters: BindGroup,
    layers: BindGroup,
    composite: BindGroup,
    clear_count: u32,
    pixels: Buffer,
    air: Option<PreparedAir>,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

impl Pipeline {
    /// `views` and `maps`: the shadow views of the scene's lights. `pairs` as in
    /// [`Pipeline::prepare`].
    #[expect(clippy::too_many_arguments, reason = "each is another owner's")]
    pub fn prepare_picture(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        scene: &Scene,
        views: &[View],
        maps: &Maps,
        pairs: Option<u32>,
    ) -> Result<PreparedPicture, Error> {
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let camera = View::from_camera(&scene.camera, &scene.bounds());
        let tile_count = camera.tiles().element_product();
        let plan = Plan::of_camera(camera.to_gpu(0, UVec2::ZERO, 0), tile_count, casters);
        let plans = std::slice::from_ref(&plan);
        let scratch = Arc::new(Scratch::new(&mut allocator, queue, &self.config, plans, pairs, 0)?);
        let mut context = Context {
            allocator: &mut allocator,
            queue,
            kernels: &mut self.kernels,
            config: &self.config,
            casters,
            scratch: &scratch,
            camera: true,
        };
        let camera_views = view_uniform(context.allocator, queue, &plan.views);
        let [solid_plan, clear_plan] = &plan.lists;
        let solid = List::new(&mut context, solid_plan, &camera_views, 1, tile_count)?;
        let clear = List::new(&mut context, clear_plan, &camera_views, 1, tile_count)?;

        let shadow_views: Vec<_> = views
            .iter()
            .zip(&maps.places)
            .map(|(view, place)| view.to_gpu(0, place.origin, place.layer))
            .collect();
        let clusters = Clusters::new(&mut context, scene, &camera, views, &shadow_views)?;
        let grid = &clusters.grid;
        let keeps_light = self.config.linear && !self.config.count_cost;
        let pixel_words = if keeps_light { LINEAR_WORDS } else { 1 };
        let params = context.uniform(
            "picture_params",
            &PictureParams {
                world_from_view: camera.view_from_world.inverse(),
                ambient: scene.ambient,
                light_count: scene.lights.len() as u32,
                background: scene.background,
                footprint_count: clear_plan.footprint_count,
                bias: scene.shadow.bias,
                normal_bias: scene.shadow.normal_bias,
                near: grid.near,
                depth_range: grid.depth_range,
                cells: grid.cells,
                tile: grid.tile,
                first_slice: grid.first_slice,
                slices_per_doubling: grid.slices_per_doubling,
                colored: u32::from(maps.colored.is_some()),
                air_slices: scene.air.map_or(0, |air| air.steps),
                exposure: scene.exposure.exp2(),
                pixel_words,
                pad_0: 0,
                pad_1: 0,
            },
        );
        let padded = (camera.tiles() * TILE_SIZE).as_u64vec2();
        let size = [padded.x, padded.y, 1];
        let storage = TextureUsages::STORAGE_BINDING;
        let read = storage | TextureUsages::COPY_SRC;
        let surfaces =
            context.allocator.texture("surfaces", TextureFormat::Rgba32Float, size, read)?;
        let lit_count = u64::from(clear_plan.footprint_count);
        let lit = context.allocator.records("lit", TextureFormat::Rgba16Float, lit_count, read)?;
        let pixel_count = u64::from(camera.size.element_product()) * u64::from(pixel_words);
        let pixels =
            context.allocator.storage::<u32>("pixels", pixel_count, BufferUsages::COPY_SRC)?;

        let segments = partial_count(scratch.pair_capacity, SEGMENT_LENGTH);
        let texels = segments * u64::from(TILE_SIZE * TILE_SIZE);
        let none = BufferUsages::empty();
        let partials = context.allocator.storage::<[u32; 4]>("partials", texels, none)?;

        let cost = self.config.count_cost;
        // Of the maps that light comes through.
        let (nodes, gain) = (maps.nodes, maps.gain);
        let [solid_features, clear_features] =
            [solid_plan, clear_plan].map(|plan| Features { cost, nodes, gain, ..plan.features });
        let blocking = maps.colored.as_ref().unwrap_or(&maps.opaques);
        let resources = casters
            .resources()
            .and(&scratch.resources())
            .and(&maps.resources())
            .with("opaques", blocking)
            .with("views", &camera_views)
            .with("picture_params", &params)
            .with("partials", &partials)
            .with("lights", &clusters.lights)
            .with("clusters", &clusters.lists)
            .with("surfaces", &surfaces)
            .with("lit", &lit)
            .with("pixels", &pixels);
        let kernels = context.kernels;
        let (air_volume, air) =
            PreparedAir::new(context.allocator, queue, kernels, clear_features, scene, &resources)?;
        let resources = resources.with("air", &air_volume);
        let of_solid = resources.clone().with("pairs", &scratch.pairs[solid.sorted_pairs]);
        let of_clear = resources.with("pairs", &scratch.pairs[clear.sorted_pairs]);
        let mut bind_solid =
            |variant| kernels.make(device, variant, solid_features)?.bind(device, &of_solid);
        let seen = bind_solid(Variant::ShadeSeen)?;
        let surface_bindings = bind_solid(Variant::ShadeSurfaces)?;
        let mut bind_clear =
            |variant| kernels.make(device, variant, clear_features)?.bind(device, &of_clear);
        let lit_casters = bind_clear(Variant::ShadeCasters)?;
        let layers = bind_clear(Variant::ShadeLayers)?;
        let composite = bind_clear(Variant::ShadeComposite)?;
        Ok(PreparedPicture {
            scratch,
            clusters,
            surface_texture: surfaces,
            lit_texture: lit,
            size: camera.size,
            tile_count,
            solid,
            clear,
            solid_features,
            clear_features,
            seen,
            surfaces: surface_bindings,
            casters: lit_casters,
            layers,
            composite,
            clear_count: clear_plan.footprint_count,
            pixels,
            air,
            memory,
        })
    }
}

impl PreparedPicture {
    /// Records the picture; the maps must have been recorded before.
    pub fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        self.clusters.record(kernels, encoder, timeline);
        let tiles = tile_grid(self.tile_count);
        let dispatches = &self.scratch.dispatches;
        let segments = Dispatch::Segment.offset();
        let solid = |variant| kernels.get(variant, self.solid_features);
        let clear = |variant| kernels.get(variant, self.clear_features);
        if let Some(air) = &self.air {
            air.record(kernels, encoder, timeline);
        }
        self.record_list(&self.solid, kernels, encoder, timeline);
        let mut pass = timeline.pass(encoder, "shade");
        let seen = solid(Variant::ShadeSeen);
        seen.record_indirect(&mut pass, &self.seen, dispatches, segments);
        solid(Variant::ShadeSurfaces).record(&mut pass, &self.surfaces, tiles);
        drop(pass);
        self.record_list(&self.clear, kernels, encoder, timeline);
        let mut pass = timeline.pass(encoder, "shade");
        if self.clear_count > 0 {
            const ROW: u32 = 32768;
            let groups = self.clear_count.div_ceil(CASTER_LANES);
            let grid = [groups.min(ROW), groups.div_ceil(ROW), 1];
            clear(Variant::ShadeCasters).record(&mut pass, &self.casters, grid);
        }
        let layers = clear(Variant::ShadeLayers);
        layers.record_indirect(&mut pass, &self.layers, dispatches, segments);
        clear(Variant::ShadeComposite).record(&mut pass, &self.composite, tiles);
    }

    fn record_list(
        &self,
        list: &List,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        self.scratch.clear(list, encoder);
        list.record_project(kernels, encoder, timeline);
        list.record_emit(kernels, encoder, timeline);
        list.record_tiles(kernels, encoder, timeline);
    }

    /// Pairs that a list has room for; what is past it is missing from the picture.
    pub fn pair_capacity(&self) -> u32 {
        self.scratch.pair_capacity
    }

    /// Of what is solid and of what is not; blocks.
    pub fn read_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<[ListCounters; 2], Error> {
        Ok([self.solid.read_counters(device, queue)?, self.clear.read_counters(device, queue)?])
    }

    /// Blocks.
    pub fn read_cluster_counters(&self, gpu: &Gpu) -> Result<ClusterCounters, Error> {
        self.clusters.read_counters(gpu)
    }

    /// How the frustum is cut.
    pub fn grid(&self) -> &Grid {
        &self.clusters.grid
    }

    /// The lights of each cluster, ascending; `None` where all lights are asked. Blocks.
    pub fn read_clusters(&self, gpu: &Gpu) -> Result<Vec<Option<Vec<u32>>>, Error> {
        self.clusters.read(gpu)
    }

    /// What the camera sees that is solid, row by row: linear light and light depth, 1 for the sky.
    /// Blocks.
    pub fn read_surfaces(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, Error> {
        let texels: Vec<[f32; 4]> = gpu.try_read_texture(&self.surface_texture)?;
        let width = self.surface_texture.width() as usize;
        let rows = texels.chunks_exact(width).take(self.size.y as usize);
        Ok(rows.flat_map(|row| &row[..self.size.x as usize]).copied().collect())
    }

    /// The light that reaches each particle that is seen and not solid: fp16 bits. Blocks.
    pub fn read_lit(&self, gpu: &Gpu) -> Result<Vec<[u16; 4]>, Error> {
        let mut texels: Vec<[u16; 4]> = gpu.try_read_texture(&self.lit_texture)?;
        texels.truncate(self.clear_count as usize);
        Ok(texels)
    }

    /// Of each pixel, where [`crate::shadows::Config::count_cost`] asked for it: pairs that were walked, and
    /// lights that were asked, both up to 65,535. Blocks.
    pub fn read_costs(&self, gpu: &Gpu) -> Result<Vec<[u16; 2]>, Error> {
        gpu.try_read(&self.pixels)
    }

    /// Blocks.
    pub fn read(&self, gpu: &Gpu) -> Result<Picture, Error> {
        let words: Vec<[u16; 2]> = gpu.try_read(&self.pixels)?;
        let count = self.size.element_product() as usize;
        let pixels = words.chunks_exact(words.len() / count.max(1));
        let shown = |&[low, high]: &[u16; 2]| {
            let ([r, g], [b, _]) = (low.to_le_bytes(), high.to_le_bytes());
            [r, g, b]
        };
        let rgb = pixels.clone().map(|pixel| shown(&pixel[0])).collect();
        let linear = |pixel: &[[u16; 2]]| match *pixel {
            [_, [r, g], [b, _]] => Some([r, g, b].map(|bits| f16::from_bits(bits).to_f32())),
            _ => None,
        };
        Ok(Picture { size: self.size, rgb, light: pixels.filter_map(linear).collect() })
    }
}
