// Whether an opaque material's hit is there at all; the picture has no dithered ones.
// CPU twin: src/cpu/occlude.rs. Needs common/caster_hit.wgsl.
fn is_solid(hit: Hit) -> bool {
    let material = materials[hit.material];
    let cut = material.transfer == TRANSFER_CUTOUT && hit.opacity < material.cutoff;
    return hit.depth >= 0.0 && !cut;
}
