//! The reference: each stage again, plainly, on the CPU.
<<<<<<< HEAD
pub mod hit;
pub mod project;
=======
mod sort;

pub use sort::{Pair, sort};
>>>>>>> sort
