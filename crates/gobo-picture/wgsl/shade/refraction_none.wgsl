// The scene behind glass is seen straight through it.

const REFRACTS: bool = false;

fn keep_behind(pixel: vec2<u32>, depth: f32, light: vec3<f32>) {}

fn keep_bend(pixel: vec2<u32>, first: u32, pane: f32, passed: vec3<f32>) -> bool {
    return false;
}

fn keep_straight(pixel: vec2<u32>) {}
