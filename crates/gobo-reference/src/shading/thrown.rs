//! CPU reference of `wgsl/shade/thrown.wgsl`: look-up of the light refracted by glass.
use super::taps::spline;
use crate::caustics::{NEAR_SURFACE, index_at, place};
use glam::{Vec2, Vec3, Vec4};
use gobo::records::{GpuView, ViewMaps, caustic_light};

/// Refracted light that lands around a point, and the share of the straight light there that was refracted
/// elsewhere; none off the opaque surface. `point`: world space.
pub(super) fn landed_light(view: &GpuView, maps: &ViewMaps, point: Vec3) -> Vec4 {
    let point = view.view_from_world.transform_point3(point);
    let at = place(view, point);
    let texel = if view.perspective > 0.0 { -point.z } else { 1.0 } / view.scale;
    let middle = at.floor();
    let [columns, rows] = (at - middle - 0.5).to_array().map(spline);
    let (mut sum, mut whole) = (Vec4::ZERO, 0.0);
    for i in 0..9 {
        let aside = Vec2::new((i % 3) as f32, (i / 3) as f32) - 1.0;
        let Some(index) = index_at(view, middle + aside) else { continue };
        let along = view.near + maps.opaque[index] * (view.far - view.near);
        if (along + point.z).abs() > NEAR_SURFACE * texel {
            continue;
        }
        let weight = columns[i % 3] * rows[i / 3];
        sum += caustic_light(maps.caustics[index]) * weight;
        whole += weight;
    }
    if whole > 0.0 { sum / whole } else { Vec4::ZERO }
}
