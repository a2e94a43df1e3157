//! Devices and kernels as data.
mod layout;
pub use layout::{Field, GpuLayout, size_of_field};
