// Choices of a picture without a shadow catcher, occlusion, refraction, masks and light that surfaces send
// on.

import package::records::point::Point;

// No surface shows the surroundings behind it.
fn caught(point: Point, catches: bool, to_eye: vec3<f32>) -> Point {
    return point;
}

// The picture's ambient light is not kept apart: no pass follows the bands.

const IS_LAST: bool = true;

fn keep_ambient(pixel: vec2<u32>, index: u32, depth: f32, passed: vec3<f32>) {}

// The scene behind glass is seen straight through it.

const REFRACTS: bool = false;

fn keep_behind(pixel: vec2<u32>, depth: f32, light: vec3<f32>) {}

fn keep_bend(pixel: vec2<u32>, first: u32, pane: f32, passed: vec3<f32>) -> bool {
    return false;
}

fn keep_straight(pixel: vec2<u32>) {}

// Share of a light from its mask, 1 without a mask; and whether it has one.
struct Masked {
    share: vec3<f32>,
    is_masked: bool,
}

fn masked(light: u32, point: Point) -> Masked {
    return Masked(vec3(1.0), false);
}

// No surface sends light to others.
fn with_bounced(point: Point, light: vec3<f32>) -> vec3<f32> {
    return light;
}
