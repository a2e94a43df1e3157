//! Kinds of a scene's filtering casters; they decide how maps are accumulated.
use gobo::model::{Casters, Class, Shape, Transfer};

/// Whether all filtering casters allow [`super::curve::tile::CurveModes::rays`].
pub(super) fn only_rays(scene: &Casters<'_>) -> bool {
    let material = |id: u32| &scene.materials[id as usize];
    let filters = |id: u32| Class::FILTERING.contains(&Class::of(material(id)));
    let adds = |id: u32| filters(id) && material(id).transfer == Transfer::Over;
    let is_volume = |id: u32| filters(id) && material(id).is_volume();
    let is_other =
        |id: u32| filters(id) && matches!(material(id).shape, Shape::Brick | Shape::Capsule);
    !scene.gaussians.iter().any(|gaussian| filters(gaussian.material))
        && !scene.particles.iter().any(|p| is_other(p.material) || adds(p.material))
        && !scene.triangles.iter().any(|t| is_volume(t.material) || adds(t.material))
}

/// Whether all filtering casters are soft discs of the `filter` transfer.
pub(super) fn only_discs(scene: &Casters<'_>) -> bool {
    let material = |id: u32| &scene.materials[id as usize];
    let filters = |id: u32| Class::FILTERING.contains(&Class::of(material(id)));
    let is_other = |id: u32| filters(id) && !material(id).is_plain_disc();
    !scene.gaussians.iter().any(|gaussian| filters(gaussian.material))
        && !scene.particles.iter().any(|p| is_other(p.material))
        && !scene.triangles.iter().any(|triangle| filters(triangle.material))
}

/// Whether some filtering caster is a puff.
pub(super) fn any_puff(scene: &Casters<'_>) -> bool {
    scene.particles.iter().any(|particle| {
        let material = &scene.materials[particle.material as usize];
        material.shape == Shape::Puff && Class::FILTERING.contains(&Class::of(material))
    })
}

/// Whether some filtering caster is faint.
pub(super) fn any_faint(scene: &Casters<'_>) -> bool {
    let is_faint = |id: u32, alpha: f32| {
        let material = &scene.materials[id as usize];
        Class::FILTERING.contains(&Class::of(material)) && material.is_faint(alpha)
    };
    scene.particles.iter().any(|p| is_faint(p.material, p.color.w))
        || scene.gaussians.iter().any(|g| {
            is_faint(g.material, g.most_opacity(scene.materials[g.material as usize].gaussian))
        })
        || scene.triangles.iter().any(|triangle| is_faint(triangle.material, 1.0))
}
