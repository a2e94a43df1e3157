// A clear coat over an opaque surface, as of glass (KHR_materials_clearcoat): it mirrors by a normal and a
// roughness of its own, and the surface sends out only light that the coat does not mirror. CPU reference:
// crates/gobo-reference/src/shading/coat.rs.

import package::features::HAS_COATS;
import package::records::point::{Coat, Point};
import package::shade::shading::{HEAD_ON, fresnel, highlight};

// Share of light that a coat mirrors to the eye. As in `mirrored_sky`, a rough one has no grazing reflection.
fn coat_mirrored(coat: Coat, to_eye: vec3<f32>) -> f32 {
    return coat.share * fresnel(dot(coat.normal, to_eye), max(1.0 - coat.roughness, HEAD_ON));
}

// Share of its light that a surface sends past its coat.
fn past_coat(point: Point, to_eye: vec3<f32>) -> f32 {
    if !HAS_COATS {
        return 1.0;
    }
    return 1.0 - coat_mirrored(point.coat, to_eye);
}

// Highlight under light from `toward` per unit of reflectance, times the cosine; `middle` as in `highlight`.
fn coat_shine(coat: Coat, toward: vec3<f32>, middle: vec3<f32>) -> f32 {
    return max(dot(coat.normal, toward), 0.0) * highlight(coat.normal, middle, coat.roughness);
}
