//! CPU reference of `wgsl/entry/walk.wgsl`: the filter map `F`, as its texture stores it.
use glam::{IVec3, Vec3};
use gobo::records::FIXED_ONE;
use half::f16;

/// Transmittance below which a texel is black, so that early termination changes no bit.
pub const BLACK: f32 = 1.0 / 1024.0;

/// Transmittance of an optical depth in fixed point.
pub fn passed(sums: IVec3) -> Vec3 {
    (sums.as_vec3() / -FIXED_ONE).map(f32::exp)
}

/// Filter map `F`, rounded to rgba16float. `gain`: values below [`BLACK`] are kept, since a caster may
/// amplify them.
pub fn resolve(light: Vec3, gain: bool) -> [f32; 3] {
    let stored = |light: f32| {
        let light = if !gain && light < BLACK { 0.0 } else { light };
        f16::from_f32(light.min(f16::MAX.to_f32())).to_f32()
    };
    light.to_array().map(stored)
}
