// blur, rows: the sum of the filter over each row's window, and its weight.

import package::bind::sampled::{filters, near_around};
import package::bind::stored::rows;
import package::blur::window::{gaussian, sees};
import package::records::view::GpuView;

struct Sum {
    light: vec4<f32>, // and the weight
    near: f32,        // first translucent depth of the window
}

fn start(view: GpuView, at: vec2<i32>) -> Sum {
    return Sum(vec4(0.0), textureLoad(near_around, at, view.layer, 0).b);
}

fn add(sum: Sum, view: GpuView, at: vec2<i32>, off: i32) -> Sum {
    let weight = select(0.0, gaussian(off), sees(view, at, sum.near));
    let light = vec4(textureLoad(filters, at, view.layer, 0).rgb, 1.0);
    return Sum(sum.light + light * weight, sum.near);
}

fn store(view: GpuView, at: vec2<i32>, sum: Sum) {
    textureStore(rows, at, view.layer, sum.light);
}
