//! Conversion of filter maps to the layout that a host's receivers already read.
use crate::shadows::{Prepared, views::host_depths::HostCamera};
use crate::{
    error::{Error, Input},
    frame::Commands,
    gpu::{Allocator, Memory, Timeline, allocated},
    model::View,
    records::{ConvertParams, FORMAT_RG11B10UFLOAT, FORMAT_RGBA8UNORM, FORMAT_RGBA16FLOAT},
    stage::import,
    view::atlas::MapSlot,
};
use glam::Mat4;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Texel format of converted filter maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilterFormat {
    /// Lossless, the format of gobo's own maps.
    #[default]
    Rgba16Float,
    /// Precision 1/510; light amplified by `gain` casters is clamped to 1.
    Rgba8Unorm,
    /// No alpha: relative precision 1/128 for red and green, 1/64 for blue.
    Rg11b10Ufloat,
}

impl FilterFormat {
    /// The texture's format, and its number in the kernel.
    fn texels(self) -> (TextureFormat, u32) {
        match self {
            Self::Rgba16Float => (TextureFormat::Rgba16Float, FORMAT_RGBA16FLOAT),
            Self::Rgba8Unorm => (TextureFormat::Rgba8Unorm, FORMAT_RGBA8UNORM),
            Self::Rg11b10Ufloat => (TextureFormat::Rg11b10Ufloat, FORMAT_RG11B10UFLOAT),
        }
    }
}

/// Layout of maps that a host's receivers read.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct MapLayout<'a> {
    format: FilterFormat,
    cameras: Option<&'a [[[f32; 4]; 4]]>,
}

impl<'a> MapLayout<'a> {
    /// A layout with alpha 1.
    pub fn new(format: FilterFormat) -> Self {
        Self { format, cameras: None }
    }

    /// A layout with the depth of the nearest translucent hit in alpha, as a raster pass with the blend
    /// operation MIN, or MAX for reversed z, would have left it; the depth of the far plane without a hit.
    /// `clip_from_world`: for each view, in columns, as for
    /// [`HostDepth::clip_from_world`](crate::HostDepth::clip_from_world).
    #[must_use]
    pub fn depth_in_alpha(self, clip_from_world: &'a [[[f32; 4]; 4]]) -> Self {
        Self { cameras: Some(clip_from_world), ..self }
    }

    fn check(&self, view_count: usize) -> Result<(), Error> {
        let Some(cameras) = self.cameras else { return Ok(()) };
        let invalid = |problem| Err(Input::MapLayout.invalid(0, problem));
        if self.format == FilterFormat::Rg11b10Ufloat {
            return invalid("its format has no alpha for the depth");
        }
        if cameras.len() != view_count {
            return invalid("it must have a matrix for each view");
        }
        Ok(())
    }

    /// Parameters of a view's conversion. `width`: of the maps \[texels\].
    fn params(
        &self,
        index: usize,
        view: &View,
        slot: MapSlot,
        width: u32,
    ) -> Result<ConvertParams, Error> {
        let columns = self.cameras.map(|cameras| &cameras[index]);
        let camera = columns.map_or_else(|| view.clip_from_world(), Mat4::from_cols_array_2d);
        let invalid = |problem| Input::MapLayout.invalid(index, problem);
        let camera = HostCamera::new(&camera, view).map_err(invalid)?;
        Ok(ConvertParams {
            clip_from_view: camera.clip_from_view.as_mat4(),
            size: view.size.as_vec2(),
            scale: view.scale,
            perspective: camera.perspective(),
            near: view.near,
            far: view.far,
            origin: slot.origin,
            layer: slot.layer,
            width,
            has_depth: u32::from(columns.is_some()),
            empty: camera.empty(),
        })
    }
}

/// Converted filter maps in a host's layout, ready to be recorded after the maps, any number of times. The
/// texture stays the same while no size changes: submit the recorded commands of a frame before you prepare
/// the next.
#[derive(Debug)]
pub struct ConvertedMaps {
    commands: Commands,
    texture: wgpu::Texture,
    memory: Memory,
}

impl Prepared {
    /// Converts the filters of all views to another layout; rectangles stay those of [`Maps`](crate::Maps).
    ///
    /// # Errors
    /// If the format has no alpha for the depth, a camera is invalid, a later `prepare` has taken the maps
    /// over, or the device is lost or out of memory.
    pub fn converted(&self, layout: &MapLayout<'_>) -> Result<ConvertedMaps, Error> {
        const LABEL: &str = "gobo convert";
        self.check_usable()?;
        layout.check(self.views.len())?;
        let (device, maps) = (self.device().0, self.maps());
        let shelf = self.light_shelf.take();
        allocated(device, || {
            let (format, number) = layout.format.texels();
            let size = maps.filters.size();
            let mut memory = Memory::default();
            let mut allocator = Allocator { shelf, ..Allocator::new(device, &mut memory) };
            let kernels = self.kernels_on(shelf);
            let of_texel = u64::from(format.block_copy_size(None).unwrap_or(4)) / 4;
            let texels = u64::from(size.width) * u64::from(size.height);
            let copied = BufferUsages::COPY_SRC;
            let words = allocator.storage::<u32>("converted", texels * of_texel, copied)?;
            let all = [size.width, size.height, size.depth_or_array_layers].map(u64::from);
            let usage = TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
            let texture = allocator.texture("converted_maps", format, all, usage)?;
            let format = [("FORMAT", f64::from(number))];
            let kernel = kernels.with_constants(&import::MAPS, &format)?;
            let mut layers = vec![Vec::new(); size.depth_or_array_layers as usize];
            for (index, (view, slot)) in self.views.iter().zip(&maps.slots).enumerate() {
                let values = layout.params(index, view, *slot, size.width)?;
                let params = allocator.uniform("convert_params", &values);
                let resources =
                    maps.resources().with("convert_params", &params).with("converted", &words);
                let groups = import::grid(view.size);
                let dispatch = kernels.dispatch_of(kernel.clone(), &resources, groups)?;
                layers[slot.layer as usize].push(dispatch);
            }
            let mut commands = Commands::new();
            let bytes_per_row = Some((words.size() / u64::from(size.height)) as u32);
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            for (z, views) in (0..).zip(layers) {
                commands.pass(LABEL, views);
                let from = wgpu::TexelCopyBufferInfo { buffer: &words, layout };
                let to = wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x: 0, y: 0, z },
                    ..texture.as_image_copy()
                };
                let extent = wgpu::Extent3d { depth_or_array_layers: 1, ..size };
                commands.copy_buffer_to_texture(LABEL, &from, to, extent);
            }
            commands.compile()?;
            Ok(ConvertedMaps { commands, texture, memory })
        })
    }
}

impl ConvertedMaps {
    /// Records the conversion. The maps must have been recorded before.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        self.commands.record(encoder, &mut Timeline::untimed());
    }

    /// Texture array of the size of gobo's own. Usages `TEXTURE_BINDING` and `COPY_SRC`.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Bytes by buffer and texture.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }
}
