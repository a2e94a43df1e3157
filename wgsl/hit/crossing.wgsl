// Light that `over` adds, and sums of the faces of volumes. CPU reference:
// crates/gobo-reference/src/caster_hit.rs.

import package::bind::uniform::materials;
import package::features::HAS_TRIANGLES;
import package::hit::hit::Hit;
import package::hit::triangle::triangle_weights;
import package::records::footprint::{BACK_BIT, Footprint, setup_of, setup_texel};
import package::records::material::TRANSFER_OVER;
import package::records::view::GpuView;
import package::sums::sums::FIXED_ONE;

// Light added by `over`, which turns light L from the light's side into L * light + added: an affine chain.
fn added_light(hit: Hit) -> vec3<f32> {
    return select(vec3(0.0), hit.color * hit.opacity, materials[hit.material].transfer == TRANSFER_OVER);
}

// Nearest integers, modulo 2^32. Exact: the wraps are powers of two.
fn modular(v: vec3<f32>) -> vec3<i32> {
    let rounded = round(v);
    let rest = rounded - floor(rounded / 4294967296.0) * 4294967296.0;
    return bitcast<vec3<i32>>(vec3<u32>(rest));
}

// Crossing of a ray with the surface of a volume.
struct Face {
    depth: f32,            // at most the depth of the ray's end
    metres: f32,           // length of the ray from light depth 0 to 1
    absorption: vec3<f32>, // [1/m]
    leaves: i32,           // 1 if the ray leaves the volume, -1 if it enters, 0 for no face
}

// Faces behind the ray's end are moved to its end.
fn volume_face(view: GpuView, footprint: Footprint, texel: vec2<f32>, opaque_depth: f32) -> Face {
    if !HAS_TRIANGLES || !footprint.is_triangle {
        return Face(0.0, 0.0, vec3(0.0), 0);
    }
    let setup = setup_of(footprint);
    let absorption = materials[setup_texel(setup, 4u).w].absorption;
    let depth = triangle_weights(setup, texel).w;
    let is_back = (setup_texel(setup, 3u).w & BACK_BIT) != 0u;
    let counts = depth >= 0.0 && any(absorption > vec3(0.0));
    let slope = (texel - view.size * 0.5) / view.scale;
    let stretch = select(1.0, sqrt(1.0 + dot(slope, slope)), view.perspective > 0.0);
    let leaves = select(0, select(-1, 1, is_back), counts);
    let ends = select(0.0, min(depth, opaque_depth), counts);
    return Face(ends, (view.far - view.near) * stretch, absorption, leaves);
}

// Contribution of a face to a ray's sums: optical depth from the near plane to the face, in fixed point,
// modulo 2^32, negative where the ray enters; w: `leaves`.
fn face_crossing(face: Face) -> vec4<i32> {
    let tau = modular(face.depth * face.metres * face.absorption * FIXED_ONE);
    return vec4(tau * face.leaves, face.leaves);
}

fn crossing(view: GpuView, footprint: Footprint, texel: vec2<f32>, opaque_depth: f32) -> vec4<i32> {
    return face_crossing(volume_face(view, footprint, texel, opaque_depth));
}
