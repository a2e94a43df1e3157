//! Curl noise: velocities without divergence.
use crate::model::hash::pcg;
use glam::{UVec3, Vec3};

/// Velocity of divergence-free turbulence: the cross product of two noise gradients (`DeWolf` 2005), of
/// magnitude about 1.
pub fn curl_noise(at: Vec3, seed: u32) -> Vec3 {
    const SCALE: f32 = 0.875;
    noise_gradient(at, seed).cross(noise_gradient(at, seed ^ 0x9e37_79b9)) * SCALE
}

/// Gradient of value noise with values -1..1 at the lattice points (Perlin's fade of 2002).
fn noise_gradient(at: Vec3, seed: u32) -> Vec3 {
    let low = at.floor();
    let t = at - low;
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let slope = t * t * (t * (t * 30.0 - 60.0) + 30.0);
    let cell = low.as_ivec3().as_uvec3();
    let next = cell.wrapping_add(UVec3::ONE);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let value = |x: u32, row: u32| (pcg(x ^ row) >> 8) as f32 / (1 << 23) as f32 - 1.0;
    let (slice0, slice1) = (pcg(cell.z ^ seed), pcg(next.z ^ seed));
    let (row00, row10) = (pcg(cell.y ^ slice0), pcg(next.y ^ slice0));
    let (row01, row11) = (pcg(cell.y ^ slice1), pcg(next.y ^ slice1));
    let (c000, c100) = (value(cell.x, row00), value(next.x, row00));
    let (c010, c110) = (value(cell.x, row10), value(next.x, row10));
    let (c001, c101) = (value(cell.x, row01), value(next.x, row01));
    let (c011, c111) = (value(cell.x, row11), value(next.x, row11));
    // Interpolates along x at the four edges, then takes their differences.
    let edges = [
        mix(c000, c100, fade.x),
        mix(c010, c110, fade.x),
        mix(c001, c101, fade.x),
        mix(c011, c111, fade.x),
    ];
    let along_x =
        mix(mix(c100 - c000, c110 - c010, fade.y), mix(c101 - c001, c111 - c011, fade.y), fade.z);
    let along_y = mix(edges[1] - edges[0], edges[3] - edges[2], fade.z);
    let along_z = mix(edges[2], edges[3], fade.y) - mix(edges[0], edges[1], fade.y);
    Vec3::new(along_x, along_y, along_z) * slope
}
