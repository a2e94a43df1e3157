//! One test binary: wgpu is linked once, helpers are shared.
mod cli;
mod common;
mod contract;
mod docs;
mod maps;
mod picture;
mod scene;
mod stages;
