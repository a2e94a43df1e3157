//! What a host has on the device already, as it says it.
use super::Shadows;
use crate::{
    error::Error,
    gpu::{HostText, Kernel},
    model::Bounds,
    stage::load,
};
use glam::Mat4;
use wgpu::{BindGroup, BindGroupLayout, Buffer, Texture};

/// What a host has on the device already, for [`Shadows::prepare_with`].
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct HostInputs<'a> {
    pub(super) casters: &'a [HostCasters<'a>],
    pub(super) depths: &'a [HostDepth<'a>],
}

impl<'a> HostInputs<'a> {
    /// Nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets of casters, in this order behind those that are uploaded.
    #[must_use]
    pub fn casters(self, casters: &'a [HostCasters<'a>]) -> Self {
        Self { casters, ..self }
    }

    /// Depth maps of some views, at most one each.
    #[must_use]
    pub fn depths(self, depths: &'a [HostDepth<'a>]) -> Self {
        Self { depths, ..self }
    }
}

/// How casters of the host's are read: a kernel that calls WGSL of the host's.
#[derive(Clone, Debug)]
pub struct CasterLoader {
    pub(super) kernel: Kernel,
}

impl Shadows {
    /// Makes a loader of `wgsl`, which declares what it binds in `@group(1)`, of `layout`, and
    ///
    /// ```wgsl
    /// fn load_caster(index: u32) -> Caster
    /// ```
    ///
    /// It stands beside a declaration of the library's, in which the fields are those of
    /// [`Particle`](crate::Particle):
    ///
    /// ```wgsl
    /// struct Caster {
    ///     center: vec3<f32>, // world space [m]
    ///     radius: f32,       // [m]
    ///     color: vec4<f32>,  // linear rgba; multiplies the material's tint
    ///     rotation: f32,     // of a quad about the ray from the light [radians]
    ///     material: u32,     // index
    ///     id: u32,           // decorrelates dither patterns
    /// }
    /// ```
    ///
    /// All other names of the library's begin with `gobo_`. `label` is what errors call the text.
    ///
    /// # Errors
    /// Where the text is no WGSL, or does not fit: with its line, as `label:line`.
    pub fn caster_loader(
        &self,
        label: &str,
        wgsl: &str,
        layout: &BindGroupLayout,
    ) -> Result<CasterLoader, Error> {
        let host = HostText {
            label,
            wgsl,
            layout,
            choice: load::LOADER,
            constants: &[],
            shared: &["Caster"],
        };
        let (device, tier) = self.device();
        Ok(CasterLoader { kernel: Kernel::with_host_text(device, &load::CASTERS, tier, &host)? })
    }
}

/// How many casters a set has.
#[derive(Clone, Copy, Debug)]
pub enum CasterCount<'a> {
    /// So many.
    Fixed(u32),
    /// As many as the `u32` says that lies at `offset` of `buffer` when the frame runs.
    Indirect {
        /// Buffer of the usage `STORAGE`.
        buffer: &'a Buffer,
        /// A multiple of 4 [bytes].
        offset: u64,
        /// Those past it are left out. Memory and time are for so many.
        capacity: u32,
    },
}

impl CasterCount<'_> {
    /// The most.
    pub(super) fn capacity(&self) -> u32 {
        match *self {
            Self::Fixed(count) | Self::Indirect { capacity: count, .. } => count,
        }
    }

    /// And the place in it.
    pub(super) fn buffer(&self) -> (Option<&Buffer>, u32) {
        match *self {
            Self::Fixed(_) => (None, 0),
            Self::Indirect { buffer, offset, .. } => (Some(buffer), (offset / 4) as u32),
        }
    }
}

/// A set of casters in buffers of the host's, in its layout: read when the frame runs, so that the CPU
/// never sees them. Their order counts where casters are at the same depth, as that of uploads does
/// with [`Casters::in_order`](crate::Casters::in_order). One that has a number which is not finite, is
/// farther than 1e7 m from the origin along an axis, has no radius, a colour out of range or another
/// material is left out and counted, and changes nothing else.
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
    /// [`Casters::materials`](crate::Casters::materials), which all block light or all filter it.
    pub fn new(
        loader: &'a CasterLoader,
        bindings: &'a BindGroup,
        count: CasterCount<'a>,
        materials: &'a [u32],
    ) -> Self {
        let (bounds, least_alpha, version) = (None, 0.0, None);
        Self { loader, bindings, count, materials, bounds, least_alpha, version }
    }

    /// A box that no caster of the set leaves: views that do not see it keep their maps.
    #[must_use]
    pub fn bounds(self, bounds: Bounds) -> Self {
        Self { bounds: Some(bounds), ..self }
    }

    /// No caster has an alpha between 0 and this. Where no opacity is below 1/4096, faster kernels do.
    #[must_use]
    pub fn least_alpha(self, least_alpha: f32) -> Self {
        Self { least_alpha, ..self }
    }

    /// Changes when the casters do: while it stays, maps may stay. Without it they are rendered in
    /// every frame.
    #[must_use]
    pub fn version(self, version: u64) -> Self {
        Self { version: Some(version), ..self }
    }

    pub(super) fn check(&self, index: usize) -> Result<(), Error> {
        let invalid = |problem| Err(Error::Invalid { what: "set of host casters", index, problem });
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

/// A depth map that the host rendered of a view: what is opaque, read when the frame runs, beside our
/// own opaque casters or instead of them. Depth may be reversed, infinite, perspective or not: the
/// host's matrix says it. Where the map has what it was cleared to (1, or 0 where it is reversed), there
/// is nothing.
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
    /// A map of `view`, an index. `texture`: of a format of depth or r32float, of any size, with the usage
    /// `TEXTURE_BINDING`; rendered with [`View::clip_from_world`](crate::View::clip_from_world), if
    /// [`Self::clip_from_world`] does not say otherwise.
    pub fn new(view: usize, texture: &'a Texture) -> Self {
        let (layer, clip_from_world, instead, version) = (0, None, false, None);
        Self { view, texture, layer, clip_from_world, instead, version }
    }

    /// Layer of an array.
    #[must_use]
    pub fn layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }

    /// What the host rendered with: world space (the one that views and casters are in) to clip space,
    /// in columns. It sees from where the view does, and at least what the view does.
    #[must_use]
    pub fn clip_from_world(self, columns: [[f32; 4]; 4]) -> Self {
        Self { clip_from_world: Some(Mat4::from_cols_array_2d(&columns)), ..self }
    }

    /// Our own opaque casters are not rendered in this view: the host's map has them.
    #[must_use]
    pub fn instead(self) -> Self {
        Self { instead: true, ..self }
    }

    /// Changes when the map does: while it stays, the view may stay. Without it the view is rendered
    /// in every frame, because what filters counts before the opaque surface only.
    #[must_use]
    pub fn version(self, version: u64) -> Self {
        Self { version: Some(version), ..self }
    }
}
