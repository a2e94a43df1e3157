// Answer of `light_points` to a host: the share of a light that reaches a point. Point by point, light by
// light.

import choice::thrown::with_thrown;
import package::bind::changed::point_shares;
import package::bind::read::{point_normals, point_positions};
import package::bind::uniform::{picture_params, point_batch};
import package::records::light::light_record;
import package::shade::light_through::light_through;

fn answer_count() -> u32 {
    return point_batch.count;
}

fn store_answer(index: u32) {
    let at = index / picture_params.light_count * 3u;
    let position = vec3(point_positions[at], point_positions[at + 1u], point_positions[at + 2u]);
    // Without normals the same buffer is bound again.
    let stored = vec3(point_normals[at], point_normals[at + 1u], point_normals[at + 2u]);
    let normal = select(vec3(0.0), stored, point_batch.has_normals != 0u);
    let light = index % picture_params.light_count;
    let straight = light_through(light, position, normal);
    let share = with_thrown(light_record(light), position, straight);
    point_shares[3u * index] = share.r;
    point_shares[3u * index + 1u] = share.g;
    point_shares[3u * index + 2u] = share.b;
}
