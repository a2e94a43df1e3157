//! The picture: the camera is one more view, whose lists are shaded instead of summed.
mod read;
mod request;

pub use request::{Kept, PictureCapacity, PictureRequest};

use super::{
    air::PreparedAir,
    band_memory::BandMemory,
    bands::{TileRect, band_tiles},
    clusters::Clusters,
    environment::environment_texture,
    lists::CameraList,
    shading::{ShadeFeatures, Shading, ToShade},
};
use crate::{
    error::Error,
    frame::Kernels,
    gpu::{Allocator, Memory, Timeline},
    model::Class,
    records::{LightRecords, MaskSlots},
    shadows::{
        AreaLevels, Pipeline,
        context::view_uniform,
        masks::{MaskMemory, MaskTextures, PreparedMasks},
        plan::Plan,
    },
    stage::{bin::BatchCounters, features::Features, shade::PictureParams},
};
use glam::UVec2;
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages, Texture, TextureFormat, TextureUsages};

/// A picture, bound and ready to be recorded after the maps that light it.
#[derive(Debug)]
pub struct PreparedPicture {
    kernels: Kernels,
    capacity: PictureCapacity,
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
    blended: CameraList,
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

impl Pipeline {
    /// Prepares a picture, with what it can take over from `kept`.
    pub fn prepare_picture(
        &mut self,
        request: &PictureRequest<'_>,
        kept: &mut Kept,
    ) -> Result<PreparedPicture, Error> {
        let planned = self.plan_picture(request, kept)?;
        self.kernels.finish()?;
        Ok(planned)
    }

    /// Like [`Self::prepare_picture`], except that kernels may not be compiled yet.
    pub(crate) fn plan_picture(
        &mut self,
        request: &PictureRequest<'_>,
        kept: &mut Kept,
    ) -> Result<PreparedPicture, Error> {
        let &PictureRequest { device, queue, casters, scene, camera, views, maps, capacity } =
            request;
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let tiles = camera.tiles();
        let view = camera.to_gpu(0, UVec2::ZERO, 0);
        let camera_views = view_uniform(&mut allocator, queue, &[view]);
        let parts = TileRect { origin: UVec2::ZERO, size: tiles }.parts(capacity.parts);
        let Self { config, kernels, environment, .. } = self;
        let config = *config;
        let list = |allocator: &mut Allocator<'_>, classes| {
            let plan = Plan::of_camera(view, tiles.element_product(), casters, &classes);
            let (views, pairs) = (&camera_views, capacity.pairs);
            CameraList::new(
                allocator, queue, kernels, &config, casters, &plan, views, pairs, &parts,
            )
        };
        let solid = list(&mut allocator, Class::SOLID)?;
        let blended = list(&mut allocator, Class::BLENDED)?;

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
            first_setup: blended.first_setup,
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
        let lit_count = u64::from(blended.first_setup);
        let lit_texture = allocator.records("lit_casters", float, lit_count, read)?;
        let pixel_count = u64::from(camera.size.element_product());
        let pixels = allocator.storage::<u32>("pixels", pixel_count, BufferUsages::COPY_SRC)?;
        let counters = allocator.storage::<[BatchCounters; 2]>(
            "picture_counters",
            parts.len() as u64,
            BufferUsages::COPY_SRC,
        )?;
        let at_once = parts.len() == 1 && capacity.rounds == 1;
        let tiles_of_band = band_tiles(tiles, scene.mask.is_some(), at_once);
        let has_layers = blended.list.footprint_count > 0;
        let panes = has_layers && blended.features.triangles;
        let memory_of_band = BandMemory::take(
            &mut kept.band,
            device,
            capacity.rounds,
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
        let levels =
            AreaLevels::new(&mut allocator, queue, kernels, &records, &resources, of_maps)?;
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
                let make = |variant, features| Ok((kernels.of(variant, features)?, None));
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
                &blended,
                of_maps,
                of_surfaces,
                unmasked,
                config.count_cost,
                scene,
            ),
            solid: &solid,
            blended: &blended,
            rounds: capacity.rounds,
            memory: &memory_of_band,
            lit_casters: &lit_texture,
        };
        let resources = resources.with("air", &air_volume).with("environment", &environment);
        let shading = Shading::new(to_shade, &parts, &resources)?;
        Ok(PreparedPicture {
            kernels: kernels.clone(),
            capacity,
            clusters,
            levels,
            masks,
            slots,
            radiance,
            lit_texture,
            size: camera.size,
            solid,
            blended,
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
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        let kernels = &self.kernels;
        self.clusters.record(kernels, encoder, timeline);
        if let Some(levels) = &self.levels {
            levels.commands.record(encoder, timeline);
        }
        if let Some(air) = &self.air {
            air.record(kernels, encoder, timeline);
        }
        for list in [&self.solid, &self.blended] {
            list.record_footprints(encoder, timeline);
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
    pub fn record_counts(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        for list in [&self.solid, &self.blended] {
            list.record_footprints(encoder, timeline);
        }
        for part in 0..self.part_count {
            self.record_pairs(part, &self.kernels, encoder, timeline);
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
        for (i, list) in (0..).zip([&self.solid, &self.blended]) {
            list.record_pairs(part, kernels, encoder, timeline);
            let at = (2 * part as u64 + i) * SIZE;
            encoder.copy_buffer_to_buffer(list.list.counters.buffer(), 0, &self.counters, at, SIZE);
        }
    }
}
