// mask, enlarge: masks of half the picture's size to its own, of four neighbours those on the same surface.
// One invocation per pixel and mask. CPU twin: src/reference/mask.rs. Host: src/stage/mask.rs.

import package::bind::sampled::{half_surfaces, light_masks, mask_surfaces};
import package::bind::stored::new_masks;
import package::bind::uniform::mask_params;
import package::mask::mask_pixel::{mask_plane, plane_error, surface_weight, view_point};
import package::records::mask::unpack_surface;

// Sum of four weights below which the best neighbour alone is taken.
const LEAST_WEIGHT: f32 = 1e-3;
// What a right angle between two surfaces counts as, in what the blur tolerates of depth.
const TURNED: f32 = 8.0;

@compute @workgroup_size(8, 8)
fn mask_enlarge(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    let own = unpack_surface(textureLoad(mask_surfaces, id.xy, 0));
    let plane = mask_plane(id.xy, 1u, own);
    let last = vec2<i32>(textureDimensions(half_surfaces)) - 1;
    let middle = (vec2<f32>(id.xy) + 0.5) * 0.5 - 0.5;
    let first = floor(middle);
    let share = middle - first;
    var sum = vec4(0.0);
    var weights = 0.0;
    var best = vec4(1.0);
    var least = 1e30;
    // No constant ends the loop: compilers would write it out.
    let count = select(0u, 4u, own.depth < 1.0);
    for (var i = 0u; i < count; i += 1u) {
        let step = vec2(i & 1u, i >> 1u);
        let place = vec2<u32>(clamp(vec2<i32>(first) + vec2<i32>(step), vec2(0), last));
        let other = unpack_surface(textureLoad(half_surfaces, place, 0));
        let point = view_point(place, 2u, other);
        let off = plane_error(plane, point) + TURNED * (1.0 - dot(plane.world, other.normal));
        let error = select(off, 1e20, other.depth >= 1.0);
        let near = mix(1.0 - share, share, vec2<f32>(step));
        let counts = select(0.0, surface_weight(plane, point, other.normal), other.depth < 1.0);
        let weight = near.x * near.y * counts;
        let value = textureLoad(light_masks, place, id.z, 0);
        sum += value * weight;
        weights += weight;
        best = select(best, value, error < least);
        least = min(least, error);
    }
    let shown = select(best, sum / max(weights, 1e-9), weights > LEAST_WEIGHT);
    textureStore(new_masks, id.xy, id.z, shown);
}
