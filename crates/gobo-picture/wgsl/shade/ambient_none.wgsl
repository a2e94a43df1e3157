// The picture's ambient light is not kept apart: no pass follows the bands.

const IS_LAST: bool = true;

fn keep_ambient(pixel: vec2<u32>, index: u32, depth: f32, passed: vec3<f32>) {}
