// Shares of a tile's texels, one for a workgroup at a time. Where invocations hold one texel each, eight rows of
// eight: a subgroup's are a compact block that culls casters for itself.

import package::traversal::lane::lane_texel;
import choice::accumulator::ROWS;

const SHARE_LANES: u32 = min(256u / ROWS, 64u);
const SHARES: u32 = 256u / (SHARE_LANES * ROWS);

fn share_texel(share: u32, lane: u32) -> vec2<u32> {
    if SHARES == 1u {
        return lane_texel(lane);
    }
    return vec2((share % 2u) * 8u + lane % 8u, (share / 2u) * 8u + lane / 8u);
}
