// Hit of a ray with a triangle. CPU reference: src/reference/caster_hit.rs.

import package::bind::sampled::images;
import package::bind::uniform::materials;
import package::features::HAS_TEXTURES;
import package::hit::hit::{Hit, absorption, transmittance};
import package::hit::texture::sample_texture;
import package::records::material::{MAX_GAIN, NO_TEXTURE, TRANSFER_GAIN};
import package::records::setup::setup_texel;

fn edge(setup: u32, i: u32, texel: vec2<f32>) -> f32 {
    let line = bitcast<vec4<f32>>(setup_texel(setup, i));
    return line.z * (texel.y - line.y) - line.w * (texel.x - line.x);
}

// Barycentric weights of the corners, and light depth; depth -1 outside.
fn triangle_weights(setup: u32, texel: vec2<f32>) -> vec4<f32> {
    let weights_ties = setup_texel(setup, 3u);
    let a = edge(setup, 0u, texel);
    let b = edge(setup, 1u, texel);
    let c = edge(setup, 2u, texel);
    let e = vec3(a, b, c);
    let tie = (vec3(weights_ties.w) & vec3(1u, 2u, 4u)) != vec3(0u);
    let inside = all((e > vec3(0.0)) | ((e == vec3(0.0)) & tie));
    let weighted = e * bitcast<vec3<f32>>(weights_ties.xyz);
    let sum = weighted.x + weighted.y + weighted.z;
    let barycentric = weighted / sum;
    let depths = bitcast<vec3<f32>>(setup_texel(setup, 4u).xyz);
    return vec4(barycentric, select(-1.0, dot(depths, barycentric), inside && sum > 0.0));
}

fn triangle_uv(setup: u32, barycentric: vec3<f32>) -> vec2<f32> {
    let ab = bitcast<vec4<f32>>(setup_texel(setup, 5u));
    let c = bitcast<vec2<f32>>(setup_texel(setup, 6u).xy);
    return ab.xy * barycentric.x + ab.zw * barycentric.y + c * barycentric.z;
}

fn triangle_hit(setup: u32, texel: vec2<f32>) -> Hit {
    let met = triangle_weights(setup, texel);
    let material_id = setup_texel(setup, 4u).w;
    let material = materials[material_id];
    var tint = material.tint;
    if HAS_TEXTURES && material.texture != NO_TEXTURE {
        let uv = triangle_uv(setup, met.xyz);
        tint *= sample_texture(images, material.texture, material.texture_size, uv);
    }
    let opacity = 1.0 - (1.0 - tint.a) * (1.0 - material.reflectivity);
    let color = select(tint.rgb, tint.rgb / MAX_GAIN, material.transfer == TRANSFER_GAIN);
    let light = transmittance(material.transfer, opacity, color);
    let absorbed = absorption(material.transfer, opacity, color);
    return Hit(light, color, opacity, met.w, met.w, met.w, material_id, absorbed);
}
