// Gaussians as uploaded, behind the particles in `casters`, and projected to one view, at the start of
// `setups`. Rust: src/records/gaussian.rs.

import package::bind::sampled::setups;
import package::records::footprint::Footprint;
import package::records::record::record_texel;

const GAUSSIAN_TEXELS: u32 = 3u;
const OUTLINE_TEXEL: u32 = 2u; // of a setup: the outline for `bin`
const NEUTRAL_BIT: u32 = 0x10000u; // of a look: black in shadow views
const MEDIUM_BIT: u32 = 0x20000u;  // of a look: alpha is an extinction
const GAUSSIAN_MARK: u32 = 0xffffu; // in place of a footprint's base opacity

// With u = (whitening.x delta.x + whitening.y delta.y, whitening.z delta.y) and delta from the centre
// [texels], the ray's least distance from the centre in the Gaussian's own space is q^2 = |u|^2 / (e^2 +
// spread |u|^2), where e = 1 + tilt . u; in an orthographic view, q^2 = |u|^2.
struct GaussianSetup {
    whitening: vec3<f32>, // [1/texels]
    spread: f32,
    tilt: vec2<f32>,
    color: vec2<u32>, // colour, unorm16, and thinness, f16
}

fn is_gaussian(footprint: Footprint) -> bool {
    return (footprint.look.z & 0xffffu) == GAUSSIAN_MARK;
}

fn gaussian_setup(footprint: Footprint) -> GaussianSetup {
    let at = footprint.look.x * GAUSSIAN_TEXELS;
    let a = bitcast<vec4<f32>>(textureLoad(setups, record_texel(at), 0));
    let b = textureLoad(setups, record_texel(at + 1u), 0);
    return GaussianSetup(a.xyz, a.w, bitcast<vec2<f32>>(b.xy), b.zw);
}

// Opacity of a splat at its centre, or a medium's extinction there times the root of 2 pi [1/m].
fn gaussian_amplitude(footprint: Footprint) -> f32 {
    return bitcast<f32>(footprint.look.y);
}
