// Look-up without light that glass and lit surfaces throw.

import package::records::light::GpuLight;
import package::records::point::Point;

fn with_thrown(light: GpuLight, point: vec3<f32>, straight: vec3<f32>) -> vec3<f32> {
    return straight;
}

fn with_bounced(point: Point, light: vec3<f32>) -> vec3<f32> {
    return light;
}
