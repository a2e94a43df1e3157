// shade, keep: visible opaque surfaces and their light, for pictures through further samples of the pixels
// (crates/gobo-picture/wgsl/shade/taken_light.wgsl). One invocation per pixel of a band. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::{lit, seen_pixels};
import package::bind::picture_out::first_surfaces;
import package::bind::uniform::views;
import package::records::point::load_point;
import package::records::record::record_texel;
import package::shade::band::band_pixel;
import package::shade::taken_light::packed_surface;
import package::traversal::lane::LANES;

@compute @workgroup_size(LANES)
fn shade_keep(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = views[0];
    let at = band_pixel(workgroup, workgroups, lane, view.tiles_x);
    if any(at.pixel >= vec2<u32>(view.size)) {
        return;
    }
    let depth = textureLoad(seen_pixels, record_texel(at.index), 0).x;
    let light = textureLoad(lit, record_texel(at.index), 0).rgb;
    textureStore(first_surfaces, at.pixel, packed_surface(light, load_point(at.index).tag, depth));
}
