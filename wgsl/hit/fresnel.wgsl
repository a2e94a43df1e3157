// Light that faces and panes of glass transmit, by Fresnel's formulas for unpolarised light. CPU reference:
// crates/gobo-reference/src/fresnel.rs.

import package::bind::uniform::materials;
import package::features::HAS_FRESNEL;
import package::hit::hit::to_world;
import package::records::octahedral::from_octahedral;
import package::records::setup::setup_texel;
import package::records::view::GpuView;

// Transmitted share at a cosine to the outside normal. `index`: refractive index; negative for a pane, whose
// inner reflections go on until all light has left (Born and Wolf 1999, sections 1.5.2 and 7.6.1, without
// interference).
fn passed_share(index: f32, cosine: f32) -> f32 {
    let outside = min(abs(cosine), 1.0);
    let square = index * index;
    let inside = sqrt(max(square - 1.0 + outside * outside, 0.0));
    let across = (outside - inside) / (outside + inside);
    let along = (square * outside - inside) / (square * outside + inside);
    let reflected = vec2(across * across, along * along);
    let passed = (1.0 - reflected) / select(vec2(1.0), 1.0 + reflected, index < 0.0);
    return 0.5 * (passed.x + passed.y);
}

// Share of the ray through `texel` of a map that a triangle transmits.
fn face_passes(view: GpuView, setup: u32, texel: vec2<f32>) -> f32 {
    if !HAS_FRESNEL {
        return 1.0;
    }
    let index = materials[setup_texel(setup, 4u).w].fresnel;
    if index == 0.0 {
        return 1.0;
    }
    let slope = (texel - view.size * 0.5) / view.scale * view.perspective;
    let ray = to_world(view, vec3(slope.x, -slope.y, -1.0));
    let normal = from_octahedral(setup_texel(setup, 6u).z);
    return passed_share(index, dot(normal, ray) / length(ray));
}
