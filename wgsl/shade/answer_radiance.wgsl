// Answer of `light_points` in the picture: the light that a point sends to the eye.

import package::bind::stored::lit;
import package::bind::uniform::point_batch;
import package::records::point::load_point;
import package::records::record::record_texel;
import package::shade::point_light::point_light;

fn store_answer(index: u32) {
    let light = point_light(load_point(index));
    textureStore(lit, record_texel(point_batch.first + index), vec4(light, 1.0));
}
