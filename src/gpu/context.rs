//! A device with what is known of it.
use super::{cache::KernelCache, kernel::Tier};
use crate::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

/// An open device, and what is known of it. A clone is the same device, with the same kernels.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Those that are made.
    pub kernels: KernelCache,
    pub adapter: wgpu::AdapterInfo,
    pub tier: Tier,
    /// Why this tier: `native: SUBGROUP, TEXTURE_ATOMIC`.
    pub tier_reason: String,
    /// What went wrong outside a call that could return it. The first one counts: later ones follow
    /// from it.
    pub(super) failure: Arc<Mutex<Option<Error>>>,
}

impl Gpu {
    /// Whether the device was opened with all of `features`.
    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    /// The first error that the device reported by itself since the last call.
    pub fn check(&self) -> Result<(), Error> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map_or(Ok(()), Err)
    }
}

/// An adapter and what it lacks, as [`Error::Unusable`] lists them.
pub fn unusable_adapter(info: &wgpu::AdapterInfo, lack: &Error) -> String {
    format!("{} ({}): {lack}", info.name, info.backend)
}
