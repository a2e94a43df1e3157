//! A device for tests, benches and the CLI. Hosts with a renderer pass their own.
use super::{
    adapter::{Selection, TierChoice, adapters, shortcoming},
    kernel::Tier,
};
use crate::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

/// An open device, and what is known of it.
#[derive(Debug)]
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: wgpu::AdapterInfo,
    pub tier: Tier,
    /// Why this tier: `native: SUBGROUP, TEXTURE_ATOMIC`.
    pub tier_reason: String,
    failure: Arc<Mutex<Option<Failure>>>,
}

/// What went wrong on the device outside a call that could return it. The first one counts: later
/// ones follow from it.
#[derive(Debug)]
enum Failure {
    Refused(String),
    Memory(String),
    Lost(String),
}

impl Gpu {
    /// The best adapter on its best tier.
    pub fn headless() -> Result<Self, Error> {
        Self::new(&Selection::default())
    }

    /// Opens the first adapter that fits and gives a device.
    pub fn new(selection: &Selection) -> Result<Self, Error> {
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

    fn open(adapter: &wgpu::Adapter, selection: &Selection) -> Result<Self, Error> {
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
                    wgpu::Error::OutOfMemory { source } => Failure::Memory(source.to_string()),
                    other => Failure::Refused(other.to_string()),
                },
            );
        }));
        let noticed = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, message| {
            // The device is also reported as lost when its owner drops it.
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(&noticed, Failure::Lost(message));
            }
        });
        Ok(Self {
            device,
            queue,
            adapter: info,
            tier: choice.tier,
            tier_reason: choice.reason,
            failure,
        })
    }

    /// Whether the device was opened with all of `features`.
    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    /// The first error that the device reported by itself since the last call.
    pub fn check(&self) -> Result<(), Error> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).take() {
            None => Ok(()),
            Some(Failure::Refused(message)) => Err(Error::Refused(message)),
            Some(Failure::Memory(message)) => Err(Error::Memory(message)),
            Some(Failure::Lost(message)) => Err(Error::Lost(message)),
        }
    }
}

/// An adapter and what it lacks, as [`Error::Unusable`] lists them.
pub fn unusable_adapter(info: &wgpu::AdapterInfo, lack: &Error) -> String {
    format!("{} ({}): {lack}", info.name, info.backend)
}

fn note(place: &Mutex<Option<Failure>>, failure: Failure) {
    place.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(failure);
}
