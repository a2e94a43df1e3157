// Light that a point scatters, mirrors and emits to the eye. CPU reference:
// crates/gobo-reference/src/shading/mod.rs.

import package::bind::picture_out::lit;
import package::bind::uniform::{picture_params, point_batch};
import package::features::{HAS_BRICKS, HAS_CAPSULES, HAS_COATS, HAS_FAR_SIDES, HAS_SHADOWS};
import package::records::light::{cluster_list, light_record, listed_index};
import package::records::point::{
    POINT_BRICK, POINT_LEAF, POINT_NONE, POINT_SOLID, POINT_STRAND, Point, is_faced, load_point,
};
import package::records::point_list::{is_listed, point_at, point_count};
import package::records::record::record_texel;
import package::shade::asides::{ASIDE_LOCAL, bits_of, floats_of};
import package::shade::coat::{coat_mirrored, coat_shine, past_coat};
import package::shade::incoming::incoming;
import package::shade::own_shadow::{outside, own_passed};
import package::shade::receiver::{set_leaf, set_receiver};
import package::shade::scattered::scattered;
import package::shade::shading::{
    Gloss, HEAD_ON, PER_PI, highlight, irradiance, mirrored, mirrored_sky, phase_of_orders,
    strand_scattered,
};
import package::shade::shadow::shadow;
import package::shade::surface::eye;
import package::shade::taps::set_turn;
import choice::aside::{aside, lay_aside};
import choice::mask::masked;
import choice::bounced::with_bounced;
import choice::thrown::with_thrown;

// Sums of the lights, laid aside; the second also holds the point's index.
const ASIDE_DIFFUSE: u32 = ASIDE_LOCAL;
const ASIDE_SHINE: u32 = ASIDE_LOCAL + 1u;

// Ambient light that a point of albedo 1 scatters to the eye: on an opaque surface, only light that it does
// not mirror. Where the surroundings are two colours, only metal mirrors them; the rest is scattered.
fn ambient(point: Point) -> vec3<f32> {
    let light = select(picture_params.ambient, irradiance(point.normal), is_faced(point.kind));
    let cosine = dot(point.normal, normalize(eye() - point.position));
    let mirror = mirrored_sky(Gloss(point.reflectivity, point.polish), cosine, point.roughness);
    let mirrors = (point.kind == POINT_SOLID || point.kind == POINT_LEAF)
        && picture_params.environment_size > 0u;
    return light * select(1.0, 1.0 - mirror, mirrors);
}

// Light of the point `number`. Values needed after a look-up are laid aside or read anew.
fn point_light(number: u32) -> vec3<f32> {
    let first = load_point(number);
    let list = cluster_list(first.cluster);
    let count = select(list.count, 0u, first.kind == POINT_NONE);
    set_turn(first.pixel);
    set_receiver(first.receives, first.tag, first.kind == POINT_SOLID);
    set_leaf(first.kind == POINT_LEAF);
    lay_aside(ASIDE_DIFFUSE, bits_of(with_bounced(first, ambient(first)), 0.0));
    lay_aside(ASIDE_SHINE, vec4(vec3(0u), number));
    var i = 0u;
    // Loops over lights and views test at their end: llvmpipe executes a body once more where the test comes
    // first.
    if count > 0u {
        loop {
            let index = listed_index(list, i);
            let point = load_point(aside(ASIDE_SHINE).w);
            let is_solid = point.kind == POINT_SOLID;
            var light = light_record(index);
            let arriving = incoming(light, point.position);
            let is_behind = is_solid && dot(point.normal, arriving.toward) <= 0.0;
            if !is_behind && any(arriving.color > vec3(0.0)) {
                // Normal on the light's side. A facet turned away from the light whose interpolated normal is
                // not is part of a round surface.
                let side = dot(point.face, arriving.toward);
                let face = select(select(-point.face, point.normal, is_solid), point.face, side > 0.0);
                // A light without views reads no map.
                light.view_count = select(light.view_count, 0u, masked(index, point).is_masked);
                var through = vec3(1.0);
                if HAS_SHADOWS {
                    var origin = point.position;
                    var reach = point.reach;
                    if HAS_BRICKS && point.brick > 0u && light.view_count > 0u {
                        origin = outside(point.brick, light, origin, arriving.toward);
                        // No surface is there for a bias to help.
                        reach = -1.0;
                    }
                    through = shadow(light, index, origin, face, arriving.toward, reach);
                    through = with_thrown(light, load_point(aside(ASIDE_SHINE).w).position, through);
                }
                add_light(listed_index(list, i), through);
            }
            i += 1u;
            if i >= count {
                break;
            }
        }
    }
    let point = load_point(aside(ASIDE_SHINE).w);
    let diffuse = floats_of(aside(ASIDE_DIFFUSE)).xyz;
    let shine = floats_of(aside(ASIDE_SHINE)).xyz;
    let past = past_coat(point, normalize(eye() - point.position));
    return point.emission + past * point.albedo * (1.0 - point.metallic) * diffuse + shine;
}

// Adds a light, of which the maps pass the share `by_maps`, to the sums laid aside.
fn add_light(index: u32, by_maps: vec3<f32>) {
    let shine = aside(ASIDE_SHINE);
    let point = load_point(shine.w);
    let arriving = incoming(light_record(index), point.position);
    let cosine = dot(point.normal, arriving.toward);
    var through = masked(index, point).share * by_maps;
    let passed = arriving.color * through;
    let ahead_of_eye = eye() - point.position; // 0 from the middle of a strand or a voxel
    let to_eye = ahead_of_eye / max(length(ahead_of_eye), 1e-30);
    var once = scattered(point, cosine);
    if HAS_CAPSULES {
        let strand = strand_scattered(point.normal, arriving.toward, to_eye, point.roughness);
        once = select(once, strand, point.kind == POINT_STRAND);
    }
    var diffuse = passed * once;
    if HAS_BRICKS {
        let light = light_record(index);
        let brick = select(0u, point.brick, HAS_SHADOWS && light.view_count > 0u);
        through *= own_passed(brick, light, point.position, arriving.toward);
        let ahead = dot(arriving.toward, -to_eye);
        let often = phase_of_orders(through, ahead, 2.0 * point.roughness - 1.0, point.albedo);
        diffuse = arriving.color * select(through * once, often, point.kind == POINT_BRICK);
    }
    lay_aside(ASIDE_DIFFUSE, bits_of(floats_of(aside(ASIDE_DIFFUSE)).xyz + diffuse, 0.0));
    let gloss = Gloss(point.reflectivity, point.polish);
    let head_on = mix(vec3(HEAD_ON), point.albedo, point.metallic);
    let middle = normalize(arriving.toward + to_eye);
    let lobe = highlight(point.normal, middle, point.roughness)
        * mirrored(gloss, dot(to_eye, middle), head_on);
    let shines = is_faced(point.kind) && cosine > 0.0;
    var added = select(vec3(0.0), passed * (cosine * lobe), shines);
    if HAS_FAR_SIDES {
        added += point.far * passed * (max(-cosine, 0.0) * PER_PI);
    }
    if HAS_COATS {
        let coat = passed * coat_shine(point.coat, arriving.toward, middle);
        added = mix(added, coat, coat_mirrored(point.coat, to_eye));
    }
    lay_aside(ASIDE_SHINE, vec4(bits_of(floats_of(shine).xyz + added, 0.0).xyz, shine.w));
}

// Answer of `light_points` in the picture: the light that a point sends to the eye.
fn answer_count() -> u32 {
    return point_count();
}

fn store_answer(index: u32) {
    let point = point_at(index);
    let first = select(point_batch.first, 0u, is_listed());
    textureStore(lit, record_texel(first + point), vec4(point_light(point), 1.0));
}
