// Look-up for point lights only: area lights give no penumbrae.

import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::receive::receive;

fn receive_light(light: GpuLight, index: u32, view: GpuView, at: vec3<f32>, point: vec3<f32>, normal: vec3<f32>, bias: f32) -> vec3<f32> {
    return receive(light, view, at, bias);
}
