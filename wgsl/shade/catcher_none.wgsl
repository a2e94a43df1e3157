// No surface shows the surroundings behind it.

import package::records::point::Point;

fn caught(point: Point, catcher: u32, to_eye: vec3<f32>) -> Point {
    return point;
}
