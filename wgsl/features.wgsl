// What a batch holds and what its device is good at: what is not there is compiled away. Rust:
// `Features` in src/stage/hits.rs and `Config` in src/shadows/config.rs say the values.

override HAS_PARTICLES: bool = true;
override HAS_TRIANGLES: bool = true;
override HAS_TEXTURES: bool = true;
override HAS_PUFFS: bool = true;
// Shapes other than discs and triangles.
override HAS_QUADS: bool = true;
// A caster may brighten: sums go both ways and saturation is no end.
override HAS_GAIN: bool = false;
// A caster adds light: order-dependent blending, without an early-out at saturation.
override HAS_OVER: bool = false;
// Closed meshes absorb along the way through them: their sums are signed, and faces behind the
// opaque surface count.
override HAS_VOLUMES: bool = false;
// Some receiver is tinted by all casters but its own: maps say whose the nearest depth is.
override HAS_OWNERS: bool = false;
override HAS_DITHER: bool = true;
// Opaque triangles that are too small for tiles.
override HAS_SMALL: bool = false;
// The batch's views are perspective ones.
override PERSPECTIVE: bool = false;
// The views have opaque casters.
override HAS_OPAQUE: bool = true;
// A caster's opacity is so small that products of transmittances lose it.
override FAINT: bool = false;
// K, the nodes of a curve: at most 16; 0 where there are no curves.
override NODES: u32 = 0u;
// The picture shows what each pixel costs.
override COUNT_COST: bool = false;
// Loops over some texels stay loops. Written out they are faster, but some compilers take a minute
// for that.
override ROLLED: bool = false;
// Subgroups may have more than 32 lanes.
override WIDE: bool = true;
// The picture has air, casters that are not solid, and panes among them.
override HAS_AIR: bool = false;
// What is all around is a picture.
override HAS_ENVIRONMENT: bool = false;
override HAS_LAYERS: bool = true;
override HAS_PANES: bool = true;
// Some map is read otherwise than by the spline, or with a bias for slopes.
override HAS_FILTERS: bool = false;
// Some light of the picture asks maps, where no mask speaks for them.
override HAS_SHADOWS: bool = true;
