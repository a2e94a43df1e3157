//! Opens a device, for hosts that have none: the program, tests and benches.
use super::{
    Gpu, KernelCache,
    adapter::{Backend, Selection, TierChoice, shortcoming},
    context::unusable_adapter,
};
use crate::error::Error;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{Backends, DeviceType, InstanceFlags};

impl Gpu {
    /// Opens the best adapter on its best tier.
    pub fn headless() -> Result<Self, Error> {
        Self::new(&Selection::default())
    }

    /// Opens the first fitting adapter that gives a device.
    pub fn new(selection: &Selection) -> Result<Self, Error> {
        phase!("device");
        let mut refused = None;
        let mut unusable = Vec::new();
        for adapter in adapters(selection) {
            if let Some(lack) = shortcoming(&adapter) {
                unusable.push(unusable_adapter(&adapter.get_info(), &lack));
                continue;
            }
            match Self::open(&adapter, selection) {
                Ok(gpu) => return Ok(gpu),
                Err(error) => {
                    tracing::warn!("{}: {error}", adapter.get_info().name);
                    refused.get_or_insert(error);
                }
            }
        }
        if !unusable.is_empty() {
            refused.get_or_insert(Error::Unusable(unusable));
        }
        Err(refused.unwrap_or_else(|| {
            let wanted = selection.adapter.clone();
            let any_name = Selection { adapter: None, ..selection.clone() };
            let found = match wanted {
                Some(_) => adapters(&any_name).iter().map(|a| a.get_info().name).collect(),
                None => Vec::new(),
            };
            Error::Adapter { wanted, found }
        }))
    }

    /// A device of `adapter`, on a tier that the selection allows.
    pub fn open(adapter: &wgpu::Adapter, selection: &Selection) -> Result<Self, Error> {
        let info = adapter.get_info();
        let choice = TierChoice::new(selection, adapter);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("gobo"),
            required_features: choice.features,
            required_limits: choice.limits,
            ..Default::default()
        }))
        .map_err(|source| Error::Device { adapter: info.name.clone(), source })?;

        let failure = Arc::new(Mutex::new(None));
        let noticed = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            note(
                &noticed,
                match error {
                    wgpu::Error::OutOfMemory { source } => Error::Memory(source.to_string()),
                    other => Error::Refused(other.to_string()),
                },
            );
        }));
        let noticed = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, message| {
            // The device is also reported as lost when its owner drops it.
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(&noticed, Error::Lost(message));
            }
        });
        Ok(Self {
            device,
            queue,
            kernels: KernelCache::default(),
            adapter: info,
            tier: choice.tier,
            tier_reason: choice.reason,
            failure,
        })
    }
}

fn note(place: &Mutex<Option<Error>>, failure: Error) {
    place.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(failure);
}

/// Every matching adapter, best first.
pub fn adapters(selection: &Selection) -> Vec<wgpu::Adapter> {
    let wanted = selection.adapter.as_ref().map(|name| name.to_lowercase());
    let found = |backends: Backends| {
        let mut found = enumerate(backends);
        found.retain(|adapter| {
            let name = adapter.get_info().name.to_lowercase();
            wanted.as_ref().is_none_or(|wanted| name.contains(wanted))
        });
        found
    };
    let mut adapters = match selection.backend {
        Backend::Auto => {
            let mut adapters = found(FIRST_BACKENDS);
            // Opening GL is slow and noisy without a display, so GL is tried only when needed.
            if adapters.iter().all(|adapter| shortcoming(adapter).is_some()) {
                adapters.extend(found(Backends::GL));
            }
            adapters
        }
        Backend::Vulkan => found(Backends::VULKAN),
        Backend::Metal => found(Backends::METAL),
        Backend::Dx12 => found(Backends::DX12),
        Backend::Gl => found(Backends::GL),
        Backend::Cpu => Vec::new(),
    };
    adapters.sort_by_key(rank);
    adapters
}

/// Every adapter of every backend, in the order of [`adapters`].
pub fn all_adapters() -> Vec<wgpu::Adapter> {
    let mut adapters = enumerate(FIRST_BACKENDS | Backends::GL);
    adapters.sort_by_key(rank);
    adapters
}

const FIRST_BACKENDS: Backends = Backends::VULKAN.union(Backends::METAL).union(Backends::DX12);

/// Adapters that have WebGPU's limits first, GL last, real GPUs before software.
fn rank(adapter: &wgpu::Adapter) -> (bool, bool, u8) {
    let info = adapter.get_info();
    let class = match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (shortcoming(adapter).is_some(), info.backend == wgpu::Backend::Gl, class)
}

/// On DX12 wgpu's check of an indirect dispatch also hands its counts to the kernel. Elsewhere it is a
/// dispatch before each of ours, whose counts come from our own kernels.
fn enumerate(backends: Backends) -> Vec<wgpu::Adapter> {
    let checked = backends & Backends::DX12;
    [
        (backends - checked, InstanceFlags::empty()),
        (checked, InstanceFlags::VALIDATION_INDIRECT_CALL),
    ]
    .into_iter()
    .filter(|(backends, _)| !backends.is_empty())
    .flat_map(|(backends, check)| {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        descriptor.flags.remove(InstanceFlags::VALIDATION_INDIRECT_CALL);
        descriptor.flags = (descriptor.flags | check).with_env();
        pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends))
    })
    .collect()
}
