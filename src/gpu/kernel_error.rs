//! Errors of kernels.
use super::link::LinkError;

/// Error of compiling or binding a kernel.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KernelError {
    /// WGSL that cannot be linked.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The device cannot compile or bind a kernel.
    #[error("the device refused the kernel {kernel}: {message}")]
    Refused {
        /// Label of the kernel.
        kernel: &'static str,
        /// The device's message, with file and line.
        message: String,
    },
    /// A kernel of one device is used on another.
    #[error("the kernel {kernel} was made for another device: make it on this one")]
    OtherDevice {
        /// Label of the kernel.
        kernel: &'static str,
    },
    /// A host's layout belongs to another device.
    #[error("the kernel {kernel} was given a bind group layout of another device")]
    OtherLayout {
        /// Label of the kernel.
        kernel: &'static str,
    },
    /// A resource that a kernel declares is missing.
    #[error("the kernel {kernel} needs {resource}, which was not given")]
    Missing {
        /// Label of the kernel.
        kernel: &'static str,
        /// Name that the kernel declares.
        resource: &'static str,
    },
    /// A resource has another type than the kernel declares.
    #[error("the kernel {kernel} binds {resource} as {wanted}, which {given} is not")]
    Mistyped {
        /// Label of the kernel.
        kernel: &'static str,
        /// Name that the kernel declares.
        resource: &'static str,
        /// Its declared type.
        wanted: String,
        /// The given resource.
        given: String,
    },
}
