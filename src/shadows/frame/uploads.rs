//! Uploads and conditions of a frame: an example of the inputs that an engine without this library
//! provides.
use super::{Trait, When};
use crate::{
    error::Error,
    gpu::{Allocator, Constant, Memory},
    model::{Casters, View, absorptions},
    records::{CASTER_TEXELS, GpuView},
    shadows::{
        CasterSet, Maps, Pipeline,
        cache::MapCache,
        casters::material_records,
        plan::{self, ListPlan, PendingView, Plan},
        scratch::Scratch,
    },
    stage::{
        formula::{Number, Numbers},
        project::Chunk,
    },
};

/// Uploads of a frame.
#[derive(Debug)]
pub struct Uploads {
    /// Sizes of the atlas, the records, and the textures of materials.
    pub numbers: Numbers,
    pub casters: Vec<u8>,
    pub triangles: Vec<u8>,
    pub materials: Vec<u8>,
    /// Layer by layer, each padded to the largest.
    pub images: Vec<u8>,
    pub batches: Vec<BatchUploads>,
}

/// Uploads of a batch of views.
#[derive(Debug)]
pub struct BatchUploads {
    pub views: Vec<GpuView>,
    /// The blocking list, then the filtering one.
    pub lists: [ListUploads; 2],
}

/// Uploads and properties of a list.
#[derive(Debug)]
pub struct ListUploads {
    pub numbers: Numbers,
    pub conditions: Vec<When>,
    pub traits: Vec<Trait>,
    /// Values of the kernels' overrides.
    pub constants: Vec<Constant>,
    pub particle_chunks: Vec<Chunk>,
    pub triangle_chunks: Vec<Chunk>,
    pub tiny_chunks: Vec<Chunk>,
}

/// Error of a frame that the steps do not cover.
fn beyond(index: usize, problem: &'static str) -> Error {
    Error::Invalid { what: "frame to be exported", index, problem }
}

impl Pipeline {
    /// Uploads of a frame with the casters of `set` and a pair capacity.
    ///
    /// # Errors
    /// If the frame needs steps other than [`STEPS`](super::STEPS), or its maps do not fit.
    pub(in crate::shadows) fn uploads(
        &self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        set: &CasterSet,
        casters: &Casters<'_>,
        views: &[View],
        pairs: Option<u32>,
    ) -> Result<Uploads, Error> {
        let config = &self.config;
        if set.dither_window > 0 && (config.soften || config.colored) {
            return Err(beyond(0, "dithering is softened or coloured, which its steps are not"));
        }
        if config.blur > 0 || config.mips > 0 {
            return Err(beyond(0, "its maps are blurred or have smaller levels"));
        }
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let maps = Maps::new(&mut allocator, queue, views, config.nodes, false, false, 0)?;
        let hides = config.hide.then_some(config.nodes);
        let cache = MapCache::after(MapCache::default(), set, views, hides, &[]);
        let pending = |&index: &usize| PendingView {
            view: &views[index],
            place: maps.places[index],
            groups: cache.groups(index),
            depth: None,
        };
        let pending: Vec<_> = cache.pending.iter().map(pending).collect();
        let plans = plan::batches(&pending, set, config, false)?;
        if let Some(index) = plans.iter().position(|plan| !plan.small_chunks.is_empty()) {
            return Err(beyond(index, "opaque triangles of a few texels take other steps"));
        }
        let scratch = Scratch::new(&mut allocator, queue, config, &plans, pairs, config.nodes)?;
        let size = maps.filters.size();
        let images = set.images.size();
        let (casters_of, triangles) = set.records();
        let numbers = Numbers::default()
            .with(Number::Width, size.width)
            .with(Number::Height, size.height)
            .with(Number::Layers, size.depth_or_array_layers)
            .with(Number::CasterCount, casters_of.len() as u64)
            .with(Number::TriangleCount, triangles.len() as u64)
            .with(Number::ImageWidth, images.width)
            .with(Number::ImageHeight, images.height)
            .with(Number::ImageCount, images.depth_or_array_layers);
        let absorptions = absorptions(casters.materials, casters.triangles);
        let blue_first = casters.particles.len() as u32 * CASTER_TEXELS;
        let materials =
            material_records(casters.materials, casters.textures, blue_first, &absorptions);
        Ok(Uploads {
            numbers,
            casters: bytemuck::cast_slice(casters_of).to_vec(),
            triangles: bytemuck::cast_slice(triangles).to_vec(),
            materials: bytemuck::cast_slice(&materials).to_vec(),
            images: image_bytes(casters, images),
            batches: plans.iter().map(|plan| self.batch(plan, scratch.pair_capacity)).collect(),
        })
    }

    fn batch(&self, plan: &Plan, pair_capacity: u32) -> BatchUploads {
        let list = |list: &ListPlan| {
            let shape = self.config.profile.shape;
            let scatter = self.config.scatters() && list.filters && !list.is_composed();
            let tiny = scatter && !list.tiny_chunks.is_empty();
            let conditions = list.conditions(shape, pair_capacity).with_readers(
                list.has_segments(),
                tiny,
                list.features.nodes > 0,
            );
            let numbers = list
                .numbers(shape)
                .with(Number::PairCapacity, pair_capacity)
                .with(Number::TileCount, plan.tile_count)
                .with(Number::ViewCount, plan.views.len() as u64)
                .with(Number::Scatter, u64::from(scatter));
            let holds = |when: &&When| conditions.hold(&[**when]);
            let has = |it: &&Trait| it.holds(list.features);
            ListUploads {
                numbers,
                conditions: When::ALL.iter().filter(holds).copied().collect(),
                traits: Trait::ALL.iter().filter(has).copied().collect(),
                constants: list.features.constants(),
                particle_chunks: list.particle_chunks.clone(),
                triangle_chunks: list.triangle_chunks.clone(),
                tiny_chunks: if tiny { list.tiny_chunks.clone() } else { Vec::new() },
            }
        };
        let [blocking, filtering] = &plan.lists;
        BatchUploads { views: plan.views.clone(), lists: [list(blocking), list(filtering)] }
    }
}

fn image_bytes(casters: &Casters<'_>, size: wgpu::Extent3d) -> Vec<u8> {
    let row = size.width as usize * 4;
    let layer = row * size.height as usize;
    let mut bytes = vec![0; layer * size.depth_or_array_layers as usize];
    for (texture, layer) in casters.textures.iter().zip(bytes.chunks_exact_mut(layer)) {
        let own = texture.width as usize * 4;
        for (from, to) in texture.rgba.chunks_exact(own).zip(layer.chunks_exact_mut(row)) {
            to[..own].copy_from_slice(from);
        }
    }
    bytes
}
