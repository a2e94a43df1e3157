// mask, host surfaces: a host's depths, and its normals or normals derived from the depths, in the format of
// masks. One invocation per pixel. CPU reference: crates/gobo-reference/src/mask.rs. Rust: src/stage/mask.rs.

import choice::keep::keep_surface;
import package::bind::sampled::{host_depths, host_normals};
import package::bind::uniform::{host_view, views};
import package::records::mask::{
    MaskPoint, MaskSurface, NORMALS_NONE, NORMALS_UNORM, NO_SURFACE, packed_mask_point, packed_surface,
};
import package::records::material::RECEIVES_CURVE;
import package::shade::surface::{eye, toward, world_point};

const LAST_DEPTH: f32 = 0.99999994; // the largest below 1, which is no surface

struct HostSeen {
    depth: f32,          // light depth; 1 without a surface
    position: vec3<f32>, // world space [m]
}

// Surface at a pixel, clamped to the picture.
fn host_seen(at: vec2<i32>) -> HostSeen {
    let view = views[0];
    let pixel = clamp(at, vec2(0), vec2<i32>(view.size) - 1);
    let depth = textureLoad(host_depths, vec2<u32>(pixel), 0).x;
    let middle = vec2<f32>(pixel) + 0.5;
    let ndc = (middle / view.size * 2.0 - 1.0) * vec2(1.0, -1.0);
    let clip = host_view.world_from_clip * vec4(ndc, depth, 1.0);
    let world = clip.xyz / clip.w;
    let distance = -(view.view_from_world * vec4(world, 1.0)).z;
    let seen = clamp((distance - view.near) / (view.far - view.near), 0.0, LAST_DEPTH);
    let is_light = host_view.is_light_depth != 0u;
    return HostSeen(
        select(select(1.0, seen, depth != host_view.empty), depth, is_light),
        select(world, world_point(view, middle, depth), is_light),
    );
}

// Vector along the surface from or to the neighbour that is nearer in depth, since that one is likelier on
// the same surface.
fn along(before: HostSeen, seen: HostSeen, after: HostSeen) -> vec3<f32> {
    let is_before = abs(before.depth - seen.depth) < abs(after.depth - seen.depth);
    return select(after.position - seen.position, seen.position - before.position, is_before);
}

fn host_normal(pixel: vec2<i32>, seen: HostSeen) -> vec3<f32> {
    let right = along(host_seen(pixel - vec2(1, 0)), seen, host_seen(pixel + vec2(1, 0)));
    let down = along(host_seen(pixel - vec2(0, 1)), seen, host_seen(pixel + vec2(0, 1)));
    let texel = textureLoad(host_normals, vec2<u32>(pixel), 0).xyz;
    let given = select(texel, texel * 2.0 - 1.0, host_view.normals == NORMALS_UNORM);
    let turned = (host_view.world_from_normal * vec4(given, 0.0)).xyz;
    // No branch: llvmpipe would recompile the kernel for the uniform's value.
    return normalize(select(turned, cross(down, right), host_view.normals == NORMALS_NONE));
}

@compute @workgroup_size(8, 8)
fn mask_host_surfaces(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<u32>(views[0].size);
    if any(id.xy >= size) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let seen = host_seen(pixel);
    let normal = toward(eye() - seen.position, host_normal(pixel, seen));
    let shown = MaskSurface(seen.depth, normal, normal, 0.0, vec2(0u));
    let surface = select(NO_SURFACE, packed_surface(shown, false), seen.depth < 1.0);
    let packed = packed_mask_point(MaskPoint(seen.position, RECEIVES_CURVE, 0u));
    let corner = vec2<i32>(id.xy & vec2(0xfffffffeu));
    let depths = vec4(
        host_seen(corner).depth,
        host_seen(corner + vec2(1, 0)).depth,
        host_seen(corner + vec2(0, 1)).depth,
        host_seen(corner + vec2(1, 1)).depth,
    );
    keep_surface(id.xy, surface, packed, depths);
}
