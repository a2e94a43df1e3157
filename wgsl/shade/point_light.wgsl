// Light that a point scatters, mirrors and emits to the eye. CPU reference: src/reference/shading/mod.rs.

import choice::mask::masked;
import package::bind::uniform::picture_params;
import package::features::{HAS_BRICKS, HAS_CAPSULES, HAS_SHADOWS};
import package::records::light::{cluster_list, light_record, listed_index};
import package::records::point::{
    POINT_BRICK, POINT_NONE, POINT_PANE, POINT_SOLID, POINT_STRAND, Point,
};
import package::shade::phase::phase_of_orders;
import package::shade::receive::{incoming, shadow};
import package::shade::receiver::set_receiver;
import package::shade::shading::{Gloss, HEAD_ON, PER_PI, highlight, mirrored};
import package::shade::strand::strand_scattered;
import package::shade::surface::eye;
import package::shade::taps::set_turn;

const PER_TWO_PI: f32 = 0.15915494;

// Share of the light from `toward` that a point of albedo 1 sends to the eye.
fn scattered(point: Point, cosine: f32) -> f32 {
    switch point.kind {
        case POINT_SOLID: { return max(cosine, 0.0) * PER_PI; }
        case POINT_PANE: { return abs(cosine) * PER_PI; }
        // Isotropic; smoke is thick enough for multiple scattering, so that it is half as bright as paper
        // that faces the light.
        default: { return PER_TWO_PI; }
    }
}

// Irradiance of a surface of normal `n`, divided by pi: spherical harmonics up to order 2 (Ramamoorthi and
// Hanrahan 2001).
fn irradiance(n: vec3<f32>) -> vec3<f32> {
    let linear = coefficient(0u) + coefficient(1u) * n.y + coefficient(2u) * n.z + coefficient(3u) * n.x;
    let mixed = coefficient(4u) * (n.x * n.y) + coefficient(5u) * (n.y * n.z) + coefficient(7u) * (n.x * n.z);
    let squares = coefficient(6u) * (3.0 * n.z * n.z - 1.0) + coefficient(8u) * (n.x * n.x - n.y * n.y);
    return max(linear + mixed + squares, vec3(0.0));
}

fn coefficient(i: u32) -> vec3<f32> {
    return picture_params.irradiance[i].rgb;
}

fn ambient(point: Point) -> vec3<f32> {
    let upright = point.kind == POINT_SOLID || point.kind == POINT_PANE;
    return select(picture_params.ambient, irradiance(point.normal), upright);
}

fn point_light(point: Point) -> vec3<f32> {
    let is_solid = point.kind == POINT_SOLID;
    let shines = is_solid || point.kind == POINT_PANE;
    let gloss = Gloss(point.reflectivity, point.polish);
    let head_on = mix(vec3(HEAD_ON), point.albedo, point.metallic);
    let to_eye = normalize(eye() - point.position);
    let list = cluster_list(point.cluster);
    let count = select(list.count, 0u, point.kind == POINT_NONE);
    set_turn(point.pixel);
    set_receiver(point.receives, point.tag, is_solid);
    var diffuse = ambient(point);
    var shine = vec3(0.0);
    var i = 0u;
    // Loops over lights and views are tested at their end: llvmpipe executes a body once more where the test
    // comes first.
    if count > 0u {
        loop {
            let index = listed_index(list, i);
            var light = light_record(index);
            let arriving = incoming(light, point.position);
            let cosine = dot(point.normal, arriving.toward);
            let side = dot(point.face, arriving.toward);
            let is_behind = is_solid && cosine <= 0.0;
            if !is_behind && any(arriving.color > vec3(0.0)) {
                // Normal on the light's side. A facet that looks away but whose interpolated normal does not is
                // part of a round surface.
                let face = select(select(-point.face, point.normal, is_solid), point.face, side > 0.0);
                let mask = masked(index, point);
                // A light without views reads no map.
                light.view_count = select(light.view_count, 0u, mask.is_masked);
                var through = mask.share;
                if HAS_SHADOWS {
                    through *= shadow(light, point.position, face, arriving.toward, point.reach);
                }
                let passed = arriving.color * through;
                var once = scattered(point, cosine);
                if HAS_CAPSULES {
                    let own = strand_scattered(point.normal, arriving.toward, to_eye, point.roughness);
                    once = select(once, own, point.kind == POINT_STRAND);
                }
                if HAS_BRICKS {
                    let ahead = dot(arriving.toward, -to_eye);
                    let often = phase_of_orders(through, ahead, 2.0 * point.roughness - 1.0, point.albedo);
                    diffuse += arriving.color * select(through * once, often, point.kind == POINT_BRICK);
                } else {
                    diffuse += passed * once;
                }
                let middle = normalize(arriving.toward + to_eye);
                let lobe = highlight(point.normal, middle, point.roughness)
                    * mirrored(gloss, dot(to_eye, middle), head_on);
                shine += select(vec3(0.0), passed * (cosine * lobe), shines && cosine > 0.0);
            }
            i += 1u;
            if i >= count {
                break;
            }
        }
    }
    return point.emission + point.albedo * (1.0 - point.metallic) * diffuse + shine;
}
