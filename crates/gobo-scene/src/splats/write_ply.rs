//! Writes PLY of 3D Gaussian splatting.
use super::{Harmonics, cloud::HARMONIC};
use gobo::model::Gaussian;
use std::fmt::Write as _;

const COLUMNS: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
    "rot_0", "rot_1", "rot_2", "rot_3",
];

/// Opacities are written at least this far from 0 and 1, whose logits are infinite; sixteen bits resolve it.
const OPACITY_MARGIN: f32 = 1e-6;

/// The splats as a little-endian PLY. `colors`: one per splat, of any magnitude; `harmonics`: of each splat,
/// or none.
pub fn to_ply(splats: &[Gaussian], colors: &[glam::Vec3], harmonics: &Harmonics) -> Vec<u8> {
    let mut header =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", splats.len());
    for column in COLUMNS {
        let _ = writeln!(header, "property float {column}");
    }
    for i in 0..3 * harmonics.count {
        let _ = writeln!(header, "property float f_rest_{i}");
    }
    let mut bytes = (header + "end_header\n").into_bytes();
    bytes.reserve_exact(splats.len() * (COLUMNS.len() + 3 * harmonics.count) * 4);
    for (i, (splat, color)) in splats.iter().zip(colors).enumerate() {
        let [x, y, z] = splat.center.to_array();
        let [r, g, b] = color.map(|c| (c - 0.5) / HARMONIC).to_array();
        let opacity = splat.opacity.clamp(OPACITY_MARGIN, 1.0 - OPACITY_MARGIN);
        let [sx, sy, sz] = splat.sigma.map(f32::ln).to_array();
        let [qx, qy, qz, qw] = splat.rotation.to_array();
        let logit = (opacity / (1.0 - opacity)).ln();
        let row = [x, y, z, r, g, b, logit, sx, sy, sz, qw, qx, qy, qz];
        bytes.extend(row.into_iter().flat_map(f32::to_le_bytes));
        for channel in 0..3 {
            let of_channel = harmonics.of(i).iter().map(|rgb| rgb[channel]);
            bytes.extend(of_channel.flat_map(f32::to_le_bytes));
        }
    }
    bytes
}
