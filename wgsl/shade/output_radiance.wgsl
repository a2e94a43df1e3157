// Answer of `light_points` in the picture: the light that a point sends to the eye.

import package::bind::stored::lit;
import package::bind::uniform::point_batch;
import package::records::record::record_texel;
import package::shade::listed_point::{is_listed, point_at, point_count};
import package::shade::point_light::point_light;

fn answer_count() -> u32 {
    return point_count();
}

fn store_answer(index: u32) {
    let point = point_at(index);
    let first = select(point_batch.first, 0u, is_listed());
    textureStore(lit, record_texel(first + point), vec4(point_light(point), 1.0));
}
