//! A device with its kernels and properties.
use super::{cache::KernelCache, tier::Tier};
use crate::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

/// An open device with its kernels and properties. A clone is the same device, with the same kernels.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The open device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Cache of compiled kernels.
    pub kernels: KernelCache,
    /// Name and kind of the adapter.
    pub adapter: wgpu::AdapterInfo,
    /// Tier of its kernels.
    pub tier: Tier,
    /// Reason for the tier: `native: TEXTURE_ATOMIC, SUBGROUP`.
    pub tier_reason: String,
    /// First error outside a call that could return it; later ones follow from it.
    pub(super) failure: Arc<Mutex<Option<Error>>>,
}

impl Gpu {
    /// Whether the device was opened with all of `features`.
    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    /// The first asynchronous error of the device since the last call.
    pub fn check(&self) -> Result<(), Error> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map_or(Ok(()), Err)
    }
}

/// An adapter and its lack, in the format of [`Error::Unusable`].
pub fn unusable_adapter(info: &wgpu::AdapterInfo, lack: &Error) -> String {
    format!("{} ({}): {lack}", info.name, info.backend)
}
