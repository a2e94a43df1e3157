//! The binary.
mod bench;
mod commands;
mod export;
mod hostile;
mod hostile_memory;
mod layers;
mod light;
mod manual;
mod moving;
mod outputs;
mod pack;
mod preview;
mod relight;
mod results;
mod sequence;
mod shared;
mod shares;
#[cfg(target_os = "linux")]
mod synced;
mod verify;
mod volumes;
