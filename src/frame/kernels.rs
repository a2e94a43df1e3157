//! The kernels of one device, by description and features.
use super::{Dispatch, Work};
use crate::{
    gpu::{
        Allocator, Constant, Kernel, KernelCache, KernelDesc, KernelError, Memory, RecordForm,
        Resource, Resources, Shelf, Tier,
    },
    stage::{features::Features, tuning::Tuning},
};
use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Mutex, PoisonError},
};

/// The kernels of one device, each linked when first requested. A clone has the same kernels.
#[derive(Clone, Debug)]
pub struct Kernels {
    device: wgpu::Device,
    tier: Tier,
    tuning: Tuning,
    /// By source: descriptions and features with the same code share a pipeline.
    cache: KernelCache,
    linked: Arc<Mutex<HashMap<(&'static str, Features), Kernel>>>,
    /// Objects of the last frame.
    shelf: Option<Shelf>,
}

impl Kernels {
    /// `cache`: kernels of other renderers on the device.
    pub fn new(device: &wgpu::Device, tier: Tier, tuning: Tuning, cache: KernelCache) -> Self {
        Self { device: device.clone(), tier, tuning, cache, linked: Arc::default(), shelf: None }
    }

    /// The same kernels, with dispatches that take over the last frame's bind groups.
    #[must_use]
    pub fn with_shelf(&self, shelf: &Shelf) -> Self {
        Self { shelf: Some(shelf.clone()), ..self.clone() }
    }

    /// Objects of the last frame, if the kernels take them over.
    pub fn shelf(&self) -> Option<&Shelf> {
        self.shelf.as_ref()
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The tier of all kernels.
    pub fn tier(&self) -> Tier {
        self.tier
    }

    /// The tuning of the adapter.
    pub fn tuning(&self) -> Tuning {
        self.tuning
    }

    /// A kernel, specialised to features: [`Self::finish`] compiles it.
    pub fn get(&self, desc: &KernelDesc, features: Features) -> Result<Kernel, KernelError> {
        let mut linked = self.linked.lock().unwrap_or_else(PoisonError::into_inner);
        match linked.entry((desc.name, features)) {
            Entry::Occupied(known) => Ok(known.get().clone()),
            Entry::Vacant(vacant) => {
                let kernel = self.with_constants(desc, &features.constants())?;
                Ok(vacant.insert(kernel).clone())
            }
        }
    }

    /// A kernel with values for overrides that no features have.
    pub fn with_constants(
        &self,
        desc: &KernelDesc,
        constants: &[Constant],
    ) -> Result<Kernel, KernelError> {
        let Self { device, tier, tuning, cache, .. } = self;
        let constants = [constants, &tuning.constants()].concat();
        cache.request(device, desc, *tier, &tuning.choices(desc), &constants)
    }

    /// A dispatch of a kernel with the resources that it declares.
    pub fn dispatch(
        &self,
        desc: &KernelDesc,
        features: Features,
        resources: &Resources,
        work: impl Into<Work>,
    ) -> Result<Dispatch, KernelError> {
        self.dispatch_of(self.get(desc, features)?, resources, work)
    }

    /// A dispatch of a kernel with a text of the host.
    pub fn dispatch_of(
        &self,
        kernel: Kernel,
        resources: &Resources,
        work: impl Into<Work>,
    ) -> Result<Dispatch, KernelError> {
        let group = match &self.shelf {
            Some(shelf) => kernel.bind_on(shelf, resources)?,
            None => kernel.bind(&self.device, resources)?,
        };
        Ok(Dispatch::new(kernel, group, resources, work))
    }

    /// A buffer with contents, for a frame.
    pub fn filled<T: bytemuck::NoUninit>(
        &self,
        label: &'static str,
        data: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        let mut memory = Memory::default();
        Allocator { shelf: self.shelf(), ..Allocator::new(&self.device, &mut memory) }
            .filled(label, data, usage)
    }

    /// Rows of words whose contents are undefined, where records are, for users of a frame one after another,
    /// and whether this user is the first.
    pub(super) fn shared_words(
        &self,
        label: &'static str,
        [width, height]: [u32; 2],
    ) -> (Resource, bool) {
        let (device, label) = (&self.device, Some(label));
        match self.tuning.record_form {
            RecordForm::Buffers => {
                let desc = wgpu::BufferDescriptor {
                    label,
                    size: u64::from(width) * u64::from(height) * size_of::<u32>() as u64,
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                };
                let made = || (device.create_buffer(&desc), true);
                let of_shelf = |shelf: &Shelf| shelf.shared_buffer(device, &desc);
                let (buffer, is_first) = self.shelf().map_or_else(made, of_shelf);
                (Resource::Buffer(buffer), is_first)
            }
            RecordForm::Textures => {
                let desc = wgpu::TextureDescriptor {
                    label,
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::R32Uint,
                    usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
                    view_formats: &[],
                };
                let made = || (device.create_texture(&desc), true);
                let of_shelf = |shelf: &Shelf| shelf.shared_texture(device, &desc);
                let (texture, is_first) = self.shelf().map_or_else(made, of_shelf);
                (Resource::Texture(texture), is_first)
            }
        }
    }

    /// Tunes kernels that are requested from now on to another profile.
    pub fn follow(&mut self, tuning: Tuning) {
        if tuning != self.tuning {
            self.tuning = tuning;
            self.linked = Arc::default();
        }
    }

    /// Compiles all requested kernels.
    pub fn finish(&self) -> Result<(), KernelError> {
        self.cache.finish()
    }

    /// The compiled kernels, by source.
    pub fn cache(&self) -> &KernelCache {
        &self.cache
    }
}
