// Records, and their places in textures: element i starts at linear texel i * (texels of an element). Rust:
// src/records/mod.rs.

// A caster as uploaded. Rust: src/records/caster.rs.
struct CasterRecord {
    center: vec3<f32>, // world space [m]
    radius: f32,       // [m]
    red_green: u32,    // as in wgsl/records/pack.wgsl
    blue_alpha: u32,   // alpha: f16
    material_rotation: u32, // rotation in the high half [turns / 65536]
    id: u32,
}

// A caster projected to one view. Read by wgsl/records/footprint.wgsl. Rust: `Footprint` in
// src/records/footprint.rs, src/records/triangle.rs.
struct FootprintRecord {
    // Centre and radius [texels], light depth; in metres for a particle beside the view (`is_beside`).
    bounds: vec4<f32>,
    // Colour, opacity, depth key and caster, packed.
    look: vec4<u32>,
}

const ROW: u32 = 4096u; // texels

fn record_texel(index: u32) -> vec2<u32> {
    return vec2(index % ROW, index / ROW);
}

// Row of the histograms of a sort, below a row for each digit, with the totals of the digits. Rust:
// src/stage/sort/mod.rs.
const TOTAL_ROW: u32 = 256u;

const TRIANGLE_BIT: u32 = 0x80000000u;

const TRIANGLE_TEXELS: u32 = 6u;

// Scale of opacities, which are stored as halves: down to 2e-9 they have eleven bits. Rust:
// src/records/pack.rs.
const OPACITY_SCALE: f32 = 32768.0;

// A count from a uniform buffer, bounded by a texture's texels. lavapipe compiles a kernel anew for every
// uniform buffer that alone decides how often a loop runs (tests/contract/uniform_branches.rs).
fn bounded(count: u32, size: vec2<u32>) -> u32 {
    return min(count, size.x * size.y);
}
