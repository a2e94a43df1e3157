// Look-up for point lights only: area lights give no penumbrae.

import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::lifted::Lifted;
import package::shade::receive::receive;

fn receive_light(light: GpuLight, index: u32, view: GpuView, lifted: Lifted) -> vec3<f32> {
    return receive(light, view, lifted);
}
