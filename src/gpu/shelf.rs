//! Buffers, textures and bind groups that a frame takes over from the one before.
use super::{kernel_error::KernelError, resource::Resource};
use std::{
    collections::HashMap,
    hash::Hash,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use wgpu::{
    Buffer, BufferUsages, Texture, TextureAspect, TextureDescriptor, TextureFormat, TextureUsages,
    TextureView,
};

/// Objects that the preparation of a frame makes besides maps and scratch memory. The next frame takes over
/// those of the same name and size, in the order of its requests: a frame like the one before makes nothing,
/// and writes only changed contents. A clone is the same shelf.
#[derive(Clone, Debug)]
pub struct Shelf {
    queue: wgpu::Queue,
    contents: Arc<Mutex<Contents>>,
}

/// Label, format, usage and size.
type TextureKey = (&'static str, TextureFormat, TextureUsages, [u32; 3]);

fn texture_key(desc: &TextureDescriptor<'static>) -> TextureKey {
    let wgpu::Extent3d { width, height, depth_or_array_layers } = desc.size;
    let size = [width, height, depth_or_array_layers];
    (desc.label.unwrap_or_default(), desc.format, desc.usage, size)
}

#[derive(Debug, Default)]
struct Contents {
    buffers: Rows<(&'static str, u64, BufferUsages), Filled>,
    textures: Rows<TextureKey, Texture>,
    /// Views of single layers of the host's textures.
    views: HashMap<(Texture, TextureAspect, u32), (TextureView, bool)>,
    layouts: HashMap<&'static str, wgpu::BindGroupLayout>,
    groups: HashMap<(wgpu::BindGroupLayout, Vec<Resource>), (wgpu::BindGroup, bool)>,
    /// Whether buffers were overwritten elsewhere after they were filled.
    is_overwritten: bool,
}

/// A buffer, and its contents where only the CPU writes it.
#[derive(Debug)]
struct Filled {
    buffer: Buffer,
    bytes: Option<Vec<u8>>,
}

/// Equal objects by their key, and the number that the current frame has taken.
#[derive(Debug)]
struct Rows<K, V>(HashMap<K, (Vec<V>, usize)>);

impl<K, V> Default for Rows<K, V> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<K: Eq + Hash, V> Rows<K, V> {
    fn take(&mut self, key: K, make: impl FnOnce() -> V) -> &mut V {
        let (all, taken) = self.0.entry(key).or_default();
        if *taken == all.len() {
            all.push(make());
        }
        *taken += 1;
        &mut all[*taken - 1]
    }

    /// The first object of its kind, whoever else has it, and whether the frame takes it for the first time.
    fn share(&mut self, key: K, make: impl FnOnce() -> V) -> (&mut V, bool) {
        let is_first = self.0.get(&key).is_none_or(|(_, taken)| *taken == 0);
        if is_first {
            return (self.take(key, make), true);
        }
        let (all, _) = self.0.entry(key).or_default();
        (&mut all[0], false)
    }

    /// Drops the objects that the last frame did not take.
    fn turn(&mut self) {
        self.0.retain(|_, (all, taken)| {
            all.truncate(std::mem::take(taken));
            !all.is_empty()
        });
    }
}

impl Shelf {
    /// An empty shelf.
    pub fn new(queue: &wgpu::Queue) -> Self {
        Self { queue: queue.clone(), contents: Arc::default() }
    }

    fn contents(&self) -> MutexGuard<'_, Contents> {
        self.contents.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a frame: all objects may be taken again.
    pub fn turn(&self) {
        let mut contents = self.contents();
        contents.buffers.turn();
        if std::mem::take(&mut contents.is_overwritten) {
            let all = contents.buffers.0.values_mut().flat_map(|(all, _)| all);
            all.for_each(|filled| filled.bytes = None);
        }
        contents.textures.turn();
        contents.views.retain(|_, (_, is_used)| std::mem::take(is_used));
        contents.groups.retain(|_, (_, is_used)| std::mem::take(is_used));
    }

    /// A buffer whose contents are undefined.
    pub(super) fn buffer(
        &self,
        device: &wgpu::Device,
        desc: &wgpu::BufferDescriptor<'static>,
    ) -> Buffer {
        let make = || Filled { buffer: device.create_buffer(desc), bytes: None };
        let key = (desc.label.unwrap_or_default(), desc.size, desc.usage);
        self.contents().buffers.take(key, make).buffer.clone()
    }

    /// A buffer with contents.
    pub(super) fn filled<T: bytemuck::NoUninit>(
        &self,
        device: &wgpu::Device,
        label: &'static str,
        data: &[T],
        usage: BufferUsages,
    ) -> Buffer {
        let bytes = padded(bytemuck::cast_slice(data));
        let usage = usage | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let size = bytes.len() as u64;
        let desc =
            wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        let mut contents = self.contents();
        let make = || Filled { buffer: device.create_buffer(&desc), bytes: None };
        let filled = contents.buffers.take((label, size, usage), make);
        if filled.bytes.as_ref() != Some(&bytes) {
            self.queue.write_buffer(&filled.buffer, 0, &bytes);
            filled.bytes = Some(bytes);
        }
        filled.buffer.clone()
    }

    /// States that the host has overwritten some of the buffers.
    pub fn overwritten(&self) {
        self.contents().is_overwritten = true;
    }

    /// A texture whose contents are undefined.
    pub fn texture(&self, device: &wgpu::Device, desc: &TextureDescriptor<'static>) -> Texture {
        let key = texture_key(desc);
        self.contents().textures.take(key, || device.create_texture(desc)).clone()
    }

    /// A buffer that all users of a frame share, one after another, and whether this user is the first.
    pub fn shared_buffer(
        &self,
        device: &wgpu::Device,
        desc: &wgpu::BufferDescriptor<'static>,
    ) -> (Buffer, bool) {
        let make = || Filled { buffer: device.create_buffer(desc), bytes: None };
        let key = (desc.label.unwrap_or_default(), desc.size, desc.usage);
        let mut contents = self.contents();
        let (shared, is_first) = contents.buffers.share(key, make);
        (shared.buffer.clone(), is_first)
    }

    /// A texture that all users of a frame share, one after another, and whether this user is the first.
    pub fn shared_texture(
        &self,
        device: &wgpu::Device,
        desc: &TextureDescriptor<'static>,
    ) -> (Texture, bool) {
        let mut contents = self.contents();
        let (texture, is_first) =
            contents.textures.share(texture_key(desc), || device.create_texture(desc));
        (texture.clone(), is_first)
    }

    /// The view of a layer of a texture.
    pub fn view(
        &self,
        texture: &Texture,
        aspect: TextureAspect,
        layer: u32,
        make: impl FnOnce() -> TextureView,
    ) -> TextureView {
        let mut contents = self.contents();
        let key = (texture.clone(), aspect, layer);
        let (view, is_used) = contents.views.entry(key).or_insert_with(|| (make(), true));
        *is_used = true;
        view.clone()
    }

    /// A layout, by its label.
    pub(super) fn layout(
        &self,
        label: &'static str,
        make: impl FnOnce() -> wgpu::BindGroupLayout,
    ) -> wgpu::BindGroupLayout {
        self.contents().layouts.entry(label).or_insert_with(make).clone()
    }

    /// The bind group of these resources.
    pub(super) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: Vec<Resource>,
        make: impl FnOnce() -> Result<wgpu::BindGroup, KernelError>,
    ) -> Result<wgpu::BindGroup, KernelError> {
        let mut contents = self.contents();
        let key = (layout.clone(), resources);
        if let Some((group, is_used)) = contents.groups.get_mut(&key) {
            *is_used = true;
            return Ok(group.clone());
        }
        let group = make()?;
        contents.groups.insert(key, (group.clone(), true));
        Ok(group)
    }
}

/// Bytes up to the alignment of copies, at least one word.
fn padded(bytes: &[u8]) -> Vec<u8> {
    let alignment = wgpu::COPY_BUFFER_ALIGNMENT as usize;
    let mut padded = bytes.to_vec();
    padded.resize(bytes.len().next_multiple_of(alignment).max(alignment), 0);
    padded
}
