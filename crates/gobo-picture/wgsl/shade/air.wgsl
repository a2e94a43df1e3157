// Light that the air scatters to the eye, as a volume: layer k of a column of pixels holds the light
// scattered between the eye and the end of slice k. The transmittance follows from the length. CPU reference:
// crates/gobo-reference/src/air.rs. Rust: `AirParams` in src/records/air.rs.

import package::bind::picture_in::air;
import package::bind::uniform::picture_params;
import package::records::picture::AIR_CELL;
import package::records::view::GpuView;

struct AirBefore {
    light: vec3<f32>, // scattered to the eye
    left: vec3<f32>,  // transmittance for the light from behind it
}

// Air in front of light depth `depth` in the camera's view.
fn air_at(view: GpuView, pixel: vec2<f32>, depth: f32) -> AirBefore {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let length = clamp(depth, 0.0, 1.0) * picture_params.depth_range * sqrt(1.0 + dot(slope, slope));
    let place = air_place(view, pixel, vec2<i32>(textureDimensions(air)));
    return AirBefore(air_light(place, depth), exp(-picture_params.extinction * length));
}

// Light scattered in front of `depth`. The pixel's surface is at `depth` or behind: `air_reach` has asked for
// these slices.
fn air_light(place: AirPlace, depth: f32) -> vec3<f32> {
    let slices = i32(picture_params.air_slices);
    // The first slice begins at the eye, without light.
    let along = clamp(depth, 0.0, 1.0) * f32(slices) - 1.0;
    let slice = i32(floor(along));
    let near = air_layer(place, slice);
    let far = air_layer(place, min(slice + 1, slices - 1));
    return mix(near, far, along - floor(along));
}

fn air_layer(place: AirPlace, slice: i32) -> vec3<f32> {
    let low = place.low;
    let high = place.high;
    let part = place.part;
    let layer = max(slice, 0);
    let top = mix(textureLoad(air, low, layer, 0), textureLoad(air, vec2(high.x, low.y), layer, 0), part.x);
    let bottom = mix(
        textureLoad(air, vec2(low.x, high.y), layer, 0),
        textureLoad(air, high, layer, 0),
        part.x,
    );
    return select(mix(top, bottom, part.y).rgb, vec3(0.0), slice < 0);
}

// The columns around a pixel, and its place between them, 0..1.
struct AirPlace {
    low: vec2<i32>,
    high: vec2<i32>,
    part: vec2<f32>,
}

// `size`: columns of the picture.
fn air_place(view: GpuView, pixel: vec2<f32>, size: vec2<i32>) -> AirPlace {
    // Relative to the first column.
    let from_first = pixel - air_shift(view);
    let at = clamp(from_first / f32(AIR_CELL) - 0.5, vec2(0.0), vec2<f32>(size - 1));
    let low = vec2<i32>(floor(at));
    return AirPlace(low, min(low + 1, size - 1), at - floor(at));
}

// Offset of a picture's sample from the middles of its pixels [pixels]; within a pixel, the one that belongs
// to the point on the lens: the shear of the camera's axis (`View::through` in src/view/mod.rs).
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
