//! The binary.
mod bench;
mod commands;
mod export;
mod hostile;
mod light;
mod manual;
mod moving;
mod preview;
mod results;
mod sequence;
mod shared;
mod verify;
