// Triangle setup, written by `project`: a record of `setups`. Rust: src/records/triangle.rs.

import package::bind::sampled::setups;
import package::records::record::record_texel;

const BACK_BIT: u32 = 8u; // flag of a setup's ties: clockwise as seen from the light
const SETUP_TEXELS: u32 = 8u;

fn setup_texel(setup: u32, texel: u32) -> vec4<u32> {
    return textureLoad(setups, record_texel(setup * SETUP_TEXELS + texel), 0);
}
