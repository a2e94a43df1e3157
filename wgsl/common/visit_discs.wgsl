// A soft disc of the `filter` transfer meets the four texels; hits wait for the end of their slab.
// CPU twin: src/cpu/curve/tile.rs. Needs common/gather_curve.wgsl, disc.wgsl.

const HAS_TRIANGLES: bool = false;
const HAS_PUFFS: bool = false;

// Seen from afar a disc's depth is the same everywhere.
fn ordered() -> bool {
    return !PERSPECTIVE;
}

fn blocked() -> bool {
    return HAS_OPAQUE;
}

fn slabbed() -> bool {
    return true;
}

fn texels_profile(view: GpuView, disc: Disc) -> Profile4 {
    let dx = corner.x + 0.5 - disc.center.x;
    let dy = corner.y + vec4(0.5, 1.5, 2.5, 3.5) - disc.center.y;
    return disc_profile(view, disc, dx, dy, opaque_depth);
}

fn disc_light(disc: Disc, profile: vec4<f32>) -> Light4 {
    return Light4(
        1.0 - profile * disc.absorbed.r,
        1.0 - profile * disc.absorbed.g,
        1.0 - profile * disc.absorbed.b,
    );
}

fn visit_disc(view: GpuView, disc: Disc) -> vec4<bool> {
    let met = texels_profile(view, disc);
    return meet(disc_light(disc, met.profile), met.depth, met.profile * disc.slope);
}

// As `visit_disc`, of a disc behind what is nearest.
fn visit_behind(view: GpuView, disc: Disc) {
    let met = texels_profile(view, disc);
    let placed = join(disc_light(disc, met.profile), met.depth, met.profile * disc.slope);
}

// True where the hits cannot wait.
fn visit(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> bool {
    return must_flush(visit_disc(view, prepare_disc(view, place, look)));
}
