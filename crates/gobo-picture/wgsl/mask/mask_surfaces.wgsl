// mask, surfaces: visible opaque surfaces in the format of masks. One invocation per pixel of a band, after
// `shade_surfaces`. CPU reference: crates/gobo-reference/src/mask.rs. Rust: src/stage/mask.rs.

import package::bind::picture_in::seen_pixels;
import package::bind::uniform::views;
import package::records::mask::{MaskPoint, MaskSurface, NO_SURFACE, packed_mask_point, packed_surface};
import package::records::point::{POINT_SOLID, load_point};
import package::records::record::{TRIANGLE_BIT, record_texel};
import package::records::view::TILE_SIZE;
import package::shade::band::band_pixel;
import package::traversal::lane::LANES;
import choice::keep::keep_surface;

// Light depth at a pixel, clamped to the picture; `index`: of `pixel` in the band.
fn seen_depth(at: vec2<u32>, pixel: vec2<u32>, index: u32) -> f32 {
    let last = vec2<u32>(views[0].size) - 1u;
    // Both pixels are in the same tile.
    let aside = vec2<i32>(min(at, last)) - vec2<i32>(pixel);
    let neighbour = u32(i32(index) + aside.y * i32(TILE_SIZE) + aside.x);
    return bitcast<f32>(textureLoad(seen_pixels, record_texel(neighbour), 0).x);
}

@compute @workgroup_size(LANES)
fn mask_surfaces_of(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = views[0];
    let at = band_pixel(workgroup, workgroups, lane, view.tiles_x);
    if any(at.pixel >= vec2<u32>(view.size)) {
        return;
    }
    let point = load_point(at.index);
    let seen = textureLoad(seen_pixels, record_texel(at.index), 0);
    let is_round = (seen.y & TRIANGLE_BIT) == 0u;
    let shown = MaskSurface(bitcast<f32>(seen.x), point.normal, point.face, point.reach, vec2(0u));
    let surface = select(NO_SURFACE, packed_surface(shown, is_round), point.kind == POINT_SOLID);
    let packed = packed_mask_point(MaskPoint(point.position, point.receives, point.tag));
    let corner = at.pixel & vec2(0xfffffffeu);
    let depths = vec4(
        seen_depth(corner, at.pixel, at.index),
        seen_depth(corner + vec2(1u, 0u), at.pixel, at.index),
        seen_depth(corner + vec2(0u, 1u), at.pixel, at.index),
        seen_depth(corner + vec2(1u, 1u), at.pixel, at.index),
    );
    keep_surface(at.pixel, surface, packed, depths);
}
