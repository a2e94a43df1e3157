// Look-up of shadow masks for pictures without masks.

import package::records::point::Point;

// Share of a light from its mask, 1 without a mask; and whether it has one.
struct Masked {
    share: vec3<f32>,
    is_masked: bool,
}

fn masked(light: u32, point: Point) -> Masked {
    return Masked(vec3(1.0), false);
}
