// Filters of masks. CPU reference: crates/gobo-reference/src/mask.rs. Rust: src/stage/mask.rs.

import package::bind::sampled::{half_surfaces, mask_surfaces};
import package::bind::uniform::mask_params;
import package::mask::mask_group::{
    MaskGroup, MaskPlane, divided, either_group, even_group, load_group, mask_plane, plane_error, shown_pixel,
    store_group, surface_weight, upright_shares, weighted,
};
import package::records::mask::{surface_depth, surface_normal, surface_offset, unpack_surface};

// Distance of the last tap in standard deviations: it weighs e^-2 of the centre.
const WIDTHS: f32 = 2.0;

// Weighted sum of masks, and the sum of the weights.
struct Blurred {
    sum: MaskGroup,
    weights: f32,
}

fn with_tap(before: Blurred, plane: MaskPlane, at: vec2<i32>, group: u32, most: f32) -> Blurred {
    let inside = all(at >= vec2(0)) && all(at < vec2<i32>(mask_params.size));
    let texel = vec2<u32>(select(vec2(0), at, inside));
    let counts = surface_weight(plane, texel, mask_params.step, textureLoad(mask_surfaces, texel, 0));
    let weight = select(0.0, most * counts, inside);
    return Blurred(weighted(before.sum, load_group(texel, group), weight), before.weights + weight);
}

// mask, blur: a row or a column of a cross-bilateral Gaussian, for all lights of some masks at once. One
// invocation per pixel and group of masks.
@compute @workgroup_size(8, 8)
fn mask_blur(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(mask_surfaces, id.xy, 0));
    let plane = mask_plane(id.xy, mask_params.step, surface);
    let nearer = select(
        1.0,
        min(mask_params.depth_scale / plane.distance, 1.0),
        mask_params.depth_scale > 0.0,
    );
    let shares = select(vec2(1.0), upright_shares(plane, surface.face), mask_params.anisotropic != 0u);
    let upright = select(shares.x, shares.y, mask_params.column != 0u);
    let width = max(f32(mask_params.taps) / WIDTHS * nearer * upright, 0.01); // [pixels of the mask]
    // Gaussian by differences: the ratio of successive taps falls by a constant factor.
    let narrow = 0.5 / (width * width);
    var most = exp(-narrow);
    var falls = exp(-3.0 * narrow);
    let steeper = exp(-2.0 * narrow);
    let along = select(vec2(1, 0), vec2(0, 1), mask_params.column != 0u);
    // Not by the uniform alone: llvmpipe would recompile the kernel for its value.
    let side = i32(select(0u, mask_params.taps, surface.depth < 1.0));
    var blurred = Blurred(load_group(id.xy, id.z), 1.0);
    for (var i = 1; i <= side; i += 1) {
        blurred = with_tap(blurred, plane, vec2<i32>(id.xy) - along * i, id.z, most);
        blurred = with_tap(blurred, plane, vec2<i32>(id.xy) + along * i, id.z, most);
        most *= falls;
        falls *= steeper;
    }
    store_group(id.xy, id.z, divided(blurred.sum, blurred.weights));
}

// Sum of four weights below which only the best neighbour is used.
const MIN_WEIGHT: f32 = 1e-3;
// Error of a right angle between two normals, in units of the blur's tolerance in depth.
const TURNED: f32 = 8.0;

// mask, enlarge: masks of half the picture's size to its full size, from four neighbours on the same surface.
// One invocation per pixel and group of masks.
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
