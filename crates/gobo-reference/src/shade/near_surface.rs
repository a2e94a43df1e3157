//! CPU reference of `crates/gobo-picture/wgsl/shade/near_surface.wgsl`: fading of soft particles before a
//! surface.
use glam::Vec2;
use gobo::{
    model::{Material, Profile, Shape},
    records::{Footprint, GpuView},
};

/// Share of a particle that is seen; `depths`: light depths of its hit and of the surface behind it.
pub(super) fn share_before_surface(
    view: &GpuView,
    footprint: &Footprint,
    material: &Material,
    pixel: Vec2,
    depths: [f32; 2],
) -> f32 {
    let is_soft = match material.shape {
        Shape::Disc => material.profile == Profile::Soft,
        shape => shape == Shape::Puff,
    };
    let [depth, surface] = depths;
    if !is_soft || surface >= 1.0 {
        return 1.0;
    }
    let range = view.far - view.near;
    let ray = |texel: Vec2| ((texel - view.size * 0.5) / view.scale).extend(1.0);
    let away = (view.near + footprint.depth * range) * ray(footprint.center).length();
    let radius = footprint.beside().map_or(footprint.radius * away, |_| -footprint.radius);
    let part = ((surface - depth) * range * ray(pixel).length() / (2.0 * radius)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
