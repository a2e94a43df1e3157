//! The picture: the camera is one more view, whose lists are shaded instead of summed.
mod read;

use super::{
    air::PreparedAir,
    bands::{TileRect, band_tiles},
    clusters::Clusters,
    environment::environment_texture,
    lists::CameraList,
    shading::{BandMemory, ShadeFeatures, Shading, ToShade},
};
use crate::{
    error::Error,
    gpu::{Allocator, Gpu, Memory, Timeline},
    model::{Class, Scene, View},
    records::{FormerSlots, LightRecords, MaskSlots},
    shadows::{
        AreaLevels, CasterSet, Maps, Pipeline,
        context::view_uniform,
        kernels::Kernels,
        list::ListCounters,
        masks::{MaskMemory, MaskTextures, PreparedMasks},
        plan::Plan,
    },
    stage::{bin::BatchCounters, hits::Features, shade::PictureParams},
};
use glam::UVec2;
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages, Texture, TextureFormat, TextureUsages};

/// State that a picture takes over from the previous one.
#[derive(Debug, Default)]
pub struct Kept {
    /// Mask slots of the lights.
    pub slots: FormerSlots,
    masks: Option<Arc<MaskTextures>>,
    band: Option<Arc<BandMemory>>,
}

/// A picture, bound and ready to be recorded after the maps that light it.
#[derive(Debug)]
pub struct PreparedPicture {
    room: PictureRoom,
    clusters: Clusters,
    /// Levels of area lights, if there are any.
    levels: Option<AreaLevels>,
    /// Masks, if lights have any.
    masks: Option<(MaskMemory, PreparedMasks)>,
    /// Mask slots; unmasked lights are counted there.
    slots: MaskSlots,
    radiance: Texture,
    lit_texture: Texture,
    size: UVec2,
    solid: CameraList,
    clear: CameraList,
    shading: Shading,
    #[expect(dead_code, reason = "as long as it is here, no other picture takes it")]
    band: Arc<BandMemory>,
    part_count: usize,
    tile_count: u32,
    /// Counters of the lists, part by part.
    counters: Buffer,
    pixels: Buffer,
    air: Option<PreparedAir>,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

/// Capacities that a picture is prepared with. The default suffices for most; [`PreparedPicture::needs`]
/// returns what a recorded picture needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureRoom {
    /// Pair capacity, within the budget.
    pairs: Option<u32>,
    /// Parts of the picture that are binned one after another, if not all pairs fit.
    parts: u32,
    /// Rounds in which the pairs of the longest tile are walked.
    rounds: u32,
}

impl Default for PictureRoom {
    fn default() -> Self {
        Self { pairs: None, parts: 1, rounds: 1 }
    }
}

impl PictureRoom {
    /// Whether the pairs do not fit at once.
    pub fn is_in_parts(&self) -> bool {
        self.parts > 1
    }
}

impl Pipeline {
    /// `camera`: of the scene, through a sample position of its pixels; `views` and `maps`: the shadow
    /// views of the scene's lights.
    #[expect(clippy::too_many_arguments, reason = "each is another owner's")]
    pub fn prepare_picture(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        scene: &Scene,
        camera: &View,
        views: &[View],
        maps: &Maps,
        room: PictureRoom,
        kept: &mut Kept,
    ) -> Result<PreparedPicture, Error> {
        let planned =
            self.plan_picture(device, queue, casters, scene, camera, views, maps, room, kept)?;
        self.kernels.finish()?;
        Ok(planned)
    }

    /// Like [`Self::prepare_picture`], except that kernels may not be compiled yet.
    #[expect(clippy::too_many_arguments, reason = "each is another owner's")]
    pub(crate) fn plan_picture(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        scene: &Scene,
        camera: &View,
        views: &[View],
        maps: &Maps,
        room: PictureRoom,
        kept: &mut Kept,
    ) -> Result<PreparedPicture, Error> {
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let tiles = camera.tiles();
        let view = camera.to_gpu(0, UVec2::ZERO, 0);
        let camera_views = view_uniform(&mut allocator, queue, &[view]);
        let parts = TileRect { origin: UVec2::ZERO, size: tiles }.parts(room.parts);
        let Self { config, kernels, environment, .. } = self;
        let config = *config;
        let mut list = |allocator: &mut Allocator<'_>, classes| {
            let plan = Plan::of_camera(view, tiles.element_product(), casters, &classes);
            let (views, pairs) = (&camera_views, room.pairs);
            CameraList::new(
                allocator, queue, kernels, &config, casters, &plan, views, pairs, &parts,
            )
        };
        let solid = list(&mut allocator, Class::SOLID)?;
        let clear = list(&mut allocator, Class::BLENDED)?;

        let shadow_views: Vec<_> = views
            .iter()
            .zip(&maps.places)
            .map(|(view, place)| view.to_gpu(0, place.origin, place.layer))
            .collect();
        let records =
            LightRecords::new(scene.lights.iter().enumerate(), views, shadow_views, &scene.shadow);
        let clusters = Clusters::new(&mut allocator, queue, kernels, scene, camera, &records)?;
        let grid = &clusters.grid;
        let params = allocator.uniform::<PictureParams>("picture_params");
        let values = PictureParams {
            world_from_view: camera.view_from_world.inverse(),
            ambient: scene.mean_ambient(),
            light_count: scene.lights.len() as u32,
            background: scene.background,
            first_setup: clear.first_setup,
            near: grid.near,
            depth_range: grid.depth_range,
            cells: grid.cells,
            tile: grid.tile,
            first_slice: grid.first_slice,
            slices_per_doubling: grid.slices_per_doubling,
            colored: u32::from(maps.colored.is_some()),
            air_slices: scene.air.map_or(0, |air| air.steps),
            exposure: scene.exposure.exp2(),
            first_area: records.first_area(),
            extinction: scene.air.map_or(glam::Vec3::ZERO, |air| air.extinction),
            environment_size: scene.environment.as_ref().map_or(0, |sky| sky.size()),
            irradiance: scene.irradiance().map(|c| c.extend(0.0)),
        };
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&values));
        let read = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let size = [u64::from(camera.size.x), u64::from(camera.size.y), 1];
        let float = TextureFormat::Rgba32Float;
        let radiance = allocator.texture("radiance", float, size, read)?;
        let lit_count = u64::from(clear.first_setup);
        let lit_texture = allocator.records("lit_casters", float, lit_count, read)?;
        let pixel_count = u64::from(camera.size.element_product());
        let pixels = allocator.storage::<u32>("pixels", pixel_count, BufferUsages::COPY_SRC)?;
        let counters = allocator.storage::<[BatchCounters; 2]>(
            "picture_counters",
            parts.len() as u64,
            BufferUsages::COPY_SRC,
        )?;
        let at_once = parts.len() == 1 && room.rounds == 1;
        let tiles_of_band = band_tiles(tiles, scene.mask.is_some(), at_once);
        let has_layers = clear.list.footprint_count > 0;
        let panes = has_layers && clear.features.triangles;
        let memory_of_band = BandMemory::take(
            &mut kept.band,
            device,
            room.rounds,
            tiles_of_band,
            has_layers,
            panes,
        )?;
        allocator.memory.add_all(&memory_of_band.memory);
        let blocking = maps.colored.as_ref().unwrap_or(&maps.opaques);
        let resources = casters
            .resources()
            .and(&maps.resources())
            .and(&memory_of_band.resources())
            .with("opaques", blocking)
            .with("views", &camera_views)
            .with("picture_params", &params)
            .with("lights", &clusters.lights)
            .with("clusters", &clusters.lists)
            .with("radiance", &radiance)
            .with("pixels", &pixels);
        // Features of the maps that light comes through.
        let filters = records.is_filtered();
        let of_maps = Features { nodes: maps.nodes, gain: maps.gain, filters, ..Features::NONE };
        let make = |variant, features| Ok(kernels.plan(device, variant, features)?.clone());
        let levels = AreaLevels::new(&mut allocator, queue, &records, &resources, of_maps, make)?;
        let of_maps = Features { areas: levels.is_some(), ..of_maps };
        let resources = match &levels {
            Some(levels) => resources.with("levels", &levels.texture),
            None => resources,
        };
        let (air_volume, air) =
            PreparedAir::new(&mut allocator, queue, kernels, of_maps, scene, &resources)?;
        let slots = scene.mask.as_ref().map(|own| MaskSlots::new(scene, own, camera, &kept.slots));
        let slots = slots.unwrap_or_default();
        let masks = match &scene.mask {
            Some(own) if slots.count > 0 => {
                let size = camera.size;
                let textures = MaskTextures::take(&mut kept.masks, device, size, own.half, &slots)?;
                let memory = MaskMemory::new(queue, own, slots.clone(), textures);
                allocator.memory.add_all(memory.memory());
                let make = |variant, features| {
                    Ok((kernels.plan(device, variant, features)?.clone(), None))
                };
                let passes = PreparedMasks::new(device, queue, of_maps, &memory, &resources, make)?;
                Some((memory, passes))
            }
            _ => None,
        };
        let shadows = !views.is_empty();
        let of_maps = Features { masks: masks.is_some(), shadows, ..of_maps };
        let (of_surfaces, unmasked) = match &masks {
            Some((memory, _)) => (Some(memory.of_surfaces()), memory.slots.unmasked > 0),
            None => (None, shadows),
        };
        let resources = match &masks {
            Some((memory, _)) => resources.and(&memory.resources()),
            None => resources,
        };
        let environment = environment_texture(&mut allocator, queue, scene, environment)?;
        let to_shade = ToShade {
            allocator: &mut allocator,
            queue,
            kernels,
            features: ShadeFeatures::new(
                &solid,
                &clear,
                of_maps,
                of_surfaces,
                unmasked,
                config.count_cost,
                scene,
            ),
            solid: &solid,
            clear: &clear,
            rounds: room.rounds,
            memory: &memory_of_band,
            lit_casters: &lit_texture,
        };
        let resources = resources.with("air", &air_volume).with("environment", &environment);
        let shading = Shading::new(to_shade, &parts, &resources)?;
        Ok(PreparedPicture {
            room,
            clusters,
            levels,
            masks,
            slots,
            radiance,
            lit_texture,
            size: camera.size,
            solid,
            clear,
            shading,
            band: memory_of_band,
            part_count: parts.len(),
            tile_count: tiles.element_product(),
            counters,
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
        if let Some(levels) = &self.levels {
            levels.record(encoder);
        }
        if let Some(air) = &self.air {
            air.record(kernels, encoder, timeline);
        }
        for list in [&self.solid, &self.clear] {
            list.record_footprints(kernels, encoder, timeline);
        }
        self.shading.record_casters(kernels, encoder, timeline);
        if let Some((_, masks)) = &self.masks {
            for part in 0..self.part_count {
                self.record_pairs(part, kernels, encoder, timeline);
                self.shading.record_surfaces(part, kernels, encoder, timeline);
            }
            masks.record(encoder, timeline);
        }
        for part in 0..self.part_count {
            if self.masks.is_none() || self.part_count > 1 {
                self.record_pairs(part, kernels, encoder, timeline);
            }
            self.shading.record_part(part, kernels, encoder, timeline);
        }
    }

    /// Records only the counting for [`Self::needs`].
    pub fn record_counts(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        for list in [&self.solid, &self.clear] {
            list.record_footprints(kernels, encoder, timeline);
        }
        for part in 0..self.part_count {
            self.record_pairs(part, kernels, encoder, timeline);
        }
    }

    fn record_pairs(
        &self,
        part: usize,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        const SIZE: u64 = size_of::<BatchCounters>() as u64;
        for (i, list) in (0..).zip([&self.solid, &self.clear]) {
            list.record_pairs(part, kernels, encoder, timeline);
            let at = (2 * part as u64 + i) * SIZE;
            encoder.copy_buffer_to_buffer(list.list.counters(), 0, &self.counters, at, SIZE);
        }
    }

    /// Counters of the lists, part by part: of opaque, and of translucent casters. Blocks.
    fn read_parts(&self, gpu: &Gpu) -> Result<Vec<[ListCounters; 2]>, Error> {
        gpu.try_read(&self.counters)
    }

    /// Counters of the solid and of the translucent list, summed over the parts. Blocks.
    pub fn read_counters(&self, gpu: &Gpu) -> Result<[ListCounters; 2], Error> {
        let mut sums = [ListCounters::default(); 2];
        for part in self.read_parts(gpu)? {
            sums[0].add(&part[0]);
            sums[1].add(&part[1]);
        }
        Ok(sums)
    }

    /// Capacities with which nothing is missing in the picture; `None` if they suffice already. `budget`:
    /// of pairs. Blocks.
    pub fn needs(&self, gpu: &Gpu, budget: u32) -> Result<Option<PictureRoom>, Error> {
        let parts = self.read_parts(gpu)?;
        let lists = || parts.iter().flatten();
        let mut room = self.room;
        // Rounds of the longest tile; every other tile has two at least.
        let rounds = lists().map(|counted| {
            counted.segment_count.saturating_sub(2 * counted.merged_count.saturating_sub(1))
        });
        room.rounds = rounds.max().unwrap_or(1).max(self.room.rounds);
        let needed = lists().map(|counted| counted.pairs_needed).max().unwrap_or(0);
        let capacity = [&self.solid, &self.clear].map(|list| list.scratch.pair_capacity);
        let capacity = capacity[0].min(capacity[1]);
        if needed > capacity && capacity < budget {
            room.pairs = Some(needed);
        } else if lists().any(|counted| counted.overflowed > 0) {
            let more = needed.div_ceil(capacity.max(1)).max(2);
            room.parts = self.room.parts.saturating_mul(more).min(self.tile_count);
        }
        Ok((room != self.room).then_some(room))
    }
}
