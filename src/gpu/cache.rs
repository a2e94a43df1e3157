//! Kernels of a device, each made once.
use super::kernel::{Choice, Constant, Kernel, KernelDesc, KernelError, Tier};
use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Mutex, PoisonError},
};

/// Kernels by their device, source and constants. A clone shares them: whoever renders on the same
/// device need not make them again.
#[derive(Clone, Debug, Default)]
pub struct KernelCache(Arc<Mutex<HashMap<Key, Kernel>>>);

/// Device, entry point, the whole source, and its overrides with the bits of their values.
type Key = (wgpu::Device, &'static str, String, Vec<(&'static str, u64)>);

impl KernelCache {
    /// As [`Kernel::new`], unless it is made already.
    pub fn kernel(
        &self,
        device: &wgpu::Device,
        desc: &KernelDesc,
        tier: Tier,
        choices: &[Choice],
        constants: &[Constant],
    ) -> Result<Kernel, KernelError> {
        let linked = desc.link_with(tier, choices)?;
        let values = desc.values(&linked, constants);
        let bits = values.iter().map(|&(name, value)| (name, value.to_bits())).collect();
        let mut made = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match made.entry((device.clone(), desc.entry, linked.wgsl.clone(), bits)) {
            Entry::Occupied(known) => Ok(known.get().clone()),
            Entry::Vacant(place) => {
                Ok(place.insert(Kernel::of(device, desc, &linked, &values)?).clone())
            }
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }
}
