//! One test binary: wgpu is linked once, helpers are shared.
mod bin;
mod brute_force;
mod cli;
mod closed_forms;
mod common;
mod device;
mod gltf;
mod layout;
mod particles;
mod pipeline;
mod properties;
mod shade;
mod shaders;
mod sort;
