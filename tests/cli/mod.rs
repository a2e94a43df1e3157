//! The binary.
mod bench;
mod commands;
mod export;
