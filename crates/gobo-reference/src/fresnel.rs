//! CPU reference of `wgsl/hit/hit.wgsl`: transmittance of faces and panes of glass.
use glam::{Vec2, Vec3};
use gobo::records::{GpuView, from_octahedral};

/// Transmittance of unpolarised light, at a cosine to the normal outside. `index`: of refraction; negative
/// for a pane, in which reflected light goes on until it leaves (Born and Wolf 1999, sections 1.5.2 and
/// 7.6.1, without interference).
pub fn passed_share(index: f32, cosine: f32) -> f32 {
    let cosine = cosine.abs().min(1.0);
    let square = index * index;
    let inside = (square - 1.0 + cosine * cosine).max(0.0).sqrt();
    let across = (cosine - inside) / (cosine + inside);
    let along = (square * cosine - inside) / (square * cosine + inside);
    let reflected = Vec2::new(across * across, along * along);
    let passed = Vec2::ONE - reflected;
    let passed = if index < 0.0 { passed / (Vec2::ONE + reflected) } else { passed };
    0.5 * (passed.x + passed.y)
}

/// Transmittance of a triangle for the ray through `texel` of a map. `normal`: of its plane, octahedral.
pub(super) fn face_passes(view: &GpuView, index: f32, normal: u32, texel: Vec2) -> f32 {
    if index == 0.0 {
        return 1.0;
    }
    let slope = (texel - view.size * 0.5) / view.scale * view.perspective;
    let ray =
        view.view_from_world.transpose().transform_vector3(Vec3::new(slope.x, -slope.y, -1.0));
    passed_share(index, from_octahedral(normal).dot(ray) / ray.length())
}
