// No surface shows the surroundings behind it.

import package::records::point::Point;

fn caught(point: Point, catches: bool, to_eye: vec3<f32>) -> Point {
    return point;
}
