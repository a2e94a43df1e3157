// Columns of air around a pixel.

import package::records::air_params::AIR_CELL;
import package::records::view::GpuView;
import package::shade::sample_offset::air_shift;

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
