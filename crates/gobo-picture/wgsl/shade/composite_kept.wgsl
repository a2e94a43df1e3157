// Choices of a picture with a shadow catcher, occlusion and refraction. CPU reference: `caught` in
// crates/gobo-reference/src/shading/mod.rs.

import package::bind::picture_in::layers;
import package::bind::picture_out::{ambients, behinds, bends};
import package::bind::sampled::light_masks;
import package::occlusion::occlusion::{Surroundings, pack_surroundings};
import package::records::light::{cluster_list, light_record, listed_index};
import package::records::mask::{mask_slot, slot_channels, slot_mask};
import package::records::point::{NO_COAT, POINT_SOLID, Point, load_point};
import package::records::record::record_texel;
import package::refraction::refraction::{Bend, pack_bend};
import package::shade::coat::past_coat;
import package::shade::environment::from_around;
import package::shade::incoming::incoming;
import package::shade::point_light::ambient;
import package::shade::shading::{PER_PI, irradiance};
import package::shade::surface::eye;

// Surfaces that show the surroundings behind them, times the share of the light that reaches them: the light
// that `light_points` will multiply with is divided out.
fn caught(point: Point, catches: bool, to_eye: vec3<f32>) -> Point {
    if !catches {
        return point;
    }
    var whole = irradiance(point.normal);
    let list = cluster_list(point.cluster);
    for (var i = 0u; i < list.count; i += 1u) {
        let arriving = incoming(light_record(listed_index(list, i)), point.position);
        whole += arriving.color * (max(dot(point.normal, arriving.toward), 0.0) * PER_PI);
    }
    let behind = from_around(-to_eye, 0.0);
    let is_lit = whole > vec3(0.0);
    var shown = point;
    shown.albedo = select(vec3(0.0), behind / whole, is_lit);
    shown.emission = select(behind, vec3(0.0), is_lit);
    shown.reflectivity = 0.0;
    shown.polish = 0.0;
    shown.metallic = 0.0;
    shown.coat = NO_COAT;
    return shown;
}

// Keeps the ambient light of a pixel's opaque surface, with the surface, for `occlusion`.

const IS_LAST: bool = false;

// `index`: of the pixel in its band; `depth`: of its surface; `passed`: share of that surface's light that
// reaches the eye.
fn keep_ambient(pixel: vec2<u32>, index: u32, depth: f32, passed: vec3<f32>) {
    let point = load_point(index);
    let is_surface = point.kind == POINT_SOLID;
    let past = past_coat(point, normalize(eye() - point.position));
    let light = past * point.albedo * (1.0 - point.metallic) * ambient(point) * passed;
    // Spherical particles have flat depths.
    let normal = select(point.face, vec3(0.0), point.reach > 0.0);
    let shown = Surroundings(select(1.0, depth, is_surface), normal, select(vec3(0.0), light, is_surface));
    textureStore(ambients, pixel, pack_surroundings(shown));
}

// Keeps the light behind glass apart for `refraction`, which finds where it is seen.

const REFRACTS: bool = true;

// Light of the opaque surface.
fn keep_behind(pixel: vec2<u32>, depth: f32, light: vec3<f32>) {
    // At most the largest half.
    textureStore(behinds, pixel, vec4(min(light, vec3(65504.0)), depth));
}

// Whether the scene behind the layers is seen displaced. `first`: texel of the pixel's layers; `pane`: light
// depth of the nearest pane; `passed`: share of the surface's light that reaches the eye.
fn keep_bend(pixel: vec2<u32>, first: u32, pane: f32, passed: vec3<f32>) -> bool {
    let bits = textureLoad(layers, record_texel(first + 4u), 0).xyz;
    let bend = Bend(bitcast<vec2<f32>>(bits.xy), bitcast<f32>(bits.z), pane, passed);
    let is_bent = any(bits != vec3(0u));
    textureStore(bends, pixel, select(vec4(0u), pack_bend(bend), is_bent));
    return is_bent;
}

// No layer is in front of the surface.
fn keep_straight(pixel: vec2<u32>) {
    textureStore(bends, pixel, vec4(0u));
}

// Share of a light from its mask, 1 without a mask; and whether it has one.
struct Masked {
    share: vec3<f32>,
    is_masked: bool,
}

fn masked(light: u32, point: Point) -> Masked {
    let slot = mask_slot(light);
    let is_masked = (slot != 0u) & (point.kind == POINT_SOLID);
    let mask_slot = max(slot, 1u);
    let pixel = vec2(point.pixel & 0xffffu, point.pixel >> 16u);
    let mask = textureLoad(light_masks, pixel, slot_mask(mask_slot), 0);
    let channels = slot_channels(mask_slot);
    let one = dot(mask, select(vec4(0.0), vec4(1.0), channels));
    let share = select(vec3(one), mask.rgb, channels.x & channels.y);
    return Masked(select(vec3(1.0), share, is_masked), is_masked);
}
