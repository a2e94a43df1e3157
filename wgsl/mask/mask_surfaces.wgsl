// mask, surfaces: what the camera sees that is solid, as masks read it. One invocation per pixel of a band,
// after `shade_surfaces`. CPU twin: src/reference/mask.rs. Host: src/stage/mask.rs.

import package::bind::sampled::seen_pixels;
import package::bind::stored::mask_surfaces;
import package::bind::uniform::views;
import package::records::mask::ROUND_BIT;
import package::records::octahedral::octahedral;
import package::records::point::{POINT_SOLID, load_point};
import package::records::record::{TRIANGLE_BIT, record_texel};
import package::shade::band::band_pixel;
import package::walk::lane::LANES;

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
    let bits = point.receives | select(0u, ROUND_BIT, is_round) | (point.tag << 16u);
    let last = select(octahedral(point.normal), bitcast<u32>(point.reach), is_round);
    let shown = vec4(seen.x, octahedral(point.face), last, bits);
    let nothing = vec4(bitcast<u32>(1.0), 0u, 0u, 0u);
    textureStore(mask_surfaces, at.pixel, select(nothing, shown, point.kind == POINT_SOLID));
}
