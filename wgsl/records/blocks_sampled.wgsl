// Blocks of levels, for shaders of the host and for kernels that have no storage texture to spare.

import package::bind::sampled::levels;
import package::records::area::BLOCK_TEXELS;
import package::records::record::record_texel;

// Two of a block's four nodes.
fn block_nodes(block: u32, pair: u32) -> vec4<u32> {
    return textureLoad(levels, record_texel(block * BLOCK_TEXELS + pair), 0);
}
