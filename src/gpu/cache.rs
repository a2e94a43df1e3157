//! Kernel cache of a device: each kernel is compiled once.
use super::{
    desc::{Choice, KernelDesc},
    kernel::Kernel,
    kernel_error::KernelError,
    link::Constant,
    tier::Tier,
};
use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
#[cfg(not(target_arch = "wasm32"))]
use std::{
    sync::{
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
    thread,
};

/// Kernels by device and source. A clone shares them: several renderers on one device compile each kernel
/// once.
#[derive(Clone, Debug, Default)]
pub struct KernelCache(Arc<Mutex<CacheState>>);

#[derive(Debug, Default)]
struct CacheState {
    kernels: HashMap<Key, Kernel>,
    /// Kernels that are not compiled yet.
    pending: Vec<Kernel>,
    driver: Option<wgpu::PipelineCache>,
    /// Channel to the thread of [`KernelCache::made_meanwhile`].
    #[cfg(not(target_arch = "wasm32"))]
    maker: Option<mpsc::Sender<Kernel>>,
}

/// Ends the thread of [`KernelCache::made_meanwhile`] after its last kernel, even on a panic.
#[cfg(not(target_arch = "wasm32"))]
struct Dismissed<'a>(&'a KernelCache);

#[cfg(not(target_arch = "wasm32"))]
impl Drop for Dismissed<'_> {
    fn drop(&mut self) {
        self.0.state().maker = None;
    }
}

/// Device, entry point and fingerprint of the source.
type Key = (wgpu::Device, &'static str, u64);

/// Compilation of a kernel that a frame needs. Any thread may run it.
#[derive(Clone, Debug)]
pub struct KernelJob(Kernel);

impl KernelJob {
    /// Label of the kernel.
    pub fn name(&self) -> &'static str {
        self.0.name()
    }

    /// Compiles the kernel; waits if another thread is compiling it.
    ///
    /// # Errors
    /// If the device refuses it.
    pub fn run(&self) -> Result<(), KernelError> {
        self.0.make()
    }
}

impl KernelCache {
    /// Like [`Kernel::new`], unless the kernel exists already.
    pub fn kernel(
        &self,
        device: &wgpu::Device,
        desc: &KernelDesc,
        tier: Tier,
        choices: &[Choice],
        constants: &[Constant],
    ) -> Result<Kernel, KernelError> {
        phase!("compile");
        let kernel = self.request(device, desc, tier, choices, constants)?;
        kernel.make().map(|()| kernel)
    }

    /// A kernel that can be bound at once; `finish` compiles it, or a job of [`Self::pending`].
    pub(crate) fn request(
        &self,
        device: &wgpu::Device,
        desc: &KernelDesc,
        tier: Tier,
        choices: &[Choice],
        constants: &[Constant],
    ) -> Result<Kernel, KernelError> {
        phase!("compile");
        let source = desc.specialised(tier, choices, constants)?;
        let state = &mut *self.state();
        match state.kernels.entry((device.clone(), desc.entry, source.fingerprint())) {
            Entry::Occupied(known) => Ok(known.get().clone()),
            Entry::Vacant(place) => {
                let kernel = Kernel::uncompiled(device, desc, source, state.driver.clone());
                state.pending.push(kernel.clone());
                #[cfg(not(target_arch = "wasm32"))]
                if let Some(maker) = &state.maker {
                    // A thread that has ended leaves it to `finish`.
                    let _ = maker.send(kernel.clone());
                }
                Ok(place.insert(kernel).clone())
            }
        }
    }

    /// Kernels that are not compiled yet. A kernel that the device refused stays, so that each `finish`
    /// reports it.
    pub fn pending(&self) -> Vec<KernelJob> {
        let mut state = self.state();
        state.pending.retain(|kernel| !kernel.is_made());
        state.pending.iter().cloned().map(KernelJob).collect()
    }

    /// Compiles all pending kernels on all cores, and waits for those that other threads compile.
    pub(crate) fn finish(&self) -> Result<(), KernelError> {
        phase!("compile");
        run_all(&self.pending())
    }

    /// Uses the driver's pipeline cache for kernels that are compiled later, and adds them to it.
    pub(crate) fn use_driver_cache(&self, cache: &wgpu::PipelineCache) {
        self.state().driver = Some(cache.clone());
    }

    /// Compiles kernels on a thread as they are requested, while `act` runs. The next `finish` returns their
    /// errors.
    pub fn made_meanwhile<T>(&self, act: impl FnOnce() -> T) -> T {
        #[cfg(not(target_arch = "wasm32"))]
        return thread::scope(|scope| {
            let (sender, requested) = mpsc::channel::<Kernel>();
            let make = || requested.into_iter().for_each(|kernel| drop(kernel.make()));
            // If no thread can be spawned, the kernels are compiled later.
            let spawned = thread::Builder::new().spawn_scoped(scope, make);
            self.state().maker = spawned.is_ok().then_some(sender);
            let _dismissed = Dismissed(self);
            act()
        });
        #[cfg(target_arch = "wasm32")]
        act()
    }

    /// Number of kernels.
    pub fn count(&self) -> usize {
        self.state().kernels.len()
    }

    fn state(&self) -> MutexGuard<'_, CacheState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Runs all jobs; returns the first error after all have ended.
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
        // If no thread can be spawned, this one runs all jobs.
        let others: Vec<_> = (1..jobs.len().min(cores))
            .filter_map(|_| thread::Builder::new().spawn_scoped(scope, work).ok())
            .collect();
        let first = work();
        others.into_iter().fold(first, |first, other| {
            first.and(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        })
    })
}

/// Runs jobs up to the first error. A browser's device stays on its thread.
#[cfg(target_arch = "wasm32")]
fn run_all(jobs: &[KernelJob]) -> Result<(), KernelError> {
    jobs.iter().try_for_each(KernelJob::run)
}
