// Light of a map's texels in the spots of occluders close to the receiver, each by its own depths
// (back-projection: Guennebaud et al. 2006).

import package::bind::sampled::{filters, nearests, opaques};
import package::bind::uniform::picture_params;
import package::curve::node::{DEPTHS, node_length, node_passed, node_start};
import package::curve::pages::{curve_place, nodes_at};
import package::features::NODES;
import package::shade::level_light::{Fade, fade_between, share_before};
import package::shade::receiver::{TOUCH, is_solid};
import package::shade::cells::{cell_at, cells_around, is_past, next_cell};
import package::shade::spot::{
    box_area, box_cover, box_of_map, box_reach, box_widths, receiver_end, spot_at, spot_bias, spot_center,
    spot_view,
};

// Light of the texels in the widest spot.
struct NearLight {
    before: vec3<f32>, // light before the map's depths
    inner: vec3<f32>,  // the same in a spot without a size
    taken: vec3<f32>,
    widest: vec3<f32>, // `taken`, all in the widest spot
    step: f32,         // sum of `taken`, weighted by how near each spot's area is to none
}

var<private> near_light: NearLight;

// State of a texel: light behind its nodes so far, light before the fade, and its offset in the spot.
var<private> near_left: vec3<f32>;
var<private> near_before: vec3<f32>;
var<private> near_off: vec2<f32>;
var<private> near_cover: f32; // of the texel, in the widest spot
var<private> near_fade: Fade;
var<private> near_square: f32; // inverse square of the radius of the widest spot

// Share of the box of a spot that the texel covers.
fn map_cover(texels: f32) -> f32 {
    let widths = box_widths(box_of_map(), texels);
    return box_cover(box_reach(widths), near_off) / box_area(widths);
}

// Adds the light that a ramp takes before `end`.
fn take_ramp(start: f32, length: f32, drop: vec3<f32>, end: f32) {
    let inverse = 1.0 / length;
    let stop = clamp(end, start, start + length);
    let early = share_before(near_fade, start, start + length, inverse);
    let until = (stop - start) * inverse;
    near_before -= drop * early;
    let share = max(until - early, 0.0);
    let texels = spot_at(start + length * 0.5 * (early + max(until, early)));
    let taken = drop * (share * map_cover(texels));
    near_light.taken += taken;
    near_light.widest += drop * (share * near_cover);
    near_light.step += saturate(1.0 - texels * texels * near_square) * (taken.x + taken.y + taken.z);
}

fn near_node(node: vec2<u32>, end: f32) {
    let start = node_start(node);
    let drop = select(vec3(0.0), near_left - near_left * node_passed(node), start > 0.0);
    near_left -= drop;
    take_ramp(start, max(node_length(node), 1.0), drop, end);
}

fn near_texel(texel: vec2<f32>, cover: f32) {
    let at = spot_view.origin + vec2<u32>(clamp(texel, vec2(0.0), spot_view.size - 1.0));
    let end = receiver_end(texel + 0.5, 0.0);
    // A filter that touches an opaque receiver tints it.
    let filter_end = end + select(0.0, spot_bias * (1.0 + TOUCH), is_solid);
    near_cover = cover;
    near_left = vec3(1.0);
    near_before = vec3(1.0);
    if NODES > 0u {
        let place = curve_place(at, spot_view.layer);
        var pair = 0u;
        loop {
            let nodes = nodes_at(place, pair);
            near_node(nodes.xy, filter_end);
            near_node(nodes.zw, filter_end);
            pair += 1u;
            if pair >= NODES / 2u {
                break;
            }
        }
    } else {
        let nearest = textureLoad(nearests, at, spot_view.layer, 0).r;
        let passed = select(vec3(1.0), textureLoad(filters, at, spot_view.layer, 0).rgb, nearest < 1.0);
        near_left = passed;
        take_ramp(nearest * DEPTHS, 1.0, 1.0 - passed, filter_end);
    }
    // One opaque surface, or one per channel.
    let is_colored = picture_params.colored != 0u;
    let depths = textureLoad(opaques, at, spot_view.layer, 0).rgb;
    let surfaces = select(1u, 3u, is_colored & any(depths < vec3(1.0)));
    var i = 0u;
    loop {
        let is_channel = (vec3(i) == vec3(0u, 1u, 2u)) | vec3(!is_colored);
        let drop = select(vec3(0.0), near_left, is_channel & vec3(depths[i] < 1.0));
        take_ramp(depths[i] * DEPTHS, 1.0, drop, end);
        i += 1u;
        if i >= surfaces {
            break;
        }
    }
    near_light.before += near_before * cover;
    near_light.inner += near_before * map_cover(0.0);
}

// `texels`: radius of the widest spot.
fn evaluate_map(texels: f32, since: vec2<f32>, is_asked: bool) {
    near_fade = fade_between(since);
    near_square = 1.0 / max(texels * texels, 1e-6);
    near_light = NearLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    let widest = box_widths(box_of_map(), texels);
    var cells = cells_around(spot_center - 0.5, box_reach(widest));
    if is_asked {
        loop {
            near_off = cells.off;
            near_texel(cell_at(cells), box_cover(cells.reach, near_off) / box_area(widest));
            cells = next_cell(cells);
            if is_past(cells) {
                break;
            }
        }
    }
}

// Light before the occluders, in their mean spot; without occluders, in a spot without a size.
fn before_taken() -> vec3<f32> {
    let all = near_light.taken.x + near_light.taken.y + near_light.taken.z;
    let narrow = select(1.0, saturate(near_light.step / select(1.0, all, all != 0.0)), all != 0.0);
    return mix(near_light.before, near_light.inner, narrow);
}
