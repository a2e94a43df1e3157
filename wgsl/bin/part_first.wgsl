// bin, before the parts of the tiles: sets the numbers of segments to zero, so that no segment is walked
// again where no part follows. One invocation. Rust: src/shadows/batch/parts.rs.

import package::bin::part_plan::store_dispatch;
import package::records::dispatch::{MERGED_DISPATCH, SEGMENT_DISPATCH};

@compute @workgroup_size(1)
fn part_first() {
    store_dispatch(SEGMENT_DISPATCH, vec4(0u));
    store_dispatch(MERGED_DISPATCH, vec4(0u));
}
