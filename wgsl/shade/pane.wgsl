// Panes: thin surfaces that filter what is behind them, scatter some light and mirror some. CPU reference:
// src/reference/shade/mod.rs.

import package::hit::hit::Hit;
import package::records::material::{GpuMaterial, MAX_GAIN, TRANSFER_GAIN, TRANSFER_OVER, TRANSFER_SMOKE};
import package::shade::shading::{Gloss, mirrored_sky};

// Gloss of a pane, premultiplied: glass keeps its highlights where it is clear.
fn pane_gloss(hit: Hit, material: GpuMaterial) -> Gloss {
    let shines = 1.0 - f32(material.unlit);
    return Gloss(material.reflectivity * shines, max(hit.opacity, material.transmission) * shines);
}

// Share of light that a pane scatters: all that it covers where its transfer attenuates what is behind by that; else half
// of it if it is not clear, filtering the rest. `of_emission`: what it sends, and not what it takes beside its transfer.
fn scattered_share(hit: Hit, material: GpuMaterial, of_emission: bool) -> f32 {
    let covers = material.transfer == TRANSFER_OVER || material.transfer == TRANSFER_SMOKE;
    let share = select(0.5 * (1.0 - material.transmission), select(0.0, 1.0, of_emission), covers);
    return hit.opacity * share * (1.0 - f32(material.unlit));
}

// Mirrored share of the sky; `normal` is on the eye's side.
fn mirrored_share(hit: Hit, material: GpuMaterial, normal: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    return mirrored_sky(pane_gloss(hit, material), dot(normal, to_eye), material.roughness);
}

// Albedo of a pane; `gain` scatters everything.
fn seen_color(hit: Hit, transfer: u32) -> vec3<f32> {
    return select(hit.color, min(hit.color * MAX_GAIN, vec3(1.0)), transfer == TRANSFER_GAIN);
}
