//! Contracts of all kernels, devices and recorded frames.
mod circles;
mod device;
mod dynamic_index;
mod face;
mod fuzzed;
mod grammar;
mod layers;
mod layout;
mod mirrors;
mod recording;
mod shaders;
mod slow;
mod sources;
mod specialised;
mod support;
mod uniform_branches;
mod words;
