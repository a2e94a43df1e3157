//! Resources of kernels, bound by name as declared in `wgsl/bind/`.
use super::{
    adapter::STORAGE_FORMATS,
    kernel_error::KernelError,
    link::{Item, LinkError, Linked, words},
};
use std::collections::HashMap;
use wgpu::{TextureFormat, TextureSampleType, TextureViewDimension};

/// Access of a shader to a storage buffer or storage texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read.
    Read,
    /// Written.
    Write,
    /// Read and written.
    ReadWrite,
    /// Atomics on a storage texture, native tier only.
    Atomic,
}

/// Type of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer.
    Storage {
        /// Access of the kernel.
        access: Access,
    },
    /// A storage texture.
    StorageTexture {
        /// Access of the kernel.
        access: Access,
        /// Format of its texels.
        format: TextureFormat,
        /// Dimension of the view.
        dimension: TextureViewDimension,
    },
    /// A texture read with `textureLoad`: never filtered, so without a sampler.
    Texture {
        /// Kind of its texels.
        sample: TextureSampleType,
        /// Dimension of the view.
        dimension: TextureViewDimension,
    },
}

/// A resource of group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Name in WGSL.
    pub name: &'static str,
    /// `@binding` number, the same in every kernel.
    pub number: u32,
    /// Kind of the resource.
    pub kind: BindingKind,
}

impl Linked {
    /// Bindings of the kernel, sorted by number.
    pub fn bindings(&self) -> Result<Vec<Binding>, KernelError> {
        let bound = self.items.iter().filter(|item| item.text.contains("@binding("));
        let mut bindings: Vec<_> = bound
            .map(|item| {
                Binding::declared(item).ok_or_else(|| LinkError {
                    file: item.file,
                    line: item.line,
                    reason: format!(
                        "`{}` is bound in a way that the host does not know",
                        item.name
                    ),
                })
            })
            .collect::<Result<_, LinkError>>()?;
        bindings.sort_unstable_by_key(|binding| binding.number);
        Ok(bindings)
    }
}

impl Binding {
    /// Reads `@group(0) @binding(3) var<storage, read> chunks: array<Chunk>;`, word by word, because browsers
    /// have no reflection.
    pub(super) fn declared(item: &Item) -> Option<Self> {
        let words: Vec<_> = words(item.text).map(|(_, word)| word).collect();
        let ["group", "0", "binding", number, "var", declared @ ..] = words.as_slice() else {
            return None;
        };
        let kind = match *declared {
            ["uniform", ..] => BindingKind::Uniform,
            ["storage", allowed, ..] => BindingKind::Storage { access: access(allowed)? },
            [_, texture, format, allowed] => BindingKind::StorageTexture {
                access: access(allowed)?,
                format: self::format(format)?,
                dimension: dimension(texture)?,
            },
            [_, texture, sample] => BindingKind::Texture {
                sample: match sample {
                    "f32" => TextureSampleType::Float { filterable: false },
                    "u32" => TextureSampleType::Uint,
                    "i32" => TextureSampleType::Sint,
                    _ => return None,
                },
                dimension: dimension(texture)?,
            },
            _ => return None,
        };
        Some(Self { name: item.name, number: number.parse().ok()?, kind })
    }

    pub(super) fn entry(&self, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
        wgpu::BindGroupLayoutEntry {
            binding: self.number,
            visibility,
            ty: self.kind.layout(),
            count: None,
        }
    }
}

fn access(word: &str) -> Option<Access> {
    Some(match word {
        "read" => Access::Read,
        "write" => Access::Write,
        "read_write" => Access::ReadWrite,
        "atomic" => Access::Atomic,
        _ => return None,
    })
}

fn dimension(texture: &str) -> Option<TextureViewDimension> {
    Some(match texture {
        "texture_2d" | "texture_storage_2d" => TextureViewDimension::D2,
        "texture_3d" | "texture_storage_3d" => TextureViewDimension::D3,
        "texture_2d_array" | "texture_storage_2d_array" => TextureViewDimension::D2Array,
        _ => return None,
    })
}

/// Format with a WGSL name, which is Rust's in lower case.
fn format(word: &str) -> Option<TextureFormat> {
    let is_named = |format: &TextureFormat| format!("{format:?}").eq_ignore_ascii_case(word);
    STORAGE_FORMATS.into_iter().find(is_named)
}

impl BindingKind {
    fn layout(self) -> wgpu::BindingType {
        use wgpu::BufferBindingType::{Storage, Uniform};
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        match self {
            Self::Uniform => buffer(Uniform),
            Self::Storage { access } => buffer(Storage { read_only: access == Access::Read }),
            Self::StorageTexture { access, format, dimension } => {
                wgpu::BindingType::StorageTexture {
                    access: match access {
                        Access::Read => wgpu::StorageTextureAccess::ReadOnly,
                        Access::Write => wgpu::StorageTextureAccess::WriteOnly,
                        Access::ReadWrite => wgpu::StorageTextureAccess::ReadWrite,
                        Access::Atomic => wgpu::StorageTextureAccess::Atomic,
                    },
                    format,
                    view_dimension: dimension,
                }
            }
            Self::Texture { sample, dimension } => wgpu::BindingType::Texture {
                sample_type: sample,
                view_dimension: dimension,
                multisampled: false,
            },
        }
    }

    fn dimension(self) -> Option<TextureViewDimension> {
        match self {
            Self::Uniform | Self::Storage { .. } => None,
            Self::StorageTexture { dimension, .. } | Self::Texture { dimension, .. } => {
                Some(dimension)
            }
        }
    }

    /// Whether a resource fits this kind of binding.
    pub(super) fn takes(self, resource: &Resource) -> bool {
        use wgpu::{BufferUsages, TextureUsages};
        let texture = match resource {
            Resource::Buffer(buffer) => {
                return match self {
                    Self::Uniform => buffer.usage().contains(BufferUsages::UNIFORM),
                    Self::Storage { .. } => buffer.usage().contains(BufferUsages::STORAGE),
                    Self::StorageTexture { .. } | Self::Texture { .. } => false,
                };
            }
            Resource::Texture(texture) => texture,
            Resource::View(view) => view.texture(),
        };
        match self {
            Self::Uniform | Self::Storage { .. } => false,
            Self::StorageTexture { access, format, .. } => {
                let usage = match access {
                    Access::Atomic => TextureUsages::STORAGE_ATOMIC,
                    _ => TextureUsages::STORAGE_BINDING,
                };
                texture.usage().contains(usage) && texture.format() == format
            }
            Self::Texture { sample, .. } => {
                let found = texture.format().sample_type(None, None);
                let is_float =
                    |sample: TextureSampleType| matches!(sample, TextureSampleType::Float { .. });
                let is_depth = texture.format().has_depth_aspect() && is_float(sample);
                let is_alike = |found| found == sample || is_float(found) && is_float(sample);
                texture.usage().contains(TextureUsages::TEXTURE_BINDING)
                    && (is_depth || found.is_some_and(is_alike))
            }
        }
    }
}

/// A resource that a kernel may bind. A clone is the same resource.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Resource {
    /// A whole buffer.
    Buffer(wgpu::Buffer),
    /// A texture without its smaller mip levels, as an array if the kernel reads one.
    Texture(wgpu::Texture),
    /// A view of a texture.
    View(wgpu::TextureView),
}

/// A resource in the form that a bind group takes.
pub(super) enum Bindable<'a> {
    Given(wgpu::BindingResource<'a>),
    /// A view of a texture, made for the binding.
    Made(wgpu::TextureView),
}

impl Resource {
    pub(super) fn bound(&self, kind: BindingKind) -> Bindable<'_> {
        match self {
            Self::Buffer(buffer) => Bindable::Given(buffer.as_entire_binding()),
            Self::View(view) => Bindable::Given(wgpu::BindingResource::TextureView(view)),
            Self::Texture(texture) => {
                let dimension = kind.dimension();
                let desc = wgpu::TextureViewDescriptor {
                    dimension,
                    mip_level_count: Some(1),
                    ..Default::default()
                };
                Bindable::Made(texture.create_view(&desc))
            }
        }
    }
}

impl Bindable<'_> {
    pub(super) fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Given(resource) => resource.clone(),
            Self::Made(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

impl std::fmt::Display for Resource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Buffer(buffer) => write!(f, "a buffer ({:?})", buffer.usage()),
            Self::Texture(texture) => write!(f, "a texture of {:?}", texture.format()),
            Self::View(view) => write!(f, "a texture of {:?}", view.texture().format()),
        }
    }
}

impl From<&Self> for Resource {
    fn from(resource: &Self) -> Self {
        resource.clone()
    }
}

impl From<&wgpu::Buffer> for Resource {
    fn from(buffer: &wgpu::Buffer) -> Self {
        Self::Buffer(buffer.clone())
    }
}

impl From<&wgpu::Texture> for Resource {
    fn from(texture: &wgpu::Texture) -> Self {
        Self::Texture(texture.clone())
    }
}

impl From<&wgpu::TextureView> for Resource {
    fn from(view: &wgpu::TextureView) -> Self {
        Self::View(view.clone())
    }
}

/// Resources by name. A kernel binds those that it declares.
#[derive(Clone, Debug, Default)]
pub struct Resources(HashMap<&'static str, Resource>);

impl Resources {
    /// No resources.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a resource; it replaces an earlier one of that name.
    #[must_use]
    pub fn with(mut self, name: &'static str, resource: impl Into<Resource>) -> Self {
        self.0.insert(name, resource.into());
        self
    }

    /// Adds a resource if there is one.
    #[must_use]
    pub fn with_any(self, name: &'static str, resource: Option<impl Into<Resource>>) -> Self {
        match resource {
            Some(resource) => self.with(name, resource),
            None => self,
        }
    }

    /// Union of both; `other` takes precedence.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        self.0.extend(other.0.iter().map(|(name, resource)| (*name, resource.clone())));
        self
    }

    /// The resource with a name.
    pub fn get(&self, name: &str) -> Option<&Resource> {
        self.0.get(name)
    }
}
