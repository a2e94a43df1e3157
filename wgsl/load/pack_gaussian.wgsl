// Packs a host's Gaussian into the records that its upload would make: bit for bit, but for the radius where
// its quaternion has unit length only up to rounding. Rust: `Caster::of_gaussian` and `GaussianAxes` in
// src/records/gaussian.rs.

import package::bind::uniform::gaussian_looks;
import package::load::pack_caster::{half_bits, packed_color};
import package::project::conic::reach_squared;
import package::records::gaussian::MEDIUM_BIT;
import package::records::host::Gaussian;
import package::records::record::OPACITY_SCALE;

const ROOT_TAU: f32 = 2.5066283;
const UNIT_ROUNDING: f32 = 1e-6; // of a unit quaternion's squared length
const RADIUS_SLACK: f32 = 1.0001; // rounding of a logarithm and a root

fn is_medium(gaussian: Gaussian) -> bool {
    return (gaussian_looks[gaussian.material].marks & MEDIUM_BIT) != 0u;
}

// Opacity of a Gaussian, or a medium's optical depth along its longest axis.
fn most_opacity(gaussian: Gaussian) -> f32 {
    let longest = max(max(gaussian.sigma.x, gaussian.sigma.y), gaussian.sigma.z);
    let of_medium = gaussian_looks[gaussian.material].density * longest * ROOT_TAU;
    return gaussian.opacity * select(1.0, of_medium, is_medium(gaussian));
}

// Radius of a sphere around the Gaussian [m].
fn gaussian_radius(gaussian: Gaussian, opacity: f32) -> f32 {
    let longest = max(max(gaussian.sigma.x, gaussian.sigma.y), gaussian.sigma.z);
    return longest * sqrt(reach_squared(opacity)) * RADIUS_SLACK;
}

fn packed_gaussian(gaussian: Gaussian, axes: u32) -> vec4<u32> {
    let look = gaussian_looks[gaussian.material];
    let levels = packed_color(gaussian.color, gaussian.material);
    let scale = select(OPACITY_SCALE, look.density, is_medium(gaussian));
    return vec4(
        levels.r | (levels.g << 16u),
        levels.b | (half_bits(gaussian.opacity * scale) << 16u),
        gaussian.material | look.marks,
        axes,
    );
}

struct PackedAxes {
    rotation: vec4<u32>,
    sigma: vec4<u32>, // and the id
}

fn packed_axes(gaussian: Gaussian) -> PackedAxes {
    let squared = dot(gaussian.rotation, gaussian.rotation);
    let step = select(1.0, 1.5 - 0.5 * squared, abs(squared - 1.0) > UNIT_ROUNDING);
    let unit = gaussian.rotation * step;
    return PackedAxes(bitcast<vec4<u32>>(unit), vec4(bitcast<vec3<u32>>(gaussian.sigma), gaussian.id));
}
