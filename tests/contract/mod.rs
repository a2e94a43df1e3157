//! What every kernel, device and recorded frame must keep.
mod device;
mod face;
mod grammar;
mod layers;
mod layout;
mod mirrors;
mod recording;
mod shaders;
mod support;
mod uniform_branches;
