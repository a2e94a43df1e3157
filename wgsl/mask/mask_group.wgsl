// Masks of a pixel, and the surface that it belongs to.

import package::bind::sampled::light_masks;
import package::bind::stored::new_masks;
import package::bind::uniform::{mask_params, views};
import package::records::mask::{MaskSurface, surface_depth, surface_normal, surface_offset};

// Masks of a pixel that one invocation looks up or filters together: surfaces' weights are computed once for
// all of them.

override MASKS: u32 = 1u; // per invocation: 1, 2 or 4

struct MaskGroup {
    first: vec4<f32>,
    second: vec4<f32>,
    third: vec4<f32>,
    fourth: vec4<f32>,
}

fn even_group(value: f32) -> MaskGroup {
    return MaskGroup(vec4(value), vec4(value), vec4(value), vec4(value));
}

// Past the last mask, the last one is loaded.
fn load_mask(texel: vec2<u32>, mask: u32) -> vec4<f32> {
    return textureLoad(light_masks, texel, min(mask, mask_params.mask_count - 1u), 0);
}

// `group`: index of the group.
fn load_group(texel: vec2<u32>, group: u32) -> MaskGroup {
    let mask = group * MASKS;
    var masks = even_group(0.0);
    masks.first = load_mask(texel, mask);
    if MASKS > 1u {
        masks.second = load_mask(texel, mask + 1u);
    }
    if MASKS > 2u {
        masks.third = load_mask(texel, mask + 2u);
        masks.fourth = load_mask(texel, mask + 3u);
    }
    return masks;
}

fn weighted(sum: MaskGroup, other: MaskGroup, weight: f32) -> MaskGroup {
    return MaskGroup(
        sum.first + other.first * weight,
        sum.second + other.second * weight,
        sum.third + other.third * weight,
        sum.fourth + other.fourth * weight,
    );
}

fn divided(sum: MaskGroup, by: f32) -> MaskGroup {
    return MaskGroup(sum.first / by, sum.second / by, sum.third / by, sum.fourth / by);
}

fn either_group(no: MaskGroup, yes: MaskGroup, which: bool) -> MaskGroup {
    return MaskGroup(
        select(no.first, yes.first, which),
        select(no.second, yes.second, which),
        select(no.third, yes.third, which),
        select(no.fourth, yes.fourth, which),
    );
}

fn store_group(texel: vec2<u32>, group: u32, masks: MaskGroup) {
    let mask = group * MASKS;
    let count = mask_params.mask_count;
    textureStore(new_masks, texel, mask, masks.first);
    if MASKS > 1u && mask + 1u < count {
        textureStore(new_masks, texel, mask + 1u, masks.second);
    }
    if MASKS > 2u && mask + 2u < count {
        textureStore(new_masks, texel, mask + 2u, masks.third);
    }
    if MASKS > 3u && mask + 3u < count {
        textureStore(new_masks, texel, mask + 3u, masks.fourth);
    }
}

// Position of a mask's pixel in the camera's view, and its weight for another pixel.

// Cosine of the steepest slant that counts, times the length of the pixel's ray; negative towards the eye.
const MIN_FACING: f32 = -1e-3;

// Centre of the picture's pixel for a pixel of the masks.
fn shown_pixel(at: vec2<u32>, step: u32, offset: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(at * step + offset) + 0.5;
}

// Tangent plane of a pixel. A point at distance d along the axis, in a pixel at offset o, is `d (here +
// turn . o) - off` from the plane, in units of the blur's tolerance.
struct MaskPlane {
    pixel: vec2<f32>,  // pixel of the picture
    normal: vec3<f32>, // interpolated, world space
    distance: f32,     // distance of the surface along the camera's axis [m]
    here: f32,
    turn: vec2<f32>,
    off: f32,
    near: f32,         // near plane of the camera [m]
    range: f32,        // distance from its near to its far plane [m]
}

fn mask_plane(at: vec2<u32>, step: u32, surface: MaskSurface) -> MaskPlane {
    let view = views[0];
    let range = view.far - view.near;
    let pixel = shown_pixel(at, step, surface.offset);
    let slope = (pixel - view.size * 0.5) / view.scale;
    let face = (view.view_from_world * vec4(surface.face, 0.0)).xyz;
    let distance = view.near + surface.depth * range;
    let tolerated = mask_params.sensitivity / distance;
    let here = (face.x * slope.x - face.y * slope.y - face.z) * tolerated;
    let turn = vec2(face.x, -face.y) / view.scale * tolerated;
    return MaskPlane(pixel, surface.normal, distance, here, turn, distance * here, view.near, range);
}

// Distance of a surface from the plane, in units of the blur's tolerance.
fn plane_error(plane: MaskPlane, pixel: vec2<f32>, depth: f32) -> f32 {
    let ray = plane.here + dot(plane.turn, pixel - plane.pixel);
    return abs((plane.near + depth * plane.range) * ray - plane.off);
}

// Weight of a surface, a texel of `mask_surfaces`, for the pixel of a plane: by depth, and by the angle
// between the normals.
fn surface_weight(plane: MaskPlane, at: vec2<u32>, step: u32, other: vec4<u32>) -> f32 {
    let depth = surface_depth(other);
    let error = plane_error(plane, shown_pixel(at, step, surface_offset(other)), depth);
    let facing = max(dot(plane.normal, surface_normal(other)), 0.0);
    let two = facing * facing;
    let four = two * two;
    return select(max(1.0 - error, 0.0) * four * four, 0.0, depth >= 1.0);
}

// Lengths of a pixel's step to the right and down on a surface parallel to the screen, relative to those on
// the surface of the plane; at most 1.
fn upright_shares(plane: MaskPlane, face: vec3<f32>) -> vec2<f32> {
    let view = views[0];
    let slope = (plane.pixel - view.size * 0.5) / view.scale;
    let ray = vec3(slope.x, -slope.y, -1.0);
    let normal = (view.view_from_world * vec4(face, 0.0)).xyz;
    // Change of the distance along the axis per step.
    let turn = normal.xy / min(dot(normal, ray), MIN_FACING);
    let square = 1.0 - 2.0 * turn * ray.xy + turn * turn * dot(ray, ray);
    return inverseSqrt(max(square, vec2(1.0)));
}
