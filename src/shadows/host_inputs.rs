//! Inputs that a host has on the device: casters, grids and depth maps.
use super::{EmittedSlots, HostGrid};
use crate::{
    error::{Error, Input},
    gpu::Kernel,
    model::Bounds,
};
use glam::Mat4;
use wgpu::{BindGroup, Buffer, Texture};

/// Inputs that a host has on the device, for [`Shadows::prepare_with`](crate::Shadows::prepare_with).
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct HostInputs<'a> {
    pub(super) casters: &'a [HostCasters<'a>],
    pub(super) grids: &'a [HostGrid<'a>],
    pub(super) depths: &'a [HostDepth<'a>],
    /// Emitters whose particles [`Shadows::load_emitted`] has loaded.
    pub(super) emitted: &'a [EmittedSlots],
    pub(super) area_lights: bool,
    /// Whether textures are uploaded with all their levels.
    pub(super) image_levels: bool,
}

impl<'a> HostInputs<'a> {
    /// No inputs.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds sets of casters, ordered as given, behind the uploaded casters.
    #[must_use]
    pub fn casters(self, casters: &'a [HostCasters<'a>]) -> Self {
        Self { casters, ..self }
    }

    /// Adds grids of voxels, ordered as given, behind all other casters.
    #[must_use]
    pub fn grids(self, grids: &'a [HostGrid<'a>]) -> Self {
        Self { grids, ..self }
    }

    /// Adds depth maps for some views, at most one each.
    #[must_use]
    pub fn depths(self, depths: &'a [HostDepth<'a>]) -> Self {
        Self { depths, ..self }
    }

    /// Announces [`Prepared::bind_area_lights`](crate::Prepared::bind_area_lights): the kernels that it needs
    /// are compiled with those of the maps, and are among those of
    /// [`Shadows::pending`](crate::Shadows::pending).
    #[must_use]
    pub fn area_lights(self) -> Self {
        Self { area_lights: true, ..self }
    }

    /// Uploads textures with all their levels, which pictures read; maps read only the first.
    #[must_use]
    pub fn image_levels(self) -> Self {
        Self { image_levels: true, ..self }
    }

    /// Adds particles of emitters that have been loaded.
    #[must_use]
    pub fn emitted(self, emitted: &'a [EmittedSlots]) -> Self {
        Self { emitted, ..self }
    }
}

/// Reader of the host's casters: a kernel that calls WGSL of the host.
#[derive(Clone, Debug)]
pub struct CasterLoader {
    pub(super) kernel: Kernel,
    /// Whether the casters are Gaussians.
    pub(super) gaussians: bool,
}

/// Number of casters in a set.
#[derive(Clone, Copy, Debug)]
pub enum CasterCount<'a> {
    /// A fixed number.
    Fixed(u32),
    /// The `u32` at `offset` of `buffer` when the frame runs.
    Indirect {
        /// Buffer of the usage `STORAGE`.
        buffer: &'a Buffer,
        /// Offset of the count, a multiple of 4 \[bytes\].
        offset: u64,
        /// Most casters, for which memory is allocated; further ones are left out.
        capacity: u32,
    },
}

impl CasterCount<'_> {
    /// Largest count.
    pub(super) fn capacity(&self) -> u32 {
        match *self {
            Self::Fixed(count) | Self::Indirect { capacity: count, .. } => count,
        }
    }

    /// Buffer of the count, and the index in it.
    pub(super) fn buffer(&self) -> (Option<&Buffer>, u32) {
        match *self {
            Self::Fixed(_) => (None, 0),
            Self::Indirect { buffer, offset, .. } => (Some(buffer), (offset / 4) as u32),
        }
    }
}

/// A set of casters in the host's buffers, in its layout, read when the frame runs, so that the CPU never
/// sees them. Their order matters where casters have the same depth, like that of uploads with
/// [`Casters::in_order`](crate::Casters::in_order). A caster is left out and counted, and changes nothing
/// else, if it has a number that is infinite or NaN, is farther than 1e7 m from the origin along an axis, or
/// has no radius, a colour out of range or a material outside the set.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct HostCasters<'a> {
    pub(super) loader: &'a CasterLoader,
    pub(super) bindings: &'a BindGroup,
    pub(super) count: CasterCount<'a>,
    pub(super) materials: &'a [u32],
    pub(super) bounds: Option<Bounds>,
    pub(super) least_alpha: f32,
    pub(super) version: Option<u64>,
}

impl<'a> HostCasters<'a> {
    /// `bindings`: of the loader's layout. `materials`: those that the casters may have, indices into
    /// [`Casters::materials`](crate::Casters::materials), which must either all block light or all filter it.
    pub fn new(
        loader: &'a CasterLoader,
        bindings: &'a BindGroup,
        count: CasterCount<'a>,
        materials: &'a [u32],
    ) -> Self {
        let (bounds, least_alpha, version) = (None, 0.0, None);
        Self { loader, bindings, count, materials, bounds, least_alpha, version }
    }

    /// Sets a finite box that contains all casters of the set: views that do not see it keep their maps.
    #[must_use]
    pub fn bounds(self, bounds: Bounds) -> Self {
        Self { bounds: Some(bounds), ..self }
    }

    /// Sets the smallest alpha above 0, finite and not negative. If no opacity is below 1/4096, faster
    /// kernels are used.
    #[must_use]
    pub fn least_alpha(self, least_alpha: f32) -> Self {
        Self { least_alpha, ..self }
    }

    /// Sets a version that changes when the casters do: while it stays, maps may be kept. Without a version,
    /// maps that may see the set are rendered in every frame.
    #[must_use]
    pub fn version(self, version: u64) -> Self {
        Self { version: Some(version), ..self }
    }

    /// Checks the set, the `index`th of the frame.
    ///
    /// # Errors
    /// The fault of the set.
    pub fn check(&self, index: usize) -> Result<(), Error> {
        let invalid = |problem| Err(Input::HostCasters.invalid(index, problem));
        let is_box =
            |it: Bounds| it == Bounds::EMPTY || it.is_finite() && it.min.cmple(it.max).all();
        if !self.bounds.is_none_or(is_box) {
            return invalid("its box must be finite, the lower corner first");
        }
        if !(self.least_alpha >= 0.0 && self.least_alpha.is_finite()) {
            return invalid("its least alpha must be finite and not negative");
        }
        match self.count {
            CasterCount::Indirect { offset, .. } if !offset.is_multiple_of(4) => {
                invalid("the offset of its count must be a multiple of 4")
            }
            CasterCount::Indirect { buffer, offset, .. }
                if offset.saturating_add(4) > buffer.size() =>
            {
                invalid("the buffer of its count ends before the count")
            }
            _ => Ok(()),
        }
    }
}

/// A depth map that the host rendered for a view: its opaque surfaces, read when the frame runs, in addition
/// to our own opaque casters or instead of them. Depth may be reversed, infinite, perspective or not, as in
/// the host's matrix. Where the map has its clear depth (1, or 0 for reversed z), there is no surface.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct HostDepth<'a> {
    pub(super) view: usize,
    pub(super) texture: &'a Texture,
    pub(super) layer: u32,
    pub(super) clip_from_world: Option<Mat4>,
    pub(super) instead: bool,
    pub(super) version: Option<u64>,
}

impl<'a> HostDepth<'a> {
    /// A map for the view with index `view`. `texture`: of a depth format or r32float, of any size, with the
    /// usage `TEXTURE_BINDING`; rendered with [`View::clip_from_world`](crate::View::clip_from_world), unless
    /// [`Self::clip_from_world`] is set.
    pub fn new(view: usize, texture: &'a Texture) -> Self {
        let (layer, clip_from_world, instead, version) = (0, None, false, None);
        Self { view, texture, layer, clip_from_world, instead, version }
    }

    /// Sets the layer of a texture array.
    #[must_use]
    pub fn layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }

    /// Sets the host's matrix: world space (that of views and casters) to clip space, in columns. Its
    /// camera is at the view's position and covers at least the view's window.
    #[must_use]
    pub fn clip_from_world(self, columns: [[f32; 4]; 4]) -> Self {
        Self { clip_from_world: Some(Mat4::from_cols_array_2d(&columns)), ..self }
    }

    /// Replaces our own opaque casters in this view, which are not rendered.
    #[must_use]
    pub fn instead(self) -> Self {
        Self { instead: true, ..self }
    }

    /// Sets a version that changes when the map does: while it stays, the view may be kept. Without a
    /// version the view is rendered in every frame, because casters filter only in front of the opaque
    /// surface.
    #[must_use]
    pub fn version(self, version: u64) -> Self {
        Self { version: Some(version), ..self }
    }
}
