//! Compilation of kernels before a frame needs them.
use super::{HostInputs, Shadows};
use crate::{
    error::Error,
    gpu::KernelJob,
    model::{Casters, ShadowSettings, View},
};

impl Shadows {
    /// The kernels that [`Self::prepare_with`] with the same arguments would compile before it returns, in
    /// this frame and later ones, as jobs for the host's threads. Uploads the casters like `prepare_with`,
    /// which then finds them.
    ///
    /// A software adapter compiles a kernel again when it first runs: there, also record and submit a frame
    /// before the first one that matters.
    ///
    /// # Errors
    /// Those of [`Self::prepare_with`].
    pub fn pending(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
        inputs: &HostInputs<'_>,
    ) -> Result<Vec<KernelJob>, Error> {
        // New maps are cleared without a kernel, those of an earlier frame with one.
        for _ in 0..2 {
            self.prepare_uncompiled(casters, views, settings, inputs)?;
        }
        Ok(self.kernels().cache().pending())
    }

    /// Whether all pending kernels are compiled: `prepare` with the arguments of [`Self::pending`] then
    /// compiles none.
    pub fn is_ready(&self) -> bool {
        self.kernels().cache().pending().is_empty()
    }

    /// Uses a driver's pipeline cache for kernels that are compiled later, and adds them to it. The device
    /// needs `PIPELINE_CACHE`; the host stores the cache.
    pub fn use_pipeline_cache(&mut self, cache: &wgpu::PipelineCache) {
        self.kernels().cache().use_driver_cache(cache);
    }
}
