// blur, columns: the blurred filter map, and the nearest depth of the window.

import package::bind::sampled::{near_around, rows};
import package::bind::stored::{filters, nearests};
import package::blur::window::gaussian;
import package::records::view::GpuView;

fn start(view: GpuView, at: vec2<i32>) -> vec4<f32> {
    return vec4(0.0);
}

fn add(sum: vec4<f32>, view: GpuView, at: vec2<i32>, off: i32) -> vec4<f32> {
    return sum + textureLoad(rows, at, view.layer, 0) * gaussian(off);
}

fn store(view: GpuView, at: vec2<i32>, sum: vec4<f32>) {
    let near = textureLoad(near_around, at, view.layer, 0).rg;
    let light = select(vec3(1.0), sum.rgb / max(sum.w, 1e-30), sum.w > 0.0);
    textureStore(filters, at, view.layer, vec4(light, near.y));
    textureStore(nearests, at, view.layer, vec4(near.x));
}
