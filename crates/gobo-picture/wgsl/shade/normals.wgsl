// Normals of casters in the picture.

import package::bind::sampled::triangles;
import package::bind::uniform::picture_params;
import package::records::footprint::{caster_of, load_footprint, setup_texel};
import package::records::pack::from_octahedral;
import package::records::record::{TRIANGLE_BIT, TRIANGLE_TEXELS, record_texel};
import package::shade::surface::toward;

// Geometric and interpolated normal, both on the side of the face that the eye sees. Near a silhouette, the
// interpolated normal may still point away from the eye.
struct Normals {
    face: vec3<f32>,
    normal: vec3<f32>,
}

// `id`: of the caster.
fn normals_at(id: u32, setup: u32, barycentric: vec3<f32>, to_eye: vec3<f32>) -> Normals {
    let face = toward(to_eye, face_normal(setup));
    return Normals(face, toward(face, triangle_normal(id & ~TRIANGLE_BIT, barycentric)));
}

// A point of a facet, moved out to the round surface that the facet's normals approximate, so that no facet
// shadows itself where that surface still faces the light (Hanika 2021, "Hacking the shadow terminator",
// section 4.2). `face`: of the facet, on the eye's side.
fn rounded(id: u32, barycentric: vec3<f32>, face: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    let first = (id & ~TRIANGLE_BIT) * TRIANGLE_TEXELS;
    let bits = textureLoad(triangles, record_texel(first + 4u), 0).xyz;
    var out = vec3(0.0);
    for (var i = 0u; i < 3u && any(bits.xy != bits.yz); i += 1u) {
        let corner = bitcast<vec3<f32>>(textureLoad(triangles, record_texel(first + i), 0).xyz);
        let normal = toward(face, from_octahedral(bits[i]));
        out += normal * (barycentric[i] * max(dot(normal, corner - point), 0.0));
    }
    return point + out;
}

// Caster of a pane, by its setup.
fn pane_caster(setup: u32) -> u32 {
    return caster_of(load_footprint(picture_params.first_setup + setup));
}

fn triangle_normal(id: u32, barycentric: vec3<f32>) -> vec3<f32> {
    let bits = textureLoad(triangles, record_texel(id * TRIANGLE_TEXELS + 4u), 0).xyz;
    let normal = from_octahedral(bits.x) * barycentric.x + from_octahedral(bits.y) * barycentric.y
        + from_octahedral(bits.z) * barycentric.z;
    return normal / max(length(normal), 1e-6);
}

fn face_normal(setup: u32) -> vec3<f32> {
    return from_octahedral(setup_texel(setup, 6u).z);
}
