//! Errors of the library, apart from scene files (see [`crate::scene`]).

/// Why a device or a frame could not be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    #[error(
        "no usable GPU adapter{}: install a Vulkan driver (mesa-vulkan-drivers is enough) or use \
         --backend cpu",
        .wanted.as_ref().map(|w| format!(" named {w:?}")).unwrap_or_default()
    )]
    Adapter { wanted: Option<String>, found: Vec<String> },
    #[error("the adapter {adapter} gave no device: {source}; try --backend cpu")]
    Device { adapter: String, source: wgpu::RequestDeviceError },
    #[error("the device limit {limit} is {have}, but {need} is needed; {remedy}")]
    Limit { limit: &'static str, have: u64, need: u64, remedy: &'static str },
    #[error("the device stopped answering: {0}")]
    Lost(String),
}
