//! The reference: each stage again, plainly, on the CPU.
mod sort;

pub use sort::{Pair, sort};
