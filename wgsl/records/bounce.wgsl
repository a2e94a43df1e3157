// Light that lit surfaces scatter, as points that send it: BOUNCE_VECTORS vectors each, after a head of which
// x is the bits of their number. Rust: src/records/bounce.rs.

import package::records::light::GpuLight;

// Vectors of a point: its position, world space [m], and the squared radius of its disc [m^2]; its normal;
// the light that it sends, over pi.
const BOUNCE_VECTORS: u32 = 3u;
const BOUNCE_LENGTH: u32 = 3073u;

// A light's map whose light points send on.
struct BounceParams {
    light: GpuLight,
    first: u32, // of the view's points
    edge: u32,  // points along an edge of the map
    pad_0: u32,
    pad_1: u32,
}
