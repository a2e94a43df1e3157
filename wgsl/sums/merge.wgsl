// Adds a caster or a segment to the sums of a texel. CPU reference: crates/gobo-reference/src/accumulate.rs.
//
// Bit-identical in every order: a saturated sum is black whatever is added.

import package::features::HAS_GAIN;
import package::sums::sums::SATURATED;
import choice::sums::{add_to_sums, load_sums};

// Largest addend of one of many invocations at a time: 1,024 workgroups of 256 do not wrap a sum that all of
// them saw below `SATURATED`. Rust: src/stage/accumulate.rs.
const LARGEST_STEP: u32 = 16380u;

fn merge(texel: u32, tau: vec3<u32>) {
    let sums = load_sums(texel);
    if HAS_GAIN {
        add_to_sums(texel, tau);
    } else if any(sums < vec3(SATURATED)) && any(tau != vec3(0u)) {
        add_to_sums(texel, select(tau, vec3(0u), sums >= vec3(SATURATED)));
    }
}

// Like `merge`, for so many invocations at a time that their addends would wrap the sum: in steps, each after
// a look at the sum.
fn merge_in_steps(texel: u32, tau: vec3<u32>) {
    if HAS_GAIN {
        add_to_sums(texel, tau);
        return;
    }
    var left = tau;
    loop {
        left = select(left, vec3(0u), load_sums(texel) >= vec3(SATURATED));
        let step = min(left, vec3(LARGEST_STEP));
        if any(step != vec3(0u)) {
            add_to_sums(texel, step);
        }
        left -= step;
        if all(left == vec3(0u)) {
            break;
        }
    }
}
