// Walks that visit particles and triangles in loops of their own. Drivers of software adapters take both
// sides of branches, but they leave loops, though only at their end, so the loops of walks test there whether
// to go on. Elsewhere a branch costs nothing, as all lanes visit the same caster, and a second loop doubles
// the code.

import package::features::{HAS_PARTICLES, HAS_TRIANGLES, KINDS_APART};
import package::records::footprint::Footprint;

// Whether there are two loops: one of particles, one of triangles.
fn kinds_apart() -> bool {
    return KINDS_APART && HAS_PARTICLES && HAS_TRIANGLES;
}

// Footprint that a loop visits. Where the loop has only one kind, the compiler drops the code for the other.
fn visited(footprint: Footprint, is_triangle: bool) -> Footprint {
    let known = KINDS_APART || !(HAS_PARTICLES && HAS_TRIANGLES);
    return Footprint(
        footprint.bounds,
        footprint.look,
        select(footprint.is_triangle, is_triangle, known),
    );
}
