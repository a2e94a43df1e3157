//! Devices and kernels as data.
mod adapter;
mod allocate;
mod cache;
mod context;
mod desc;
pub mod error;
mod host_part;
mod kernel;
mod kernel_error;
mod link;
#[cfg(feature = "device")]
mod open;
mod resource;
mod scope;
mod shelf;
mod support;
mod tier;
mod timing;
mod transfer;

pub use adapter::{Backend, FETCH_FEATURES, STORAGE_FORMATS, Selection, TierChoice, shortcoming};
pub use allocate::reused;
pub use allocate::{Allocator, Memory, array_view, level_view, view, write_records};
pub use cache::{KernelCache, KernelJob};
pub use context::{Gpu, unusable_adapter};
pub use desc::{Choice, KernelDesc, Specialised};
pub use host_part::bind_host_part;
pub use kernel::{HostText, Kernel};
pub use kernel_error::KernelError;
pub use link::{Constant, FEW_TURNS, Item, Library, LinkError, Linked, SAMPLED, UNROLLED, words};
#[cfg(any(target_arch = "wasm32", feature = "export"))]
pub use link::{ENABLED, for_browsers, printed};
#[cfg(feature = "device")]
pub use open::{adapters, all_adapters};
pub use resource::{Access, Binding, BindingKind, Resource, Resources};
pub use scope::{allocated, has_texture};
pub use shelf::Shelf;
pub use support::{Missing, Need, Requirement, Support};
pub(crate) use support::{check_alive, missing};
pub use tier::{RecordForm, Tier};
pub use timing::add_time;
pub use timing::{KernelTime, Profiler, Timeline, has_timestamps};
pub(crate) use transfer::{filled, read_back, staging};
