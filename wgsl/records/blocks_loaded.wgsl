// Blocks of levels from a storage texture: loads from those are far cheaper on software adapters.

import package::bind::loaded::levels;
import package::records::area::BLOCK_TEXELS;
import package::records::record::record_texel;

// Two of a block's four nodes.
fn block_nodes(block: u32, pair: u32) -> vec4<u32> {
    return textureLoad(levels, record_texel(block * BLOCK_TEXELS + pair));
}
