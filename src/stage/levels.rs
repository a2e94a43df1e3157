//! levels: prefiltered deep shadow maps for area lights (Lokovic and Veach 2000), made after the maps: ever
//! coarser blocks of texels, each with the mean light of its texels as a function of depth.
//!
//! In: the maps. Out: `levels`, records level by level (`src/records/area.rs`). `new_levels` takes one level
//! at a time and is copied, because a level is read while the next is made.
use crate::gpu::{Choice, KernelDesc};

/// Edge of a workgroup \[blocks\].
pub const GROUP_SIZE: u32 = 8;

const fn of(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    KernelDesc { name, with, ..KernelDesc::new("level_blocks", "levels/level_blocks.wgsl") }
}

/// Look-up for point lights only: area lights have no penumbrae.
pub const OF_POINT: Choice = Choice::new("source", "shade/receive.wgsl");
/// Look-up for scenes with area lights.
pub const OF_AREA: Choice = Choice::new("source", "shade/source_area.wgsl");

/// Makes the first level.
pub const FIRST: KernelDesc =
    of("level_of_maps", &[Choice::new("below", "levels/below_maps.wgsl"), OF_POINT]);
/// Makes every further level.
pub const NEXT: KernelDesc =
    of("level_of_levels", &[Choice::new("below", "levels/below_levels.wgsl"), OF_POINT]);

crate::records::gpu_struct! {
    /// WGSL: `wgsl/levels/level_blocks.wgsl`.
    #[derive(Eq)]
    pub struct LevelParams {
        pub level: u32,
        /// First block of the level, counted over all views.
        pub first_block: u32,
        pub pad_0: u32,
        pub pad_1: u32,
    }
}
