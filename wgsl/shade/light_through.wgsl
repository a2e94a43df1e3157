// Share of a light that reaches a point, for shaders of the host and for `light_points`: 1 if nothing is in
// between, without falloff and cosine. CPU reference: `share` of crates/gobo-reference/src/shading/mod.rs.
// Rust: src/shadows/look_ups/host_shader.rs.

import package::bind::changed::point_shares;
import package::bind::read::{point_normals, point_positions};
import package::bind::uniform::{picture_params, point_batch};
import package::records::light::light_record;
import package::records::material::RECEIVES_CURVE;
import package::records::texel::NO_OWNER;
import package::shade::incoming::incoming;
import package::shade::receiver::set_receiver;
import package::shade::shadow::{receiver_of, shadow};
import choice::thrown::{thrown_at, with_thrown};

// `light`: index among the bound lights; `position` [m] and unit `normal` in world space. The normal
// offsets the point towards the light, off its own surface's shadow; zero for a point on no surface.
fn light_through(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let source = light_record(light);
    let toward = incoming(source, position).toward;
    let face = normal * select(-1.0, 1.0, dot(normal, toward) > 0.0);
    set_receiver(RECEIVES_CURVE, NO_OWNER, false);
    return shadow(source, receiver_of(source, position, face, toward, 0.0));
}

// For a point without a normal: smoke, fog.
fn light_at(light: u32, position: vec3<f32>) -> vec3<f32> {
    return light_through(light, position, vec3(0.0));
}

// Answer of `light_points` to a host: the share of a light that reaches a point. Point by point, light by
// light.
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
    let share = with_thrown(thrown_at(light_record(light), position), straight);
    point_shares[3u * index] = share.r;
    point_shares[3u * index + 1u] = share.g;
    point_shares[3u * index + 2u] = share.b;
}
