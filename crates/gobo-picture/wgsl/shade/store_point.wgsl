// Writes a point for `light_points`.

import package::bind::stored::points;
import package::records::point::{POINT_TEXELS, Point, packed_point};
import package::records::record::record_texel;

fn store_point(index: u32, point: Point) {
    let texels = packed_point(point);
    let first = index * POINT_TEXELS;
    textureStore(points, record_texel(first), texels[0]);
    textureStore(points, record_texel(first + 1u), texels[1]);
    textureStore(points, record_texel(first + 2u), texels[2]);
    textureStore(points, record_texel(first + 3u), texels[3]);
}
