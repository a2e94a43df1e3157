// Shares of a tile's texels: a workgroup takes one at a time.

import package::traversal::lane::lane_texel;
import choice::accumulator::ROWS;

const SHARE_LANES: u32 = min(256u / ROWS, 64u);
const SHARES: u32 = 256u / (SHARE_LANES * ROWS);

fn share_texel(share: u32, lane: u32) -> vec2<u32> {
    return lane_texel(share * SHARE_LANES + lane);
}
