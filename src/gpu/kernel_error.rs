//! Errors of kernels.
use super::link::LinkError;

/// Error of compiling or binding a kernel.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KernelError {
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error("the device refused the kernel {kernel}: {message}")]
    Refused { kernel: &'static str, message: String },
    #[error("the kernel {kernel} was made for another device: make it on this one")]
    OtherDevice { kernel: &'static str },
    #[error("the kernel {kernel} needs {resource}, which was not given")]
    Missing { kernel: &'static str, resource: &'static str },
    #[error("the kernel {kernel} binds {resource} as {wanted}, which {given} is not")]
    Mistyped { kernel: &'static str, resource: &'static str, wanted: String, given: String },
}
