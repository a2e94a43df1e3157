//! One test binary: wgpu is linked once, helpers are shared.
mod cli;
mod common;
mod device;
mod layout;
mod shaders;
mod sort;
