//! Readers of the host's casters and grids.
use super::{CasterLoader, GridLoader, Shadows};
use crate::{
    error::Error,
    gpu::{HostText, Kernel, check_alive},
    stage::load,
};
use wgpu::BindGroupLayout;

impl Shadows {
    /// Makes a loader of `wgsl`, which declares its bindings in `@group(1)`, of `layout`, and
    ///
    /// ```wgsl
    /// fn load_caster(index: u32) -> Caster
    /// ```
    ///
    /// It is compiled together with a declaration of the library, whose fields are those of
    /// [`Particle`](crate::Particle):
    ///
    /// ```wgsl
    /// struct Caster {
    ///     center: vec3<f32>, // world space \[m\]
    ///     radius: f32,       // \[m\]
    ///     color: vec4<f32>,  // linear rgba; multiplies the material's tint
    ///     rotation: f32,     // of a quad about the ray from the light \[radians\]
    ///     material: u32,     // index
    ///     id: u32,           // decorrelates dither patterns
    /// }
    /// ```
    ///
    /// All other names of the library begin with `gobo_`. `label` names the text in errors.
    ///
    /// # Errors
    /// If the text is invalid WGSL or does not fit, with its line, as `label:line`; or the device is lost.
    pub fn caster_loader(
        &self,
        label: &str,
        wgsl: &str,
        layout: &BindGroupLayout,
    ) -> Result<CasterLoader, Error> {
        self.loader(false, (label, wgsl, layout))
    }

    /// Like [`Self::caster_loader`], for Gaussians. `wgsl` declares
    ///
    /// ```wgsl
    /// fn load_gaussian(index: u32) -> Gaussian
    /// ```
    ///
    /// It is compiled together with a declaration of the library, whose fields are those of
    /// [`Gaussian`](crate::Gaussian); the material defines the meaning of opacity:
    ///
    /// ```wgsl
    /// struct Gaussian {
    ///     center: vec3<f32>,   // world space \[m\]
    ///     opacity: f32,        // at the centre
    ///     rotation: vec4<f32>, // unit quaternion x, y, z, w: from its own space to the world
    ///     sigma: vec3<f32>,    // standard deviations along its axes \[m\]
    ///     material: u32,       // index
    ///     color: vec3<f32>,    // linear rgb; multiplies the material's tint
    ///     id: u32,             // decorrelates dither patterns
    /// }
    /// ```
    ///
    /// # Errors
    /// Those of [`Self::caster_loader`].
    pub fn gaussian_loader(
        &self,
        label: &str,
        wgsl: &str,
        layout: &BindGroupLayout,
    ) -> Result<CasterLoader, Error> {
        self.loader(true, (label, wgsl, layout))
    }

    /// Makes a loader of a grid's voxels, for a pool of bricks, a buffer, or a texture that must be read in
    /// another way than by [`HostGrid::new`](crate::HostGrid::new). `wgsl` declares its bindings in
    /// `@group(1)`, of `layout`, and
    ///
    /// ```wgsl
    /// fn load_density(voxel: vec3<u32>) -> f32
    /// ```
    ///
    /// All names of the library begin with `gobo_`. `label` names the text in errors.
    ///
    /// # Errors
    /// Those of [`Self::caster_loader`].
    pub fn grid_loader(
        &self,
        label: &str,
        wgsl: &str,
        layout: &BindGroupLayout,
    ) -> Result<GridLoader, Error> {
        let choice = load::LOADER;
        let host = HostText { label, wgsl, layout, choice, constants: &[], shared: &[] };
        let (device, tier) = self.device();
        check_alive(device)?;
        Ok(GridLoader { kernel: Kernel::with_host_text(device, &load::VOXELS, tier, &host)? })
    }

    fn loader(
        &self,
        gaussians: bool,
        (label, wgsl, layout): (&str, &str, &BindGroupLayout),
    ) -> Result<CasterLoader, Error> {
        let (desc, shared) = if gaussians {
            (&load::GAUSSIANS, &["Gaussian"])
        } else {
            (&load::CASTERS, &["Caster"])
        };
        let host = HostText { label, wgsl, layout, choice: load::LOADER, constants: &[], shared };
        let (device, tier) = self.device();
        check_alive(device)?;
        Ok(CasterLoader { kernel: Kernel::with_host_text(device, desc, tier, &host)?, gaussians })
    }
}
