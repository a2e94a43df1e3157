// Adds a caster or a segment to the sums of a texel. CPU reference: src/reference/accumulate.rs.

import package::features::HAS_GAIN;
import package::sums::sums::SATURATED;
import choice::sums::{add_to_sums, load_sums};

// Bit-identical in every order: a saturated sum is black whatever is added.
fn merge(texel: u32, tau: vec3<u32>) {
    let sums = load_sums(texel);
    if HAS_GAIN {
        add_to_sums(texel, tau);
    } else if any(sums < vec3(SATURATED)) && any(tau != vec3(0u)) {
        add_to_sums(texel, select(tau, vec3(0u), sums >= vec3(SATURATED)));
    }
}
