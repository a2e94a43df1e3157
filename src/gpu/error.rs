//! Errors of the library, except those of scene files (see [`crate::scene`]).
use crate::{
    gpu::{Missing, Tier},
    model::{InvalidClip, InvalidLight},
};

/// Error of opening a device or rendering a frame.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    #[error("no usable GPU adapter{}{}: {}", named(.wanted), listed(.found), remedy(.found))]
    Adapter { wanted: Option<String>, found: Vec<String> },
    /// Adapters, each with what it lacks.
    #[error("no usable GPU adapter: {}; {}", .0.join("; "), remedy(&[]))]
    Unusable(Vec<String>),
    /// Feature that an adapter lacks for the kernels.
    #[error("it lacks {0}")]
    Lacks(String),
    #[error("the adapter {adapter} gave no device: {source}")]
    Device { adapter: String, source: wgpu::RequestDeviceError },
    #[error("the device limit {limit} is {have}, but {need} is needed; {remedy}")]
    Limit { limit: &'static str, have: u64, need: u64, remedy: &'static str },
    /// A device that was opened without required features or limits.
    #[error("the device cannot run the {tier} tier: {}; open it with `ShadowSettings::features` and \
             `ShadowSettings::limits`", joined(.missing))]
    Unsupported { tier: Tier, missing: Vec<Missing> },
    #[error(transparent)]
    Light(#[from] InvalidLight),
    #[error(transparent)]
    Clip(#[from] InvalidClip),
    #[error(transparent)]
    Kernel(#[from] crate::gpu::KernelError),
    /// An input that does not keep the contract of its fields; `index` among those of its kind, 0 of a single one.
    #[error("{what} {index} cannot be used: {problem}")]
    Invalid { what: Input, index: usize, problem: &'static str },
    #[error("a later `prepare` has taken these maps over; use what it returned")]
    Superseded,
    #[error("the device refused a command: {0}")]
    Refused(String),
    #[error("the device has no memory left: {0}; use a smaller shadow size")]
    Memory(String),
    #[error("the device stopped answering: {0}")]
    Lost(String),
}

/// Kind of an input that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Input {
    #[error("particle")]
    Particle,
    #[error("triangle")]
    Triangle,
    #[error("material")]
    Material,
    #[error("texture")]
    Texture,
    #[error("light")]
    Light,
    #[error("view")]
    View,
    #[error("setting")]
    Setting,
    #[error("set of host casters")]
    HostCasters,
    #[error("depth map of the host's")]
    HostDepth,
    #[error("map layout")]
    MapLayout,
    #[error("prefix")]
    Prefix,
    #[error("point")]
    Point,
    #[error("view of masks")]
    MaskView,
    #[error("mask setting")]
    MaskSetting,
    #[error("emitter")]
    Emitter,
    #[error("frame to be exported")]
    Frame,
}

impl Input {
    /// The error of the input `index` of this kind.
    pub(crate) fn invalid(self, index: usize, problem: &'static str) -> Error {
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
