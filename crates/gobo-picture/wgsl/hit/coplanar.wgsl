// Faces in one plane, whose depths differ only by rounding: the one with the higher id is in front. CPU
// reference: crates/gobo-reference/src/coplanar.rs.

import package::bind::sampled::triangles;
import package::records::record::{TRIANGLE_BIT, TRIANGLE_TEXELS, record_texel};

// Largest difference of such depths, as a share of the depth.
const COPLANAR: f32 = 1.52587890625e-5;

fn is_coplanar(depth: f32, other: f32) -> bool {
    return abs(depth - other) <= COPLANAR * other;
}

// Id of a triangle's object. `caster`: the triangle.
fn object_of(caster: u32) -> u32 {
    return textureLoad(triangles, record_texel((caster & ~TRIANGLE_BIT) * TRIANGLE_TEXELS + 4u), 0).w;
}

// Whether a triangle is in front of another caster.
fn is_in_front(depth: f32, caster: u32, other_depth: f32, other: u32) -> bool {
    if (other & TRIANGLE_BIT) != 0u && is_coplanar(depth, other_depth) {
        let object = object_of(caster);
        let other_object = object_of(other);
        if object != other_object {
            return object > other_object;
        }
    }
    return depth < other_depth;
}
