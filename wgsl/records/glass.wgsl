// Glass that refracts light, and the light that it throws. Rust: src/records/caustic.rs.

// Vectors of a face: three corners [m], of which w is the index of refraction, its spread and nothing; three
// normals, of which w is the albedo of a solid face, red, green and blue.
const GLASS_VECTORS: u32 = 6u;

// Light of one texel, in fixed point.
const CAUSTIC_ONE: f32 = 65536.0;
// Bits of a channel's carry, in the last word of a texel.
const CARRY_BITS: u32 = 10u;
// Flag in the last word of a texel whose own light was thrown elsewhere.
const THROWN_BIT: u32 = 0x80000000u;
// Largest distance of a receiver from the opaque surface that light lands on [texels].
const NEAR_SURFACE: f32 = 4.0;

// Map of a view whose rays glass refracts.
struct CausticParams {
    first: u32,      // first texel of the shadow's views in `caustics`
    base: u32,       // first texel of this view among those of its shadow
    number: u32,     // of this view in `views`
    face_count: u32,
    rays: u32,       // of a texel, along its edge
    slices: u32,     // workgroups of a face
}

// Light that lands in a texel, and 1 where the texel's own light was thrown elsewhere, else 0.
fn caustic_light(texel: vec4<u32>) -> vec4<f32> {
    let mask = (1u << CARRY_BITS) - 1u;
    let carries = (vec3(texel.w) >> vec3(0u, CARRY_BITS, 2u * CARRY_BITS)) & vec3(mask);
    return vec4(vec3<f32>(texel.xyz) / CAUSTIC_ONE + vec3<f32>(carries) * CAUSTIC_ONE, f32(texel.w >> 31u));
}
