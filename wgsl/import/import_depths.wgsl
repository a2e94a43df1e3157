// import: the host's depth map -> opaque depths of a view. One invocation per texel. CPU reference:
// crates/gobo-reference/src/import.rs. Rust: src/stage/import.rs.

import package::bind::sampled::host_depths;
import package::bind::uniform::import_params;
import package::bind::updated::opaques;
import package::import::clip_ray::{ClipRay, across_axis, clip_ray};
import package::records::import::ImportParams;
import package::records::opaque_depth::opaque_bits;

override WORKGROUP_EDGE: u32;

fn light_depth(params: ImportParams, ray: ClipRay, depth: f32) -> f32 {
    let distance = (depth * ray.start.w - ray.start.z) / (ray.slope.z - depth * ray.slope.w);
    let light_depth = (distance - params.near) / (params.far - params.near);
    // A surface in front of the near plane still blocks. A NaN is no surface.
    return select(1.0, clamp(light_depth, 0.0, 1.0), depth != params.empty && light_depth <= 1.0);
}

@compute @workgroup_size(WORKGROUP_EDGE, WORKGROUP_EDGE)
fn import_depths(@builtin(global_invocation_id) id: vec3<u32>) {
    let params = import_params;
    let middle = vec2<f32>(id.xy) + 0.5;
    if any(middle > params.size) {
        return;
    }
    let across = across_axis(middle, params.size, params.scale);
    let ray = clip_ray(params.clip_from_view, across, params.perspective);
    let seen = ray.slope * params.far + ray.start;
    let pixel = (seen.xy / seen.w * vec2(0.5, -0.5) + 0.5) * params.host_size;
    let texel = clamp(pixel, vec2(0.0), params.host_size - 1.0);
    let imported = light_depth(params, ray, textureLoad(host_depths, vec2<u32>(texel), 0).x);
    let at = params.origin + id.xy;
    let depth = bitcast<f32>(opaque_bits(imported, false));
    let known = textureLoad(opaques, at, params.layer).x;
    textureStore(opaques, at, params.layer, vec4(select(min(depth, known), depth, params.replaces == 1u)));
}
