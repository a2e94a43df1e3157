// Offset of a picture's sample from the middles of its pixels. CPU reference: `sample_offset` in
// crates/gobo-reference/src/air.rs.

import package::bind::uniform::picture_params;
import package::records::air_params::AIR_CELL;
import package::records::view::GpuView;

// Offset [pixels]; within a pixel, the one that belongs to the point on the lens: the shear of the camera's
// axis (`View::through` in src/view/mod.rs).
fn sample_offset(view: GpuView) -> vec2<f32> {
    let right = picture_params.world_from_view[0].xyz;
    let up = picture_params.world_from_view[1].xyz;
    let back = picture_params.world_from_view[2].xyz;
    let offset = vec2(-dot(back, right), dot(back, up)) * view.scale;
    return select(offset, offset - round(offset), any(abs(offset) > vec2(1.0)));
}

// First column of air [pixels]: columns of several samples interleave, so that their mean is finer.
fn air_shift(view: GpuView) -> vec2<f32> {
    return sample_offset(view) * f32(AIR_CELL);
}
