// The views in which a light's rays are followed, and the space of the rays: the view's own or, for the faces
// of a cube, the world's axes around the lamp. CPU reference: crates/gobo-reference/src/caustics.rs.

import package::bind::sampled::opaques;
import package::bind::uniform::views;
import package::records::view::{GpuView, ROLE_FACE};
import package::shade::incoming::cube_face;

// Whether the kernel is one for lights of a kind: for those with the views of a cube, or for others.
override KNOWS_VIEWS: bool;
override OF_CUBE: bool;

fn is_cube() -> bool {
    return select(views[0].role == ROLE_FACE, OF_CUBE, KNOWS_VIEWS);
}

// A world-space point in the space of the rays.
fn in_rays(point: vec3<f32>) -> vec3<f32> {
    let from_world = views[0].view_from_world;
    let seen = (from_world * vec4(point, 1.0)).xyz;
    return select(seen, (vec4(seen, 0.0) * from_world).xyz, is_cube());
}

// A point of the rays in world space.
fn in_world(point: vec3<f32>) -> vec3<f32> {
    let from_world = views[0].view_from_world;
    let offset = from_world[3].xyz;
    let aside = (vec4(point - offset, 0.0) * from_world).xyz;
    return select(aside, point - (vec4(offset, 0.0) * from_world).xyz, is_cube());
}

// A direction of the rays in world space.
fn turned_back(direction: vec3<f32>) -> vec3<f32> {
    return select((vec4(direction, 0.0) * views[0].view_from_world).xyz, direction, is_cube());
}

// A world-space direction in the space of the rays.
fn turned(direction: vec3<f32>) -> vec3<f32> {
    return select((views[0].view_from_world * vec4(direction, 0.0)).xyz, direction, is_cube());
}

// A point or a direction of the rays, in the space of a view.
fn in_view(number: u32, point: vec3<f32>) -> vec3<f32> {
    return select(point, (views[number].view_from_world * vec4(point, 0.0)).xyz, is_cube());
}

// A direction of a view, in the space of the rays.
fn from_view(number: u32, direction: vec3<f32>) -> vec3<f32> {
    return select(direction, (vec4(direction, 0.0) * views[number].view_from_world).xyz, is_cube());
}

// A point of the rays as a view sees it.
struct Seen {
    number: u32,       // of the view
    point: vec3<f32>,  // in its space [m]
    place: vec2<f32>,  // in its map [texels]
    is_on_map: bool,
}

fn seen(point: vec3<f32>) -> Seen {
    return seen_in(select(0u, cube_face(point), is_cube()), point);
}

fn seen_in(number: u32, point: vec3<f32>) -> Seen {
    let view = views[number];
    let own = in_view(number, point);
    let place = map_place(view, own);
    // By rounding, a point between two faces of a cube may be beside both.
    let clamped = select(place, clamp(place, vec2(0.0), view.size - 0.001), is_cube());
    return Seen(number, own, clamped, all(clamped >= vec2(0.0)) && all(clamped < view.size));
}

// Place of a view-space point in the map [texels].
fn map_place(view: GpuView, point: vec3<f32>) -> vec2<f32> {
    let spread = view.scale / select(1.0, max(-point.z, 1e-6), view.perspective > 0.0);
    return vec2(point.x, -point.y) * spread + view.size * 0.5;
}

// Edge of a texel at a view-space point [m].
fn texel_at(view: GpuView, point: vec3<f32>) -> f32 {
    return select(1.0, -point.z, view.perspective > 0.0) / view.scale;
}

// Number of a texel among those of all views.
fn texel_number(number: u32, place: vec2<f32>) -> u32 {
    let size = vec2<u32>(views[number].size);
    let texel = vec2<u32>(clamp(place, vec2(0.0), views[number].size - 1.0));
    return (number * size.y + texel.y) * size.x + texel.x;
}

// Share of the light of a texel at a place, relative to the middle of the map: lamps send less to the texels
// of its corners.
fn texel_share(number: u32, place: vec2<f32>) -> f32 {
    let view = views[number];
    let slope = (place - view.size * 0.5) / view.scale;
    let square = 1.0 + dot(slope, slope);
    return select(1.0, inverseSqrt(square) / square, view.perspective > 0.0);
}

fn opaque_depth(number: u32, place: vec2<f32>) -> f32 {
    let view = views[number];
    let texel = vec2<u32>(clamp(place, vec2(0.0), view.size - 1.0));
    return textureLoad(opaques, view.origin + texel, view.layer, 0).r;
}

// Depth of the opaque surface at a place of a map [m].
fn opaque_along(number: u32, place: vec2<f32>) -> f32 {
    return views[number].near + opaque_depth(number, place) * (views[number].far - views[number].near);
}
