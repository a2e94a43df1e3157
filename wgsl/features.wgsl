// Features of a batch and of its device, to which kernels are specialised. Rust: values from `Features` in
// src/stage/features.rs and `Tuning` in src/stage/tuning.rs.

override HAS_PARTICLES: bool = true;
override HAS_TRIANGLES: bool = true;
override HAS_TEXTURES: bool = true;
// Some triangles have colours at their corners.
override HAS_VERTEX_COLORS: bool = false;
// Some triangles reflect a share of the light by its angle.
override HAS_FRESNEL: bool = false;
// Some triangles of the picture send light on to their far side.
override HAS_FAR_SIDES: bool = false;
// Images say of some triangles of the picture what they are like texel by texel.
override HAS_DETAILS: bool = false;
// Some triangles of the picture have a clear coat.
override HAS_COATS: bool = false;
override HAS_PUFFS: bool = true;
override HAS_GAUSSIANS: bool = true;
// Some particles are discs or quads, which face the light.
override HAS_FACING: bool = true;
// Some Gaussians absorb along the ray, as media.
override HAS_MEDIA: bool = true;
// Shapes other than discs and triangles.
override HAS_QUADS: bool = true;
// Bricks of grids of voxels.
override HAS_BRICKS: bool = false;
// Capsules of strands.
override HAS_CAPSULES: bool = false;
// Some caster may amplify light: sums have both signs, and saturation does not end a walk.
override HAS_GAIN: bool = false;
// Some caster adds light: order-dependent blending, without an early-out at saturation.
override HAS_OVER: bool = false;
// Closed meshes absorb along the ray: their sums are signed, and faces behind the opaque surface count.
override HAS_VOLUMES: bool = false;
// Some receiver is tinted by all casters except its own object's: maps hold owner tags.
override HAS_OWNERS: bool = false;
override HAS_DITHER: bool = true;
// Some opaque triangles are too small for tiles.
override HAS_SMALL: bool = false;
// The batch's views are perspective ones.
override PERSPECTIVE: bool = false;
// The batch has orthographic views only.
override PARALLEL: bool = false;
// The setup of a splat has the index of its footprint.
override SETUPS_IN_ORDER: bool = false;
// The views have opaque casters.
override HAS_OPAQUE: bool = true;
// Some caster's opacity is so small that products of transmittances lose it to rounding.
override FAINT: bool = false;
// Nodes of a curve (K), at most 16; 0 without curves.
override NODES: u32 = 0u;
// Curves are in pages.
override HAS_PAGES: bool = false;
// Curves are softened: a ramp will be inserted into each.
override HAS_SOFTENING: bool = false;
// The picture shows the cost of each pixel.
override COUNT_COST: bool = false;
// Walks visit particles and triangles in loops of their own.
override KINDS_APART: bool = false;
// Cells of a brick that a ray crosses in one turn of a loop: llvmpipe ends all loops of an invocation after
// 65,535 turns.
override CELLS_AT_ONCE: u32 = 1u;
// Subgroups may have more than 32 lanes.
override WIDE: bool = true;
// Some of the views whose levels are made are faces of cubes.
override HAS_FACES: bool = true;
// The picture has air, casters that are not solid, and panes among them.
override HAS_AIR: bool = false;
// The picture takes over the light of surfaces from the one through the first sample of the pixels.
override TAKES_LIGHT: bool = false;
// The environment is an image or a sky, not two colours.
override HAS_ENVIRONMENT: bool = false;
override HAS_LAYERS: bool = true;
override HAS_PANES: bool = true;
// Some pane shows the scene behind it refracted or blurred.
override HAS_REFRACTION: bool = false;
// Some map is read with another filter than the spline, or with a slope-scaled bias.
override HAS_FILTERS: bool = false;
// Some light of the picture reads maps, because it has no mask.
override HAS_SHADOWS: bool = true;

// Whether all particles are Gaussians.
fn only_gaussians() -> bool {
    return HAS_GAUSSIANS && !(HAS_FACING || HAS_PUFFS || HAS_BRICKS || HAS_CAPSULES);
}

// Whether all particles are capsules of strands.
fn only_capsules() -> bool {
    return HAS_CAPSULES && !(HAS_FACING || HAS_PUFFS || HAS_BRICKS || HAS_GAUSSIANS);
}

// Bound of a loop over an array that should stay in registers: the linker unrolls the loop for drivers that
// keep there only arrays with constant indices (src/gpu/link/unrolled.rs).
fn unrolled(turns: u32) -> u32 {
    return turns;
}
