// Keeps the ambient light of a pixel's opaque surface, with the surface, for `occlusion`.

import package::bind::stored::ambients;
import package::records::point::{POINT_SOLID, load_point};
import package::records::surroundings::{Surroundings, pack_surroundings};
import package::shade::coat::past_coat;
import package::shade::point_light::ambient;
import package::shade::surface::eye;

const IS_LAST: bool = false;

// `index`: of the pixel in its band; `depth`: of its surface; `passed`: share of that surface's light that
// reaches the eye.
fn keep_ambient(pixel: vec2<u32>, index: u32, depth: f32, passed: vec3<f32>) {
    let point = load_point(index);
    let is_surface = point.kind == POINT_SOLID;
    let past = past_coat(point, normalize(eye() - point.position));
    let light = past * point.albedo * (1.0 - point.metallic) * ambient(point) * passed;
    // Spherical particles have flat depths.
    let normal = select(point.face, vec3(0.0), point.reach > 0.0);
    let shown = Surroundings(select(1.0, depth, is_surface), normal, select(vec3(0.0), light, is_surface));
    textureStore(ambients, pixel, pack_surroundings(shown));
}
