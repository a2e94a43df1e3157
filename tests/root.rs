//! One test binary: wgpu is linked once, helpers are shared.
mod bench;
mod bin;
mod brute_force;
mod cli;
mod closed_forms;
mod common;
mod device;
mod gltf;
mod hostile;
mod layout;
mod particles;
mod picture;
mod pipeline;
mod properties;
mod scene;
mod shaders;
mod sort;
