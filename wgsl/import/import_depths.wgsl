// import: a depth map of the host's -> opaque depths of a view. One invocation per texel. CPU twin:
// src/reference/import.rs. Host: src/stage/import.rs.

import package::bind::sampled::host_depths;
import package::bind::uniform::import_params;
import package::bind::updated::opaques;
import package::records::import::ImportParams;
import package::records::opaque_depth::opaque_bits;

override WORKGROUP_EDGE: u32;

// A ray through our texel is one of the host's camera too: along it, clip coordinates are
// `slope * distance + start`, `distance` along our axis [m].
struct ClipRay {
    slope: vec4<f32>,
    start: vec4<f32>,
}

fn clip_ray(params: ImportParams, texel: vec2<f32>) -> ClipRay {
    let across = (texel - params.size * 0.5) / params.scale * vec2(1.0, -1.0);
    let clip = params.clip_from_view;
    let spreads = params.perspective > 0.0;
    let slope = select(-clip[2], clip * vec4(across, -1.0, 0.0), spreads);
    return ClipRay(slope, select(clip * vec4(across, 0.0, 1.0), clip[3], spreads));
}

fn light_depth(params: ImportParams, ray: ClipRay, depth: f32) -> f32 {
    let distance = (depth * ray.start.w - ray.start.z) / (ray.slope.z - depth * ray.slope.w);
    let own = (distance - params.near) / (params.far - params.near);
    // What is before the near plane blocks all the same. A NaN is none.
    return select(1.0, clamp(own, 0.0, 1.0), depth != params.empty && own <= 1.0);
}

@compute @workgroup_size(WORKGROUP_EDGE, WORKGROUP_EDGE)
fn import_depths(@builtin(global_invocation_id) id: vec3<u32>) {
    let params = import_params;
    let middle = vec2<f32>(id.xy) + 0.5;
    if any(middle > params.size) {
        return;
    }
    let ray = clip_ray(params, middle);
    let seen = ray.slope * params.far + ray.start;
    let place = (seen.xy / seen.w * vec2(0.5, -0.5) + 0.5) * params.host_size;
    let texel = clamp(place, vec2(0.0), params.host_size - 1.0);
    let imported = light_depth(params, ray, textureLoad(host_depths, vec2<u32>(texel), 0).x);
    let at = params.origin + id.xy;
    let depth = bitcast<f32>(opaque_bits(imported, false));
    let own = textureLoad(opaques, at, params.layer).x;
    textureStore(opaques, at, params.layer, vec4(select(min(depth, own), depth, params.replaces == 1u)));
}
