//! A frame as data: `prepare` makes a list of [`Command`]s, [`Commands::record`] records it.
//!
//! A stage requests from [`Kernels`] a [`Dispatch`] of one of the descriptions in [`stage`](crate::stage),
//! with the features of the frame and resources by name, and adds a pass of them to the list. Nothing is
//! bound, chosen or allocated while recording.
mod commands;
mod dispatch;
mod kernels;
mod sort;
mod waits;

pub use commands::{Command, Commands};
pub use dispatch::{Bound, Dispatch, HostBindings, Work};
pub use kernels::Kernels;
pub use sort::{Sort, SortCount};
