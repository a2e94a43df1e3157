// Properties of an opaque surface that images give texel by texel. CPU reference:
// crates/gobo-reference/src/shade/details.rs, crates/gobo-reference/src/shade/mod.rs,
// crates/gobo-reference/src/shade/seen.rs.

import package::bind::sampled::triangles;
import package::bind::uniform::materials;
import package::features::{HAS_COATS, HAS_DETAILS, HAS_FAR_SIDES, HAS_TEXTURES};
import package::hit::triangle::triangle_image;
import package::records::material::{DETAILS_SHIFT, GpuMaterial, NO_TEXTURE, far_side_of};
import package::records::point::{Coat, NO_COAT};
import package::records::record::{TRIANGLE_BIT, TRIANGLE_TEXELS, record_texel};
import package::shade::normals::triangle_normal;

struct Details {
    normal: vec3<f32>, // unit, on the eye's side of the face
    open: f32,         // share of the ambient light that gets there
    roughness: f32,
    metallic: f32,
    coat: Coat,
}

// `normal`: interpolated, on the eye's side.
fn details_at(
    material: GpuMaterial,
    setup: u32,
    pixel: vec2<f32>,
    barycentric: vec3<f32>,
    id: u32,
    normal: vec3<f32>,
) -> Details {
    var found = Details(normal, 1.0, material.roughness, material.metallic, NO_COAT);
    let index = material.shows >> DETAILS_SHIFT;
    if HAS_DETAILS && index != 0u {
        let details = materials[index - 1u];
        if details.texture != NO_TEXTURE {
            let size = details.texture_size;
            let rgb = triangle_image(details.texture, size, setup, pixel, barycentric, true).rgba.rgb;
            found = Details(normal, rgb.x, rgb.y, rgb.z, NO_COAT);
        }
        if details.emissive_texture != NO_TEXTURE {
            let layer = details.emissive_texture;
            let rgb = triangle_image(layer, details.emissive_size, setup, pixel, barycentric, true).rgba.rgb;
            found.normal = bent(id & ~TRIANGLE_BIT, barycentric, normal, rgb * 2.0 - 1.0);
        }
        let coat = details.shows >> DETAILS_SHIFT;
        if HAS_COATS && coat != 0u {
            found.coat = coat_at(materials[coat - 1u], setup, pixel, barycentric, id, normal);
        }
    }
    return found;
}

fn coat_at(
    material: GpuMaterial,
    setup: u32,
    pixel: vec2<f32>,
    barycentric: vec3<f32>,
    id: u32,
    normal: vec3<f32>,
) -> Coat {
    var found = Coat(material.reflectivity, material.roughness, normal);
    if material.texture != NO_TEXTURE {
        let size = material.texture_size;
        let rgb = triangle_image(material.texture, size, setup, pixel, barycentric, true).rgba.rgb;
        found = Coat(rgb.x, rgb.y, normal);
    }
    if material.emissive_texture != NO_TEXTURE {
        let layer = material.emissive_texture;
        let rgb = triangle_image(layer, material.emissive_size, setup, pixel, barycentric, true).rgba.rgb;
        found.normal = bent(id & ~TRIANGLE_BIT, barycentric, normal, rgb * 2.0 - 1.0);
    }
    return found;
}

// Place of a corner, with its texture coordinate u.
fn corner_at(id: u32, i: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(textureLoad(triangles, record_texel(id * TRIANGLE_TEXELS + i), 0));
}

// The normal of an image in the frame of a triangle: along u, against v, and off the surface. The side that
// is seen from behind has the same normals turned round.
fn bent(id: u32, barycentric: vec3<f32>, normal: vec3<f32>, by: vec3<f32>) -> vec3<f32> {
    let a = corner_at(id, 0u);
    let right = corner_at(id, 1u) - a;
    let up = corner_at(id, 2u) - a;
    let v = bitcast<vec3<f32>>(textureLoad(triangles, record_texel(id * TRIANGLE_TEXELS + 3u), 0).xyz);
    let rows = v.yz - v.x;
    let mirrors = sign(right.w * rows.y - up.w * rows.x);
    let side = select(-1.0, 1.0, dot(normal, triangle_normal(id, barycentric)) >= 0.0);
    let along = flat_axis((right.xyz * rows.y - up.xyz * rows.x) * (mirrors * side), normal);
    let against = flat_axis((right.xyz * up.w - up.xyz * right.w) * (mirrors * side), normal);
    let found = along * by.x + against * by.y + normal * by.z;
    let size = length(found);
    return select(normal, found / max(size, 1e-6), size > 1e-6);
}

// Part of an axis in the plane of a normal, unit; zero for none.
fn flat_axis(axis: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let unit = axis / max(max(abs(axis.x), max(abs(axis.y), abs(axis.z))), 1e-30);
    let flat = unit - normal * dot(unit, normal);
    return flat / max(length(flat), 1e-6);
}

// Emission of a triangle.
fn emission_at(material: GpuMaterial, setup: u32, pixel: vec2<f32>, barycentric: vec3<f32>) -> vec3<f32> {
    if HAS_TEXTURES && material.emissive_texture != NO_TEXTURE {
        let layer = material.emissive_texture;
        let size = material.emissive_size;
        return material.emission * triangle_image(layer, size, setup, pixel, barycentric, true).rgba.rgb;
    }
    return material.emission;
}

// Light that surfaces scatter to their far side.
struct FarSide {
    is_there: bool,
    color: vec3<f32>, // share of the light from the far side that is scattered
    near: f32,        // share of the light on this side that stays
}

fn far_side(material: GpuMaterial, setup: u32, pixel: vec2<f32>, barycentric: vec3<f32>) -> FarSide {
    let index = far_side_of(material);
    if !HAS_FAR_SIDES || index == 0u {
        return FarSide(false, vec3(0.0), 1.0);
    }
    let far = materials[index - 1u];
    var color = far.tint.rgb;
    if HAS_TEXTURES && far.texture != NO_TEXTURE {
        color *= triangle_image(far.texture, far.texture_size, setup, pixel, barycentric, false).rgba.rgb;
    }
    return FarSide(true, color, 1.0 - far.transmission);
}
