//! The picture: the camera is one more view, whose lists are shaded instead of summed.
mod parts;
mod read;
mod request;

pub use request::{Kept, PictureCapacity, PictureRequest};

use super::{
    band_memory::BandMemory,
    bands::{TileRect, band_tiles},
    clusters::Clusters,
    finish::{Finish, ToFinish},
    first_light::{WHOLE_PICTURES, around},
    lighting::Lighting,
    lists::CameraList,
    shading::{ShadeFeatures, Shading, ToShade},
};
use glam::{UVec2, Vec2};
use gobo::{
    Error,
    frame::Commands,
    gpu::{Allocator, Memory, Timeline, array_view},
    model::Class,
    records::GpuView,
    shadows::{
        Shadows,
        batch::{batch_plan::BatchPlan, context::view_uniform},
    },
    stage::{bin::BatchCounters, features::Flags},
};
use parts::Parts;
use std::sync::Arc;
use wgpu::{
    Buffer, BufferUsages, Texture, TextureFormat, TextureUsages, TextureView,
    TextureViewDescriptor, TextureViewDimension,
};

/// A picture, ready to be recorded after the maps that light it.
#[derive(Debug)]
pub struct PreparedPicture {
    /// Kernels from casters to the pairs of both lists, or to footprints if the picture is drawn in parts.
    listing: Commands,
    /// Kernels from footprints to the pair counts of the picture's parts.
    counting: Commands,
    /// All other kernels.
    drawing: Commands,
    capacity: PictureCapacity,
    clusters: Clusters,
    lighting: Lighting,
    targets: Targets,
    size: UVec2,
    /// Particles of the translucent list.
    lit_count: u32,
    /// Pairs that each list has room for.
    pair_capacity: u32,
    #[expect(dead_code, reason = "as long as it is here, no other picture takes it")]
    band: Arc<BandMemory>,
    tile_count: u32,
    /// View in which its casters are listed.
    around: GpuView,
    /// [`FirstLight::offsets`](super::FirstLight).
    offsets: Vec<Vec2>,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

/// Textures and buffers of a picture that are read back.
#[derive(Debug)]
pub(super) struct Targets {
    radiance: Texture,
    /// Light of the particles.
    pub(super) lit: Texture,
    /// Light of the lattices of all bricks.
    pub(super) brick_lights: Texture,
    /// Whether the light of particles and bricks is that of another picture.
    pub(super) is_lit: bool,
    /// Light of surfaces for pictures through further samples, or from the first.
    pub(super) first_surfaces: Option<Texture>,
    /// Its layer of this picture, unless that takes light over.
    pub(super) kept_layer: Option<u32>,
    pixels: Buffer,
    /// Counters of the lists, part by part.
    counters: Buffer,
}

impl Targets {
    /// The radiance is that of the bands, before the passes over the whole picture.
    fn new(
        allocator: &mut Allocator<'_>,
        size: UVec2,
        lit_count: u32,
        lattice_points: u32,
        part_count: usize,
        kept: &Kept,
    ) -> Result<Self, Error> {
        let read = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let (float, copied) = (TextureFormat::Rgba32Float, BufferUsages::COPY_SRC);
        let extent = [u64::from(size.x), u64::from(size.y), 1];
        let radiance = allocator.texture("radiance", float, extent, read)?;
        let mut records = |name, count: u32| allocator.records(name, float, count.into(), read);
        let taken = kept.first_light.as_ref();
        let (lit, brick_lights) = match taken {
            Some(taken) => (taken.particles.clone(), taken.bricks.clone()),
            None => (records("lit_casters", lit_count)?, records("brick_lights", lattice_points)?),
        };
        let pixel_count = u64::from(size.element_product());
        let pixels = allocator.storage::<u32>("pixels", pixel_count, copied)?;
        let parts = part_count as u64;
        let counters =
            allocator.storage::<[BatchCounters; 2]>("picture_counters", parts, copied)?;
        let is_lit = taken.is_some();
        let first_surfaces = match taken {
            Some(taken) => taken.surfaces.clone(),
            None if kept.is_first => {
                let (name, format) = ("first_surfaces", TextureFormat::Rgba32Uint);
                let extent = [extent[0], extent[1], WHOLE_PICTURES.into()];
                Some(allocator.texture(name, format, extent, TextureUsages::STORAGE_BINDING)?)
            }
            None => None,
        };
        let layer = taken.map_or(0, |taken| taken.offsets.len() as u32);
        let keeps = first_surfaces.is_some() && layer < WHOLE_PICTURES;
        let kept_layer = keeps.then_some(layer);
        Ok(Self {
            radiance,
            lit,
            brick_lights,
            is_lit,
            first_surfaces,
            kept_layer,
            pixels,
            counters,
        })
    }

    /// The layer that is kept, or all that light is taken over from.
    fn surfaces_view(&self) -> Option<TextureView> {
        let surfaces = self.first_surfaces.as_ref()?;
        let layer = |layer| TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        };
        let kept = self.kept_layer.map(|kept| surfaces.create_view(&layer(kept)));
        Some(kept.unwrap_or_else(|| array_view(surfaces)))
    }
}

impl PreparedPicture {
    /// Prepares a picture, and takes over the parts of `kept` that still fit.
    ///
    /// # Errors
    /// If a later frame has taken the maps over, or the device has no room.
    pub fn new(
        shadows: &Shadows,
        request: &PictureRequest<'_>,
        kept: &mut Kept,
    ) -> Result<Self, Error> {
        let prepared = Self::uncompiled(shadows, request, kept)?;
        shadows.kernels().finish()?;
        Ok(prepared)
    }

    /// Like [`Self::new`], except that kernels may not be compiled yet.
    pub(crate) fn uncompiled(
        shadows: &Shadows,
        request: &PictureRequest<'_>,
        kept: &mut Kept,
    ) -> Result<Self, Error> {
        let &PictureRequest { scene, camera, prepared, capacity } = request;
        prepared.check_current()?;
        let (queue, kernels) = (shadows.queue(), shadows.kernels());
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(kernels.device(), &mut memory);
        let (size, tiles) = (camera.size, camera.tiles());
        let rects = TileRect { origin: UVec2::ZERO, size: tiles }.parts(capacity.parts);
        let views = view_uniform(&mut allocator, &[camera.to_gpu(0, UVec2::ZERO, 0)]);
        let first = kept.first_light.clone();
        let own = || around(camera, scene.samples);
        let around = first.as_ref().map_or_else(own, |first| first.around);
        let lists = camera_lists(shadows, &mut allocator, request, &around, &views, &rects)?;
        let lit_count = lists[1].first_setup;
        let records = request.light_records();
        let lattice_points = shadows.casters()?.bricks().lattice_points;
        let clusters = Clusters::new(&mut allocator, queue, kernels, scene, camera, &records)?;
        let mut offsets = first.map_or(Vec::new(), |first| first.offsets);
        let offset = camera.shear();
        if offsets.len() < WHOLE_PICTURES as usize {
            offsets.push(offset);
        }
        let from_first = [offset - offsets[0], offsets[offsets.len() - 1] - offsets[0]];
        let setup_origin = lists[1].setup_origin;
        let params = request.params(&records, &clusters.grid, setup_origin, from_first);
        let params = allocator.uniform("picture_params", &params);
        let mut targets =
            Targets::new(&mut allocator, size, lit_count, lattice_points, rects.len(), kept)?;
        let band = band_memory(&mut allocator, request, kept, &lists[1])?;
        let surfaces = targets.surfaces_view();
        // With all their levels; maps read only the first.
        let images = array_view(&shadows.casters()?.images);
        let resources = shadows
            .casters()?
            .resources()
            .with("images", &images)
            .and(&prepared.maps().look_up_resources())
            .and(&band.resources)
            .with("views", &views)
            .with("picture_params", &params)
            .with("lights", &clusters.lights)
            .with("clusters", &clusters.lists)
            .with_any("first_surfaces", surfaces.as_ref())
            .with("radiance", &targets.radiance)
            .with("pixels", &targets.pixels);
        let bands: Vec<_> = rects.iter().flat_map(|part| part.bands(band.tiles)).collect();
        let shared = resources.clone();
        let lighting =
            Lighting::new(&mut allocator, shadows, request, kept, &records, shared, &bands)?;
        let cost = shadows.config().toggles.count_cost;
        let whole = resources.clone();
        let to = ToFinish { allocator: &mut allocator, kernels, resources: &whole };
        let finish = Finish::new(to, scene, cost, &targets.radiance)?;
        let shading = Shading::new(
            ToShade {
                allocator: &mut allocator,
                shadows,
                materials: &scene.materials,
                features: ShadeFeatures::new(&lists, &lighting, &finish, cost, scene)
                    .sharing(&targets),
                lists: &lists,
                rounds: capacity.rounds,
                memory: &band,
                targets: &targets,
                air: lighting.air.as_ref(),
            },
            &rects,
            &finish.with(resources).and(&lighting.resources),
        )?;
        let counters = &targets.counters;
        let parts = Parts { lists: &lists, shading: &shading, counters, count: rects.len() };
        let mut drawing = clusters.commands.clone();
        lighting.air.iter().for_each(|air| drawing.append(air.clear()));
        drawing.append(parts.drawing(&lighting.masking));
        drawing.append(finish.commands);
        let (listing, counting) = (parts.listing(), parts.counting());
        targets.radiance = finish.radiance;
        let capacities = lists.iter().map(|list| list.scratch.pair_capacity);
        Ok(Self {
            listing,
            counting,
            drawing,
            capacity,
            clusters,
            lighting,
            targets,
            size,
            lit_count,
            pair_capacity: capacities.min().unwrap_or(0),
            band,
            tile_count: tiles.element_product(),
            around,
            offsets,
            memory,
        })
    }
}

/// The camera's opaque and blended casters.
fn camera_lists(
    shadows: &Shadows,
    allocator: &mut Allocator<'_>,
    request: &PictureRequest<'_>,
    around: &GpuView,
    views: &Buffer,
    parts: &[TileRect],
) -> Result<[CameraList; 2], Error> {
    let &PictureRequest { camera, capacity, .. } = request;
    let (view, tile_count) = (camera.to_gpu(0, UVec2::ZERO, 0), camera.tiles().element_product());
    let mut list = |classes| {
        let plan = BatchPlan::of_camera(view, around, tile_count, shadows.casters()?, &classes);
        CameraList::new(allocator, shadows, &plan, views, capacity.pairs, parts)
    };
    Ok([list(Class::SOLID)?, list(Class::BLENDED)?])
}

/// Memory of a band: the previous picture's if it suffices.
fn band_memory(
    allocator: &mut Allocator<'_>,
    request: &PictureRequest<'_>,
    kept: &mut Kept,
    blended: &CameraList,
) -> Result<Arc<BandMemory>, Error> {
    let &PictureRequest { scene, camera, capacity: PictureCapacity { parts, rounds, .. }, .. } =
        request;
    let at_once = parts == 1 && rounds == 1;
    let tiles = band_tiles(camera.tiles(), scene.mask.is_some(), at_once);
    let has_layers = blended.list.footprint_count > 0;
    let panes = has_layers && blended.features.has(Flags::HAS_TRIANGLES);
    let device = allocator.device;
    let band = BandMemory::take(&mut kept.band, device, rounds, tiles, has_layers, panes)?;
    allocator.memory.add_all(&band.memory);
    Ok(band)
}

impl PreparedPicture {
    /// Records the picture; the maps must have been recorded before.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        self.listing.record(encoder, timeline);
        self.record_counted(encoder, timeline);
    }

    /// Records only the counting for [`Self::needs`].
    pub fn record_counts(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        self.listing.record(encoder, timeline);
        self.counting.record(encoder, timeline);
    }

    /// Records the rest of [`Self::record`], after [`Self::record_counts`].
    pub fn record_counted(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        self.lighting.levels.iter().for_each(|levels| levels.record(encoder, timeline));
        self.drawing.record(encoder, timeline);
    }
}
