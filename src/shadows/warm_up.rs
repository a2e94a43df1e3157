//! Kernels made before a frame asks for them.
use super::{HostInputs, Shadows};
use crate::{
    error::Error,
    gpu::KernelJob,
    model::{Casters, ShadowSettings, View},
};

impl Shadows {
    /// The kernels that [`Self::prepare_with`] of the same arguments would make before it returns, now
    /// and in later frames, as jobs for the threads that the host has. Uploads the casters as `prepare_with` does, so that it
    /// finds them.
    ///
    /// A software adapter compiles a kernel again when it first runs: there, record and submit a
    /// frame as well before the first that counts.
    ///
    /// # Errors
    /// As [`Self::prepare_with`].
    pub fn pending(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
        inputs: &HostInputs<'_>,
    ) -> Result<Vec<KernelJob>, Error> {
        // Maps that are new are cleared without a kernel, those of a frame before are not.
        for _ in 0..2 {
            self.plan(casters, views, settings, inputs)?;
        }
        Ok(self.kernels().pending())
    }

    /// Whether all kernels that were asked for are made: `prepare` of what [`Self::pending`] was asked
    /// about then makes none.
    pub fn is_ready(&self) -> bool {
        self.kernels().pending().is_empty()
    }

    /// Kernels that are made from here on come out of the driver's cache where it has them, and go into
    /// it where not. The device needs `PIPELINE_CACHE`; what the cache holds is the host's to keep.
    pub fn use_pipeline_cache(&mut self, cache: &wgpu::PipelineCache) {
        self.kernels().use_driver_cache(cache);
    }
}
