// Without masks.

import package::records::point::Point;

// What a mask says of a light: 1 where none does.
struct Masked {
    share: vec3<f32>,
    is_masked: bool,
}

fn masked(light: u32, point: Point) -> Masked {
    return Masked(vec3(1.0), false);
}
