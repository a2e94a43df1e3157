//! A kernel with its resources and its work.
use crate::gpu::{Kernel, Resource, Resources};
use std::{
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Workgroups of a dispatch.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// Workgroups in x, y and z.
    Groups([u32; 3]),
    /// Three `u32` in a buffer at an offset \[bytes\].
    Indirect(wgpu::Buffer, u64),
}

impl From<[u32; 3]> for Work {
    fn from(groups: [u32; 3]) -> Self {
        Self::Groups(groups)
    }
}

impl Work {
    /// The workgroups that `counts` holds at `offset` \[bytes\] when the frame runs.
    pub fn indirect(counts: &wgpu::Buffer, offset: u64) -> Self {
        Self::Indirect(counts.clone(), offset)
    }
}

/// A bind group, and its resources by name.
#[derive(Debug)]
pub struct Bound {
    group: wgpu::BindGroup,
    resources: Vec<(&'static str, Resource)>,
}

/// A bind group of the host, group 1, which it may replace between frames. The former one is kept, since
/// hosts alternate between two. A clone is the same.
#[derive(Clone, Debug)]
pub struct HostBindings(Arc<Mutex<[wgpu::BindGroup; 2]>>);

impl HostBindings {
    /// The bindings of group 1.
    pub fn new(bindings: &wgpu::BindGroup) -> Self {
        Self(Arc::new(Mutex::new([bindings.clone(), bindings.clone()])))
    }

    fn last_two(&self) -> MutexGuard<'_, [wgpu::BindGroup; 2]> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Binds other resources of the same layout from the next recording on.
    pub fn replace(&self, bindings: &wgpu::BindGroup) {
        let mut known = self.last_two();
        if known[0] != *bindings {
            known.swap(0, 1);
            known[0] = bindings.clone();
        }
    }
}

/// A kernel with its resources and its work. A clone shares the bind group.
#[derive(Clone)]
pub struct Dispatch {
    /// The kernel.
    pub kernel: Kernel,
    /// Resources of group 0.
    pub bound: Arc<Bound>,
    /// Resources of the host, which its part of the kernel reads.
    pub host: Option<HostBindings>,
    /// The workgroups.
    pub work: Work,
}

impl Dispatch {
    /// `group`: bind group of the resources that the kernel declares, out of `resources`.
    pub fn new(
        kernel: Kernel,
        group: wgpu::BindGroup,
        resources: &Resources,
        work: impl Into<Work>,
    ) -> Self {
        let named = kernel
            .bindings()
            .iter()
            .filter_map(|binding| Some((binding.name, resources.get(binding.name)?.clone())));
        let bound = Arc::new(Bound { group, resources: named.collect() });
        Self { kernel, bound, host: None, work: work.into() }
    }

    /// The dispatch with a bind group of the host, for the text that the kernel was linked with.
    #[must_use]
    pub fn with_host(self, host: HostBindings) -> Self {
        Self { host: Some(host), ..self }
    }

    /// The same kernel and resources with other work.
    #[must_use]
    pub fn with_work(&self, work: impl Into<Work>) -> Self {
        Self { work: work.into(), ..self.clone() }
    }

    /// Whether the kernel takes a bind group of the host.
    pub fn takes(&self, bindings: &wgpu::BindGroup) -> bool {
        let known = self.host.as_ref().is_some_and(|host| host.last_two().contains(bindings));
        known || self.kernel.takes(&self.bound.group, bindings)
    }

    pub(super) fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        if let Some(host) = &self.host {
            pass.set_bind_group(1, &host.last_two()[0], &[]);
        }
        let Self { kernel, bound, .. } = self;
        match &self.work {
            Work::Groups(groups) => kernel.record(pass, &bound.group, *groups),
            Work::Indirect(counts, at) => kernel.record_indirect(pass, &bound.group, counts, *at),
        }
    }
}

impl Bound {
    /// Resources, by the names under which the kernel binds them.
    pub fn resources(&self) -> &[(&'static str, Resource)] {
        &self.resources
    }
}

/// `blur_rows [4, 4, 2]: filters, rows, views`.
impl fmt::Debug for Dispatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.kernel.name())?;
        match &self.work {
            Work::Groups(groups) => write!(f, " {groups:?}")?,
            Work::Indirect(_, offset) => write!(f, " by the counts at byte {offset}")?,
        }
        let names: Vec<_> = self.bound.resources.iter().map(|(name, _)| *name).collect();
        write!(f, ": {}", names.join(", "))
    }
}
