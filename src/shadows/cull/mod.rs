//! cull: frustum and occlusion culling of groups of casters per view, on the CPU.
//!
//! 1. Neighbouring casters form a *group*: at most a chunk of `project`'s, with a box around everything that
//!    they can reach ([`order`]).
//! 2. A tree over the boxes is built once, refitted when groups move and rebuilt when it has degraded
//!    ([`GroupTree`]).
//! 3. Each view traverses the tree once with its six planes ([`Frustum`]).
//! 4. Visible groups wholly behind one large opaque surface are culled, where that changes no bit of a map
//!    ([`Occluders`]).
//!
//! Culling is conservative: planes and boxes are widened by the enlargement and the rounding of `project`.
//! The range of a spot or point light is its far *plane*, not a sphere: light depth is measured along the
//! view's axis, so the corners of a view reach farther than `far`.
pub mod frustum;
mod occluders;
pub mod order;
mod tile_load;
mod tree;

pub use frustum::{Frustum, widened};
pub use occluders::{MAX_OCCLUDERS, OccluderPolygons, Occluders};
pub use tile_load::{CasterReach, PairBound, TileLoadBound};
pub use tree::{DOUBLED, GroupTree, typical_size};
