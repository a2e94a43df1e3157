//! The reference: each stage again, plainly, on the CPU.
pub mod hit;
pub mod project;
