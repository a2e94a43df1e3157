//! The reference: each stage again, plainly, on the CPU.
pub mod hit;
pub mod project;
mod sort;

pub use sort::{Pair, sort};
