//! Kernels of a device, each made once.
use super::kernel::{Choice, Constant, Kernel, KernelDesc, KernelError, Tier};
use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
#[cfg(not(target_arch = "wasm32"))]
use std::{
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

/// Kernels by their device, source and constants. A clone shares them: whoever renders on the same
/// device need not make them again.
#[derive(Clone, Debug, Default)]
pub struct KernelCache(Arc<Mutex<Shelf>>);

#[derive(Debug, Default)]
struct Shelf {
    kernels: HashMap<Key, Kernel>,
    /// Not all made yet.
    pending: Vec<Kernel>,
    driver: Option<wgpu::PipelineCache>,
}

/// Device, entry point, the whole source, and its overrides with the bits of their values.
type Key = (wgpu::Device, &'static str, String, Vec<(&'static str, u64)>);

/// A kernel that a frame needs and that is not made yet. Any thread may run it.
#[derive(Clone, Debug)]
pub struct KernelJob(Kernel);

impl KernelJob {
    /// Label of the kernel.
    pub fn name(&self) -> &'static str {
        self.0.name()
    }

    /// Makes the kernel, unless another thread has: then it waits for that.
    ///
    /// # Errors
    /// Where the device refuses it.
    pub fn run(&self) -> Result<(), KernelError> {
        self.0.make()
    }
}

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
        let kernel = self.plan(device, desc, tier, choices, constants)?;
        kernel.make().map(|()| kernel)
    }

    /// What can be bound, and is made by [`Self::finish`] or by those who run [`Self::pending`].
    pub(crate) fn plan(
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
        let Shelf { kernels, pending, driver } = &mut *self.shelf();
        match kernels.entry((device.clone(), desc.entry, linked.wgsl.clone(), bits)) {
            Entry::Occupied(known) => Ok(known.get().clone()),
            Entry::Vacant(place) => {
                let kernel = Kernel::planned(device, desc, linked, values, driver.clone())?;
                pending.push(kernel.clone());
                Ok(place.insert(kernel).clone())
            }
        }
    }

    /// What is not made yet. One that the device refused stays, so that each [`Self::finish`] says so.
    pub(crate) fn pending(&self) -> Vec<KernelJob> {
        let mut shelf = self.shelf();
        shelf.pending.retain(|kernel| !kernel.is_made());
        shelf.pending.iter().cloned().map(KernelJob).collect()
    }

    /// Makes what is not made yet, on all cores, and waits for what others make.
    pub(crate) fn finish(&self) -> Result<(), KernelError> {
        run_all(&self.pending())
    }

    /// Kernels that are made from here on take from the driver's cache what it has, and leave it what
    /// it has not.
    pub(crate) fn use_driver_cache(&self, cache: &wgpu::PipelineCache) {
        self.shelf().driver = Some(cache.clone());
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.shelf().kernels.len()
    }

    fn shelf(&self) -> MutexGuard<'_, Shelf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The first error, if any, once all have ended.
#[cfg(not(target_arch = "wasm32"))]
fn run_all(jobs: &[KernelJob]) -> Result<(), KernelError> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut first = Ok(());
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            first = first.and(job.run());
        }
        first
    };
    let cores = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        // Where no thread can be had, this one does all.
        let others: Vec<_> = (1..jobs.len().min(cores))
            .filter_map(|_| thread::Builder::new().spawn_scoped(scope, work).ok())
            .collect();
        let first = work();
        others.into_iter().fold(first, |first, other| {
            first.and(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        })
    })
}

/// Up to the first error. A browser's device stays on its thread.
#[cfg(target_arch = "wasm32")]
fn run_all(jobs: &[KernelJob]) -> Result<(), KernelError> {
    jobs.iter().try_for_each(KernelJob::run)
}

/// Runs jobs on a thread while `act` runs. Their errors are those of the next
/// [`KernelCache::finish`].
#[cfg(feature = "picture")]
pub(crate) fn while_made<T>(jobs: &[KernelJob], act: impl FnOnce() -> T) -> T {
    #[cfg(not(target_arch = "wasm32"))]
    return thread::scope(|scope| {
        let make = || jobs.iter().for_each(|job| drop(job.run()));
        // Without a thread they are made later.
        let _made = thread::Builder::new().spawn_scoped(scope, make);
        act()
    });
    #[cfg(target_arch = "wasm32")]
    {
        let _ = jobs;
        act()
    }
}
