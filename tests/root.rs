//! One test binary: wgpu is linked once, helpers are shared.
mod sort;
mod common;
mod wgslcheck;
