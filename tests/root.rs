//! One test binary: wgpu is linked once, helpers are shared.
mod bin;
mod brute_force;
mod closed_forms;
mod common;
mod properties;
mod sort;
mod wgslcheck;
