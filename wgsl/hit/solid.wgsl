// Whether a hit of an `opaque` or `cutout` material is solid; the picture blends dithered ones. CPU
// reference: crates/gobo-reference/src/occlude.rs.

import package::bind::uniform::materials;
import package::hit::hit::Hit;
import package::records::material::TRANSFER_CUTOUT;

fn is_solid(hit: Hit) -> bool {
    let material = materials[hit.material];
    let cut = material.transfer == TRANSFER_CUTOUT && hit.opacity < material.cutoff;
    return hit.depth >= 0.0 && !cut;
}
