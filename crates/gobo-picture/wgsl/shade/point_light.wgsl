// Light that a point scatters, mirrors and emits to the eye. CPU reference:
// crates/gobo-reference/src/shading/mod.rs.

import package::bind::picture_out::lit;
import package::bind::uniform::{picture_params, point_batch};
import package::features::{HAS_BRICKS, HAS_CAPSULES, HAS_COATS, HAS_FAR_SIDES, HAS_SHADOWS};
import package::records::light::{GpuLight, cluster_list, light_record, listed_index};
import package::records::point::{
    POINT_BRICK, POINT_LEAF, POINT_NONE, POINT_SOLID, POINT_STRAND, Point, is_faced, load_point,
};
import package::records::point_list::{is_listed, point_at, point_count};
import package::records::record::record_texel;
import package::shade::coat::{coat_mirrored, coat_shine, past_coat};
import package::shade::incoming::incoming;
import package::shade::own_shadow::{outside, own_passed};
import package::shade::receiver::{set_leaf, set_receiver};
import package::shade::scattered::scattered;
import package::shade::shading::{
    Gloss, HEAD_ON, PER_PI, highlight, irradiance, mirrored, mirrored_sky, phase_of_orders,
    strand_scattered,
};
import package::shade::lifted::Receiver;
import package::shade::shadow::{UNSHADED, past_view, receiver_of};
import package::shade::surface::eye;
import package::shade::taps::set_turn;
import choice::mask::masked;
import choice::bounced::with_bounced;
import choice::thrown::{thrown_at, with_thrown};

// Direction to the eye; 0 where the eye is in the middle of a strand or on a point of a voxel.
fn toward_eye(position: vec3<f32>) -> vec3<f32> {
    let off = eye() - position;
    return off / max(length(off), 1e-30);
}

// Ambient light that a point of albedo 1 scatters to the eye: on an opaque surface, only light that it does
// not mirror. Where the surroundings are two colours, only metal mirrors them; the rest is scattered.
fn ambient(point: Point) -> vec3<f32> {
    let light = select(picture_params.ambient, irradiance(point.normal), is_faced(point.kind));
    let cosine = dot(point.normal, toward_eye(point.position));
    let mirror = mirrored_sky(Gloss(point.reflectivity, point.polish), cosine, point.roughness);
    let mirrors = ((point.kind == POINT_SOLID) | (point.kind == POINT_LEAF))
        & (picture_params.environment_size > 0u);
    return light * select(1.0, 1.0 - mirror, mirrors);
}

// Shares of the light from one direction that a point sends to the eye.
struct Sends {
    once: f32,       // scattered, per albedo
    lobe: vec3<f32>, // mirrored
    far: f32,        // of POINT_LEAF: scattered from its far side, per share
    coat: vec2<f32>, // mirrored by its coat, and the coat's share of all mirrored light
}

fn sends_on(point: Point, toward: vec3<f32>) -> Sends {
    let cosine = dot(point.normal, toward);
    let to_eye = toward_eye(point.position);
    var once = scattered(point, cosine);
    if HAS_CAPSULES {
        let strand = strand_scattered(point.normal, toward, to_eye, point.roughness);
        once = select(once, strand, point.kind == POINT_STRAND);
    }
    let gloss = Gloss(point.reflectivity, point.polish);
    let head_on = mix(vec3(HEAD_ON), point.albedo, point.metallic);
    let middle = normalize(toward + to_eye);
    let lobe = highlight(point.normal, middle, point.roughness)
        * mirrored(gloss, dot(to_eye, middle), head_on);
    let shines = is_faced(point.kind) & (cosine > 0.0);
    let far = max(-cosine, 0.0) * PER_PI;
    var coat = vec2(0.0);
    if HAS_COATS {
        coat = vec2(coat_shine(point.coat, toward, middle), coat_mirrored(point.coat, to_eye));
    }
    return Sends(once, select(vec3(0.0), cosine * lobe, shines), far, coat);
}

// Receiver of a light at a point, for its maps.
fn receiver_at(point: Point, light: GpuLight, toward: vec3<f32>) -> Receiver {
    // Normal on the light's side. A facet turned away from the light whose interpolated normal is not is part
    // of a round surface.
    let is_solid = point.kind == POINT_SOLID;
    let side = dot(point.face, toward);
    let face = select(select(-point.face, point.normal, is_solid), point.face, side > 0.0);
    if HAS_BRICKS && point.brick > 0u {
        // No surface is there for a bias to help.
        return receiver_of(light, outside(point.brick, light, point.position, toward), face, toward, -1.0);
    }
    return receiver_of(light, point.position, face, toward, point.reach);
}

// Light of the point `number`. A turn reads one view of a light, and reads the point and the light for it: an
// area light leaves no registers to keep them.
fn point_light(number: u32) -> vec3<f32> {
    // Sums of the lights.
    var diffuse = vec3(0.0);
    var shine = vec3(0.0);
    var passed = UNSHADED;
    var i = 0u;
    // Tests at its end: llvmpipe executes a body once more where the test comes first.
    loop {
        let point = load_point(number);
        let list = cluster_list(point.cluster);
        let count = select(list.count, 0u, point.kind == POINT_NONE);
        if (i == 0u) & (passed.next == 0u) {
            diffuse = with_bounced(point, ambient(point));
        }
        let is_solid = point.kind == POINT_SOLID;
        let index = listed_index(list, min(i, max(count, 1u) - 1u));
        let light = light_record(index);
        let arriving = incoming(light, point.position);
        let is_behind = is_solid & (dot(point.normal, arriving.toward) <= 0.0);
        let is_lit = (i < count) & !is_behind & any(arriving.color > vec3(0.0));
        let is_last = i + 1u >= count;
        let sends = sends_on(point, arriving.toward);
        let mask = masked(index, point);
        var own = vec3(1.0);
        if HAS_BRICKS {
            let brick = select(0u, point.brick, HAS_SHADOWS && light.view_count > 0u);
            own = own_passed(brick, light, point.position, arriving.toward);
        }
        var through = mask.share;
        passed.is_all = true;
        if HAS_SHADOWS && (is_lit & (light.view_count > 0u) & !mask.is_masked) {
            set_turn(point.pixel);
            set_receiver(point.receives, point.tag, is_solid);
            set_leaf(point.kind == POINT_LEAF);
            let thrown = thrown_at(light, point.position);
            passed = past_view(passed, light, receiver_at(point, light, arriving.toward));
            through = with_thrown(thrown, passed.light);
        }
        if passed.is_all {
            if is_lit {
                let lit = arriving.color * through;
                var once = lit * sends.once;
                if HAS_BRICKS {
                    let to_eye = toward_eye(point.position);
                    let ahead = dot(arriving.toward, -to_eye);
                    let within = through * own;
                    let often = phase_of_orders(within, ahead, 2.0 * point.roughness - 1.0, point.albedo);
                    once = arriving.color * select(within * sends.once, often, point.kind == POINT_BRICK);
                }
                diffuse += once;
                var mirrored = lit * sends.lobe;
                if HAS_FAR_SIDES {
                    mirrored += point.far * lit * sends.far;
                }
                if HAS_COATS {
                    mirrored = mix(mirrored, lit * sends.coat.x, sends.coat.y);
                }
                shine += mirrored;
            }
            passed = UNSHADED;
            i += 1u;
            if is_last {
                break;
            }
        }
    }
    let point = load_point(number);
    let past = past_coat(point, toward_eye(point.position));
    return point.emission + past * point.albedo * (1.0 - point.metallic) * diffuse + shine;
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
