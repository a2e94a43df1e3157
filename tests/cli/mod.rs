//! The binary.
mod bench;
mod commands;
mod export;
mod hostile;
mod hostile_memory;
mod info;
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
#[cfg(unix)]
mod signals;
#[cfg(target_os = "linux")]
mod synced;
mod verify;
mod volumes;
mod wall_clock;
