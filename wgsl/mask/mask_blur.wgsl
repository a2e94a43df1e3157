// mask, blur: a row or a column of a cross-bilateral Gaussian, all lights of a mask at once. One invocation
// per pixel and mask. CPU twin: src/reference/mask.rs. Host: src/stage/mask.rs.

import package::bind::sampled::{light_masks, mask_surfaces};
import package::bind::stored::new_masks;
import package::bind::uniform::mask_params;
import package::mask::mask_pixel::{mask_plane, surface_weight, view_point};
import package::records::mask::unpack_surface;

// Distance of the last tap in standard deviations: it counts e^-2 of the middle.
const WIDTHS: f32 = 2.0;

@compute @workgroup_size(8, 8)
fn mask_blur(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    let own = unpack_surface(textureLoad(mask_surfaces, id.xy, 0));
    let plane = mask_plane(id.xy, mask_params.step, own);
    let nearer = select(1.0, min(mask_params.depth_scale / plane.distance, 1.0), mask_params.depth_scale > 0.0);
    let width = max(f32(mask_params.taps) / WIDTHS * nearer, 0.01); // [pixels of the mask]
    // Not by the uniform alone: llvmpipe would compile the kernel again for its value.
    let side = i32(select(0u, mask_params.taps, own.depth < 1.0));
    var sum = textureLoad(light_masks, id.xy, id.z, 0);
    var weights = 1.0;
    for (var i = -side; i <= side; i += 1) {
        let at = vec2<i32>(id.xy) + vec2<i32>(mask_params.along) * i;
        let inside = all(at >= vec2(0)) && all(at < vec2<i32>(mask_params.size));
        let place = vec2<u32>(select(vec2<i32>(id.xy), at, inside));
        let other = unpack_surface(textureLoad(mask_surfaces, place, 0));
        let point = view_point(place, mask_params.step, other);
        let off = f32(i) / width;
        let counts = inside && i != 0 && other.depth < 1.0;
        let weight = select(0.0, exp(-0.5 * off * off) * surface_weight(plane, point, other.normal), counts);
        sum += textureLoad(light_masks, place, id.z, 0) * weight;
        weights += weight;
    }
    textureStore(new_masks, id.xy, id.z, sum / weights);
}
