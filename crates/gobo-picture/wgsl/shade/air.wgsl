// Light that the air scatters to the eye, as a volume: layer k of a column of pixels holds the light
// scattered between the eye and the end of slice k. The transmittance follows from the length. CPU reference:
// crates/gobo-reference/src/air.rs. Rust: `AirParams` in src/records/air.rs.

import package::bind::sampled::air;
import package::bind::uniform::picture_params;
import package::records::air_params::AIR_CELL;
import package::records::view::GpuView;
import package::shade::sample_offset::air_shift;

struct AirBefore {
    light: vec3<f32>, // scattered to the eye
    left: vec3<f32>,  // transmittance for the light from behind it
}

// Air in front of light depth `depth` in the camera's view.
fn air_at(view: GpuView, pixel: vec2<f32>, depth: f32) -> AirBefore {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let length = clamp(depth, 0.0, 1.0) * picture_params.depth_range * sqrt(1.0 + dot(slope, slope));
    return AirBefore(air_light(pixel - air_shift(view), depth), exp(-picture_params.extinction * length));
}

// `pixel`: from the first column on.
fn air_light(pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    let size = vec2<i32>(textureDimensions(air));
    let slices = i32(picture_params.air_slices);
    let at = clamp(pixel / f32(AIR_CELL) - 0.5, vec2(0.0), vec2<f32>(size - 1));
    let low = vec2<i32>(floor(at));
    let high = min(low + 1, size - 1);
    let part = at - floor(at);
    // In front of the first slice there is none.
    let along = clamp(depth, 0.0, 1.0) * f32(slices) - 1.0;
    let slice = i32(floor(along));
    let near = air_layer(low, high, part, slice);
    let far = air_layer(low, high, part, min(slice + 1, slices - 1));
    return mix(near, far, along - floor(along));
}

fn air_layer(low: vec2<i32>, high: vec2<i32>, part: vec2<f32>, slice: i32) -> vec3<f32> {
    let layer = max(slice, 0);
    let top = mix(textureLoad(air, low, layer, 0), textureLoad(air, vec2(high.x, low.y), layer, 0), part.x);
    let bottom = mix(textureLoad(air, vec2(low.x, high.y), layer, 0), textureLoad(air, high, layer, 0), part.x);
    return select(mix(top, bottom, part.y).rgb, vec3(0.0), slice < 0);
}
