// Whether an opaque material's hit blocks the light. CPU twin: src/cpu/occlude.rs.
// Needs common/caster_hit.wgsl.
fn is_solid(hit: Hit) -> bool {
    let material = materials[hit.material];
    let cut = material.transfer == TRANSFER_CUTOUT && hit.opacity < material.cutoff;
    let dithered = material.transfer == TRANSFER_DITHER && hit.opacity <= 0.5;
    return hit.depth >= 0.0 && !cut && !dithered;
}
