// Whether an opaque material's hit is there at all; the picture has no dithered ones. CPU twin:
// src/reference/occlude.rs.

import package::bind::uniform::materials;
import package::hit::caster_hit::Hit;
import package::records::material::TRANSFER_CUTOUT;

fn is_solid(hit: Hit) -> bool {
    let material = materials[hit.material];
    let cut = material.transfer == TRANSFER_CUTOUT && hit.opacity < material.cutoff;
    return hit.depth >= 0.0 && !cut;
}
