// shade, casters: the light that reaches the middle of each particle that is seen and not solid,
// through the shadow maps. One invocation per footprint of the camera's view. CPU twin:
// src/reference/shading/mod.rs. Host: src/stage/shade.rs.

import package::bind::loaded::{footprints, rects};
import package::bind::sampled::casters;
import package::bind::stored::lit;
import package::bind::uniform::{materials, picture_params};
import package::records::light::{LightList, cluster_lights, listed_light};
import package::records::record::{FOOTPRINT_TEXELS, TRIANGLE_BIT, record_texel};
import package::shade::receive::{incoming, shadow};
import package::shade::receiver::set_receiver;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_casters(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let footprint = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if footprint >= picture_params.footprint_count || textureLoad(rects, record_texel(footprint)).g == 0u {
        return;
    }
    let caster = textureLoad(footprints, record_texel(footprint * FOOTPRINT_TEXELS + 1u)).w;
    if (caster & TRIANGLE_BIT) != 0u {
        return;
    }
    let place = bitcast<vec4<f32>>(textureLoad(casters, record_texel(caster * 2u), 0));
    let seen = bitcast<vec4<f32>>(textureLoad(footprints, record_texel(footprint * FOOTPRINT_TEXELS)));
    let look = textureLoad(casters, record_texel(caster * 2u + 1u), 0);
    set_receiver(materials[look.z & 0xffffu], look.w);
    let light = light_particle(place.xyz, place.w, cluster_lights(seen.xy, seen.w));
    textureStore(lit, record_texel(footprint), vec4(light, 1.0));
}

// Of colour 1. Scatters alike in all directions; smoke is thick enough to scatter more than once,
// so that it is half as bright as paper that faces the light.
fn light_particle(point: vec3<f32>, radius: f32, list: LightList) -> vec3<f32> {
    var sum = picture_params.ambient;
    for (var i = 0u; i < list.count; i += 1u) {
        let light = listed_light(list, i);
        let arriving = incoming(light, point);
        if any(arriving.color > vec3(0.0)) {
            // Not behind itself: the bias is its radius.
            let passed = shadow(light, point, vec3(0.0), arriving.toward, picture_params.bias + radius);
            sum += arriving.color * passed * 0.15915494;
        }
    }
    return sum;
}
