//! The reference: each stage again, plainly, on the CPU.
