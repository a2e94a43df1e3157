// The key and the tile rectangle of a footprint.

import package::bind::stored::{keys, rects};
import package::records::record::record_texel;

fn put(index: u32, key: u32, rect: vec2<u32>) {
    let texel = record_texel(index);
    textureStore(keys, texel, vec4(key, index, 0u, 0u));
    textureStore(rects, texel, vec4(rect, 0u, 0u));
}
