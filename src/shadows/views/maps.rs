//! The shadow atlas: every view's filter, nearest depth and opaque depth.
use crate::{
    error::Error,
    gpu::{Allocator, Gpu, Resources, allocated},
    model::{TILE_SIZE, View},
    shadows::Config,
    shadows::views::curve_pages::{self, CurvePages},
    stage::{
        features::{Features, Flags},
        soften::run_layers,
    },
    view::atlas::{Atlas, AtlasLimits, MapSlot},
};
use glam::UVec2;
use wgpu::{
    BufferUsages,
    TextureFormat::{R32Float, Rgba16Float, Rgba32Float, Rgba32Uint},
    TextureUsages,
};

/// Texture arrays that hold all views' maps.
#[derive(Clone, Debug)]
pub struct Maps {
    /// `F`, rgba16float, with [`ShadowSettings::mips`] smaller levels. In these a view's rectangle is smaller
    /// as well, and a texel is the mean of the view's own texels.
    ///
    /// [`ShadowSettings::mips`]: crate::model::ShadowSettings::mips
    pub filters: wgpu::Texture,
    /// `D`, r32float.
    pub nearests: wgpu::Texture,
    /// `Z`, r32float.
    pub opaques: wgpu::Texture,
    /// `Z` per channel, rgba32float, with coloured dithering; `opaques` is the largest of them.
    pub colored: Option<wgpu::Texture>,
    /// Curves, two nodes to a texel (rgba32uint), `nodes` / 2 layers per layer of the other textures; a
    /// single texel without curves. A node that starts at 0 is unused, whatever its other bits: tiles that
    /// no caster has touched are zeros. With [`Self::pages`] a tile's texels are where its page is.
    pub curves: wgpu::Texture,
    /// Sums over the casters instead of `filters` and `nearests`, rgba32uint, if requested: optical depth per
    /// channel in fixed point, and nearness of the nearest hit.
    pub sums: Option<wgpu::Texture>,
    /// Nodes of a curve (K); 0 without curves.
    pub nodes: u32,
    /// Pages of [`Self::curves`], with [`CurveMemory::Counted`](crate::model::CurveMemory::Counted).
    pub pages: CurvePages,
    /// A word for each tile of the atlas, 0 while its curves are zeros, as in a new texture.
    pub(in crate::shadows) drawn_tiles: wgpu::Buffer,
    /// Whether light may increase along a curve: some caster has the `gain` or the `over` transfer.
    pub gain: bool,
    /// Rectangle of each view.
    pub slots: Vec<MapSlot>,
}

impl Maps {
    /// Their contents are undefined.
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        views: &[View],
        config: &Config,
        colored: bool,
        softened: bool,
    ) -> Result<Self, Error> {
        let (nodes, mips, sums) = (config.nodes(), config.settings.mips, config.toggles.sums);
        let limits = AtlasLimits::of(&allocator.device.limits());
        // Each layer has several layers of curves, or of the softening's runs.
        let of_softening = if softened { run_layers(colored, nodes) } else { 1 };
        let layers = limits.layers / (nodes / 2).max(of_softening);
        let limits = AtlasLimits { layers, ..limits };
        let sizes: Vec<UVec2> = views.iter().map(|view| view.size).collect();
        let atlas = Atlas::pack(&sizes, &limits).ok_or(Error::Limit {
            limit: "layers of the shadow atlas",
            have: u64::from(limits.layers),
            need: views.len() as u64,
            remedy: "use smaller maps or fewer lights; `view::fitted_views` makes maps smaller",
        })?;
        let size = [atlas.size.x, atlas.size.y, atlas.layers].map(u64::from);
        let usage =
            TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let slots = atlas.slots;
        let tiles = tiles_of(size);
        let has_pages = CurvePages::are_worth(config, tiles.iter().product());
        let of_pages = if has_pages { tiles } else { [1; 3] };
        let tiles = if nodes == 0 || has_pages { 1 } else { tiles.iter().product() };
        let of_curves = if nodes == 0 || has_pages {
            [1; 3]
        } else {
            [size[0], size[1], size[2] * u64::from(nodes / 2)]
        };
        allocated(allocator.device, || {
            let mut texture = |name, format| allocator.texture(name, format, size, usage);
            let opaques = texture("opaques", R32Float)?;
            let nearests = texture("nearests", R32Float)?;
            let colored = colored.then(|| texture("colored", Rgba32Float)).transpose()?;
            let sums = sums.then(|| texture("sums", Rgba32Uint)).transpose()?;
            let filters =
                allocator.texture_with_levels("filters", Rgba16Float, size, 1 + mips, usage)?;
            let curves = allocator.texture("curves", Rgba32Uint, of_curves, usage)?;
            let pages = CurvePages::new(allocator, of_pages)?;
            let drawn_tiles =
                allocator.storage::<u32>("drawn_tiles", tiles, BufferUsages::empty())?;
            Ok(Self {
                filters,
                nearests,
                opaques,
                colored,
                curves,
                sums,
                nodes,
                pages,
                drawn_tiles,
                gain: false,
                slots,
            })
        })
    }

    /// Fills the opaque depths with their values without opaque casters.
    pub(in crate::shadows) fn fill_depths(&self, queue: &wgpu::Queue) {
        fill(queue, &self.opaques, 1.0_f32);
        self.colored.iter().for_each(|colored| fill(queue, colored, [1.0_f32; 4]));
    }

    /// Fills the maps with their values without translucent casters.
    pub(in crate::shadows) fn fill_clear(&self, queue: &wgpu::Queue) {
        fill(queue, &self.filters, [half::f16::ONE; 4].map(half::f16::to_bits));
        fill(queue, &self.nearests, 1.0_f32);
    }

    /// Allocates the curves, if they are in pages: `count` of them, for at most all tiles.
    pub(in crate::shadows) fn add_pages(
        &mut self,
        allocator: &mut Allocator<'_>,
        count: u32,
    ) -> Result<(), Error> {
        let pages = self.pages.clone();
        (self.pages, self.curves) = pages.with_pages(allocator, count, self.nodes)?;
        Ok(())
    }

    /// First texel and layer of each tile's curves in the rectangle of a view of a size, row by row; none
    /// where all nodes are unused. Blocks, with pages.
    pub fn curve_places(
        &self,
        gpu: &Gpu,
        slot: MapSlot,
        size: UVec2,
    ) -> Result<Vec<Option<wgpu::Origin3d>>, Error> {
        let pairs = self.nodes / 2;
        let (first, table) = (slot.origin / TILE_SIZE, self.pages.table.size());
        let words: Vec<u32> =
            if self.has_pages() { gpu.try_read_texture(&self.pages.table)? } else { Vec::new() };
        let tiles = size.map(|edge| edge.div_ceil(TILE_SIZE));
        let all = (0..tiles.y).flat_map(|y| (0..tiles.x).map(move |x| UVec2::new(x, y) + first));
        let place = |tile: UVec2| {
            if words.is_empty() {
                let at = tile * TILE_SIZE;
                return Some(wgpu::Origin3d { x: at.x, y: at.y, z: slot.layer * pairs });
            }
            let row = slot.layer * table.height + tile.y;
            curve_pages::place(words[(row * table.width + tile.x) as usize], pairs)
        };
        Ok(all.map(place).collect())
    }

    /// Whether curves are in pages.
    pub fn has_pages(&self) -> bool {
        self.pages.exist()
    }

    /// Whether curves are where a configuration asks for them.
    pub(in crate::shadows) fn has_pages_as(&self, config: &Config) -> bool {
        let size = self.filters.size();
        let size = [size.width, size.height, size.depth_or_array_layers].map(u64::from);
        self.has_pages() == CurvePages::are_worth(config, tiles_of(size).iter().product())
    }

    /// Features of kernels that read the maps.
    pub fn features(&self) -> Features {
        Features::of_maps(self.nodes, self.gain).with(Flags::HAS_PAGES, self.has_pages())
    }

    /// Resets the sums, if there are any: texels that no caster touches would keep theirs.
    pub(in crate::shadows) fn clear_sums(&self, queue: &wgpu::Queue) {
        self.sums.iter().for_each(|sums| fill(queue, sums, [0_u32; 4]));
    }

    /// The textures of a view's map.
    pub(in crate::shadows) fn textures(&self) -> [&wgpu::Texture; 3] {
        let Self { filters, nearests, opaques, .. } = self;
        [filters, nearests, opaques]
    }

    pub(crate) fn resources(&self) -> Resources {
        Resources::new()
            .with("filters", &self.filters)
            .with("nearests", &self.nearests)
            .with("opaques", &self.opaques)
            .with("curves", &self.curves)
            .with("curve_pages", &self.pages.table)
            .with("free_pages", &self.pages.free)
            .with("drawn_tiles", &self.drawn_tiles)
            .with_any("kept_sums", self.sums.as_ref())
            .with_any("colored", self.colored.as_ref())
    }

    /// Resources of light look-ups, with opaque depths by channel if there are any.
    pub fn look_up_resources(&self) -> Resources {
        self.resources().with("opaques", self.colored.as_ref().unwrap_or(&self.opaques))
    }

    /// New maps of the same size and rectangles.
    pub(in crate::shadows) fn softened(
        &self,
        allocator: &mut Allocator<'_>,
    ) -> Result<Self, Error> {
        let like = self.filters.size();
        let size = [like.width, like.height, like.depth_or_array_layers].map(u64::from);
        let usage =
            TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let levels = self.filters.mip_level_count();
        let of_curves = self.curves.size();
        let layers = of_curves.depth_or_array_layers;
        let of_curves = [of_curves.width, of_curves.height, layers].map(u64::from);
        let curves = match self.nodes {
            0 => self.curves.clone(),
            _ => allocator.texture("soft_curves", Rgba32Uint, of_curves, usage)?,
        };
        Ok(Self {
            filters: allocator.texture_with_levels(
                "soft_filters",
                Rgba16Float,
                size,
                levels,
                usage,
            )?,
            nearests: allocator.texture("soft_nearests", R32Float, size, usage)?,
            opaques: allocator.texture("soft_opaques", R32Float, size, usage)?,
            colored: None,
            sums: None,
            curves,
            nodes: self.nodes,
            pages: self.pages.clone(),
            drawn_tiles: self.drawn_tiles.clone(),
            gain: self.gain,
            slots: self.slots.clone(),
        })
    }
}

/// Tiles of an atlas of a size \[texels\], in x, y and layers.
fn tiles_of([width, height, layers]: [u64; 3]) -> [u64; 3] {
    let tile = u64::from(TILE_SIZE);
    [width / tile, height / tile, layers]
}

/// Fills every texel of an array.
fn fill<T: bytemuck::NoUninit>(queue: &wgpu::Queue, texture: &wgpu::Texture, value: T) {
    let size = texture.size();
    let layer = vec![value; (size.width * size.height) as usize];
    for z in 0..size.depth_or_array_layers {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: 0, z },
                ..texture.as_image_copy()
            },
            bytemuck::cast_slice(&layer),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size.width * size_of::<T>() as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..size },
        );
    }
}
