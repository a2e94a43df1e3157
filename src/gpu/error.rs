//! Errors of the library, except those of scene files (`gobo_scene::SceneError`).
use crate::{
    gpu::{Missing, Tier},
    model::{InvalidClip, InvalidLight},
};

/// Error of opening a device or rendering a frame.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No adapter, or none of the wanted name.
    #[error("no usable GPU adapter{}{}: {}", named(.wanted), listed(.found), remedy(.found))]
    Adapter {
        /// Requested part of the name.
        wanted: Option<String>,
        /// Names of the available adapters.
        found: Vec<String>,
    },
    /// Adapters, each with its lack.
    #[error("no usable GPU adapter: {}; {}", .0.join("; "), remedy(&[]))]
    Unusable(Vec<String>),
    /// Feature that an adapter lacks for the kernels.
    #[error("it lacks {0}")]
    Lacks(String),
    /// An adapter does not open.
    #[error("the adapter {adapter} gave no device: {source}")]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// wgpu's error.
        source: wgpu::RequestDeviceError,
    },
    /// A requirement exceeds a limit of the device or the library.
    #[error("the device limit {limit} is {have}, but {need} is needed; {remedy}")]
    Limit {
        /// Name of the limit: wgpu's if it is the device's.
        limit: &'static str,
        /// The limit.
        have: u64,
        /// The required value.
        need: u64,
        /// Remedy, for a reader.
        remedy: &'static str,
    },
    /// A device that was opened without required features or limits.
    #[error("the device cannot run the {tier} tier: {}; open it with `ShadowSettings::features` and \
             `ShadowSettings::limits`", joined(.missing))]
    Unsupported {
        /// Tier that was to run on it.
        tier: Tier,
        /// All that it lacks.
        missing: Vec<Missing>,
    },
    /// A light breaks the contract of its fields.
    #[error(transparent)]
    Light(#[from] InvalidLight),
    /// A matrix is not a shadow camera's.
    #[error(transparent)]
    Clip(#[from] InvalidClip),
    /// A kernel cannot be compiled or bound.
    #[error(transparent)]
    Kernel(#[from] crate::gpu::KernelError),
    /// Another input breaks the contract of its fields.
    #[error("{what} {index} cannot be used: {problem}")]
    Invalid {
        /// Kind of the input.
        what: Input,
        /// Index among the inputs of its kind; 0 for a single one.
        index: usize,
        /// Reason, for a reader.
        problem: &'static str,
    },
    /// [`Prepared`](crate::Prepared) maps that a later `prepare` has taken over.
    #[error("a later `prepare` has taken these maps over; use what it returned")]
    Superseded,
    /// Validation error of the device outside a call that could return it.
    #[error("the device refused a command: {0}")]
    Refused(String),
    /// The device is out of memory.
    #[error("the device has no memory left: {0}; use a smaller shadow size")]
    Memory(String),
    /// The device is lost.
    #[error("the device stopped answering: {0}")]
    Lost(String),
    /// The host ended long work before it was done.
    #[error("stopped before it was done")]
    Stopped,
}

impl Error {
    /// An error if the needed value exceeds a limit.
    pub fn check_limit(
        limit: &'static str,
        have: u64,
        need: u64,
        remedy: &'static str,
    ) -> Result<(), Self> {
        if need > have { Err(Self::Limit { limit, have, need, remedy }) } else { Ok(()) }
    }
}

/// Kind of an input that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Input {
    /// A particle of [`Casters`](crate::Casters).
    #[error("particle")]
    Particle,
    /// A Gaussian of [`Casters`](crate::Casters).
    #[error("Gaussian")]
    Gaussian,
    /// A triangle of [`Casters`](crate::Casters).
    #[error("triangle")]
    Triangle,
    /// A strand of [`Casters`](crate::Casters).
    #[error("strand")]
    Strand,
    /// A grid of [`Casters`](crate::Casters).
    #[error("grid")]
    Grid,
    /// A material of [`Casters`](crate::Casters).
    #[error("material")]
    Material,
    /// A texture of [`Casters`](crate::Casters).
    #[error("texture")]
    Texture,
    /// A light that is not among those of the views.
    #[error("light")]
    Light,
    /// A [`View`](crate::View).
    #[error("view")]
    View,
    /// [`ShadowSettings`](crate::ShadowSettings).
    #[error("setting")]
    Setting,
    /// [`HostCasters`](crate::HostCasters).
    #[error("set of host casters")]
    HostCasters,
    /// A [`HostDepth`](crate::HostDepth).
    #[error("depth map of the host's")]
    HostDepth,
    /// [`HostGrid`](crate::HostGrid).
    #[error("host grid")]
    HostGrid,
    /// A [`MapLayout`](crate::host::MapLayout); the index is of a view.
    #[error("map layout")]
    MapLayout,
    /// The prefix of [`Maps::wgsl`](crate::Maps::wgsl).
    #[error("prefix")]
    Prefix,
    /// A point of [`PointBuffers`](crate::host::PointBuffers).
    #[error("point")]
    Point,
    /// A [`MaskView`](crate::host::MaskView).
    #[error("view of masks")]
    MaskView,
    /// [`MaskSettings`](crate::model::MaskSettings).
    #[error("mask setting")]
    MaskSetting,
    /// An emitter, for a [`Simulation`](crate::host::Simulation).
    #[error("emitter")]
    Emitter,
    /// A frame that `gobo export` cannot write.
    #[error("frame to be exported")]
    Frame,
}

impl Input {
    /// The error of the input `index` of this kind.
    pub fn invalid(self, index: usize, problem: &'static str) -> Error {
        Error::Invalid { what: self, index, problem }
    }
}

fn joined(missing: &[Missing]) -> String {
    missing.iter().map(Missing::to_string).collect::<Vec<_>>().join("; ")
}

fn named(wanted: &Option<String>) -> String {
    wanted.as_ref().map(|name| format!(" named {name:?}")).unwrap_or_default()
}

fn listed(found: &[String]) -> String {
    if found.is_empty() { String::new() } else { format!(" among {}", found.join(", ")) }
}

fn remedy(found: &[String]) -> &'static str {
    if found.is_empty() {
        "install a driver (for Vulkan, mesa-vulkan-drivers is enough)"
    } else {
        "choose one of these"
    }
}
