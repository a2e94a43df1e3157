//! The binary.
mod bench;
mod commands;
mod export;
mod hostile;
mod light;
mod moving;
mod results;
mod sequence;
