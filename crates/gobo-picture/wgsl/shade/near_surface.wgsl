// Fading of soft particles before a surface, so that dust and smoke do not end there in a line (Lorach 2007,
// soft particles). CPU reference: crates/gobo-reference/src/shade/near_surface.rs.

import package::records::material::{GpuMaterial, PROFILE_SOFT, SHAPE_DISC, SHAPE_PUFF};
import package::records::view::{GpuView, is_beside};

// Share of a particle that is seen: nothing at the surface behind it, all of it from its diameter before the
// surface on. `view`: the camera's; `bounds`: of its footprint; `depth`, `opaque_depth`: light depths of its
// hit and of the surface.
fn share_before_surface(
    view: GpuView,
    bounds: vec4<f32>,
    material: GpuMaterial,
    pixel: vec2<f32>,
    depth: f32,
    opaque_depth: f32,
) -> f32 {
    let range = view.far - view.near;
    let ray = vec3((pixel - view.size * 0.5) / view.scale, 1.0);
    let middle = vec3((bounds.xy - view.size * 0.5) / view.scale, 1.0);
    let away = (view.near + bounds.w * range) * length(middle);
    let radius = select(bounds.z * away, -bounds.z, is_beside(bounds));
    let part = saturate((opaque_depth - depth) * range * length(ray) / (2.0 * radius));
    let is_soft_disc = material.shape == SHAPE_DISC && material.profile == PROFILE_SOFT;
    // The sky is no surface.
    let fades = (is_soft_disc || material.shape == SHAPE_PUFF) && opaque_depth < 1.0;
    return select(1.0, part * part * (3.0 - 2.0 * part), fades);
}
