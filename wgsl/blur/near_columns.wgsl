// blur, nearest depths, columns: the nearest depths of the whole window.

import package::bind::sampled::near_rows;
import package::bind::stored::near_around;
import package::records::view::GpuView;

fn start(view: GpuView, at: vec2<i32>) -> vec3<f32> {
    return textureLoad(near_rows, at, view.layer, 0).rgb;
}

fn add(near: vec3<f32>, view: GpuView, at: vec2<i32>, off: i32) -> vec3<f32> {
    let other = textureLoad(near_rows, at, view.layer, 0).rgb;
    return vec3(select(near.xy, other.xy, other.x < near.x), min(near.z, other.z));
}

fn store(view: GpuView, at: vec2<i32>, near: vec3<f32>) {
    textureStore(near_around, at, view.layer, vec4(near, 0.0));
}
