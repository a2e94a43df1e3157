// mask, enlarge: masks of half the picture's size to its full size, from four neighbours on the same surface.
// One invocation per pixel and group of masks. CPU reference: crates/gobo-reference/src/mask.rs. Rust:
// src/stage/mask.rs.

import package::bind::sampled::{half_surfaces, mask_surfaces};
import package::bind::uniform::mask_params;
import package::mask::mask_group::{divided, either_group, even_group, load_group, store_group, weighted};
import package::mask::mask_pixel::{mask_plane, plane_error, shown_pixel, surface_weight};
import package::records::mask::{surface_depth, surface_normal, surface_offset, unpack_surface};

// Sum of four weights below which only the best neighbour is used.
const MIN_WEIGHT: f32 = 1e-3;
// Error of a right angle between two normals, in units of the blur's tolerance in depth.
const TURNED: f32 = 8.0;

@compute @workgroup_size(8, 8)
fn mask_enlarge(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(mask_surfaces, id.xy, 0));
    let plane = mask_plane(id.xy, 1u, surface);
    let last = vec2<i32>(textureDimensions(half_surfaces)) - 1;
    let middle = (vec2<f32>(id.xy) + 0.5) * 0.5 - 0.5;
    let first = floor(middle);
    let share = middle - first;
    var sum = even_group(0.0);
    var weights = 0.0;
    var best = even_group(1.0);
    var least = 1e30;
    // The loop count is not constant, so that compilers do not unroll.
    let count = select(0u, 4u, surface.depth < 1.0);
    for (var i = 0u; i < count; i += 1u) {
        let step = vec2(i & 1u, i >> 1u);
        let texel = vec2<u32>(clamp(vec2<i32>(first) + vec2<i32>(step), vec2(0), last));
        let other = textureLoad(half_surfaces, texel, 0);
        let depth = surface_depth(other);
        let turned = 1.0 - dot(plane.normal, surface_normal(other));
        let off = plane_error(plane, shown_pixel(texel, 2u, surface_offset(other)), depth) + TURNED * turned;
        let error = select(off, 1e20, depth >= 1.0);
        let near = mix(1.0 - share, share, vec2<f32>(step));
        let weight = near.x * near.y * surface_weight(plane, texel, 2u, other);
        let value = load_group(texel, id.z);
        sum = weighted(sum, value, weight);
        weights += weight;
        best = either_group(best, value, error < least);
        least = min(least, error);
    }
    let mean = divided(sum, max(weights, 1e-9));
    store_group(id.xy, id.z, either_group(best, mean, weights > MIN_WEIGHT));
}
