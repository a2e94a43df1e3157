//! CPU reference of `wgsl/shade/incoming.wgsl`: light that arrives at a point.
use glam::Vec3;
use gobo::records::{END_BIT, GpuLight, INNER_BIT, LIGHT_DIRECTIONAL, LIGHT_SPOT};

/// Direction to the light, and irradiance at normal incidence, before shadows.
pub fn incoming(light: &GpuLight, point: Vec3) -> (Vec3, Vec3) {
    if light.kind == LIGHT_DIRECTIONAL {
        return (-light.direction, light.color);
    }
    let away = point - light.position;
    let square = away.length_squared().max(1e-4);
    let ray = away / square.sqrt();
    let part = square * light.per_range2;
    let window = (1.0 - part * part).max(0.0);
    let squared = if light.traits & END_BIT != 0 { 1.0 } else { window };
    let mut color = light.color / square * (window * squared);
    if light.kind == LIGHT_SPOT {
        let (outer, inner) = (light.cone_outer, light.cone_inner);
        let t = ((ray.dot(light.direction) - outer) / (inner - outer)).clamp(0.0, 1.0);
        color *= t * t * if light.traits & INNER_BIT != 0 { 1.0 } else { 3.0 - 2.0 * t };
    }
    (-ray, color)
}
