//! Shadow map comparison of a receiver.
use glam::Vec3;

/// A texel of a view's maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapTexel {
    /// Filter map `F`.
    pub filter: Vec3,
    /// Nearest depth `D`.
    pub nearest: f32,
    /// Opaque depth `Z`.
    pub opaque: f32,
}

/// Light that reaches light depth `z`, per channel, in curve mode; `light_at`: the curve.
pub fn receive_curve(z: f32, opaque: f32, bias: f32, light_at: impl FnOnce(f32) -> Vec3) -> Vec3 {
    if z > opaque + bias { Vec3::ZERO } else { light_at(z - bias) }
}

/// Light that reaches light depth `z`, per channel, in nearest-depth mode.
pub fn receive(z: f32, texel: &MapTexel, bias: f32) -> Vec3 {
    if z > texel.opaque + bias {
        Vec3::ZERO
    } else if z > texel.nearest + bias {
        texel.filter
    } else {
        Vec3::ONE
    }
}

/// Channels of `light` that per-channel opaque depths let through to light depth `z`.
pub fn light_by_channel(light: Vec3, depths: [f32; 3], z: f32, bias: f32) -> Vec3 {
    let blocked = (Vec3::from_array(depths) + bias).cmplt(Vec3::splat(z));
    Vec3::select(blocked, Vec3::ZERO, light)
}
