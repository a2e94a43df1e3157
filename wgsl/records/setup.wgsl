// What `project` leaves of a triangle: a record of `setups`. Rust: src/records/footprint.rs.

import package::bind::sampled::setups;
import package::records::record::record_texel;

const BACK_BIT: u32 = 8u; // of a setup's ties: clockwise as the light sees it
const SETUP_TEXELS: u32 = 8u;

fn setup_texel(setup: u32, texel: u32) -> vec4<u32> {
    return textureLoad(setups, record_texel(setup * SETUP_TEXELS + texel), 0);
}
