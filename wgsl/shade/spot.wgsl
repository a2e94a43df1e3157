// The part of a shadow map that an area light covers, seen from a point through an occluder's depth: a
// spot. CPU twin: src/reference/shading/soft.rs, `Spot`.

import package::curve::node::{DEPTHS, node_length, node_light, node_start};
import package::records::area::{GpuArea, LevelMap, block_nodes, block_number};
import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::outline::outline_of;

// Radius of the widest spot that a level filters [blocks]: its window is 4.5 blocks wide, that of half the
// radius 1.6.
const WIDEST: f32 = 2.8;
// Radius up to which a spot reads the map itself instead of a level [texels].
const SHARP: f32 = 2.0;
// Aspect ratio of a rectangle up to which its shorter edge chooses the level; beyond it, the longer edge
// divided by this does.
const LONGEST: f32 = 2.33;
// Smallest change of light that counts as an occluder.
const NOTHING: f32 = 1e-3;
const NEVER: f32 = 1e30;
// Distance from a block's middle that a plane's ramp in it spans [blocks]; half a block at the first level,
// whose blocks don't overlap.
const BLOCK_REACH: f32 = 1.0;
// Cosine between a plane's normal and a ray below which the plane has no depth along it.
const EDGE_ON_PLANE: f32 = 0.02;

// The view of the look-up. Depths are in fixed point.
var<private> spot_view: GpuView;
var<private> spot_place: vec2<f32>;    // [texels]
var<private> spot_distance: f32;       // [m]
var<private> spot_depth: f32;
var<private> spot_bias: f32;
// Hoisted by hand: compilers of llvmpipe leave divisions in loops.
var<private> spot_inverse: f32;        // of the distance [1/m]
var<private> spot_step: f32;           // [m]
var<private> spot_per_metre: f32;
var<private> spot_radius: f32;         // [texels], times a distance [m] in a perspective view
var<private> spot_shape: vec2<f32>;    // half-widths along the window's axes, relative to the radius
var<private> spot_turned: bool;        // whether these axes are y and x, so that the second is the longer one
var<private> spot_shear: f32;          // of the window along its first axis, per step along its second
// Depth of the receiver's plane along the ray through a texel: `1 / d` in a perspective view, `d` in a
// parallel one, is linear in the texel.
var<private> plane_middle: f32;
var<private> plane_by_texel: vec2<f32>;

// Light of a level's blocks, averaged over the window.
struct Told {
    before: vec3<f32>, // light before the level's depths
    taken: vec3<f32>,
    behind: vec3<f32>,
    end: vec3<f32>,    // light at the receiver
    most: vec3<f32>,   // the most that can be left of `before`
    next: f32,         // first depth behind the level's that removes light; NEVER for none
}

var<private> told: Told;

fn fixed_of(distance: f32) -> f32 {
    return (distance - spot_view.near) * spot_per_metre;
}

// A vector along x and y, along the window's axes; and back.
fn turned(along: vec2<f32>) -> vec2<f32> {
    return select(along, along.yx, spot_turned);
}

fn set_plane_depth(view: GpuView, p: vec3<f32>, normal: vec3<f32>) {
    let perspective = view.perspective > 0.0;
    let by_slope = vec2(normal.x, -normal.y) / view.scale;
    let meets = select(normal.z, dot(normal, p), perspective);
    let long = select(1.0, length(p), perspective);
    // A plane that is edge-on, or no surface, has the depth of the point everywhere.
    let is_none = abs(meets) < EDGE_ON_PLANE * long || all(normal == vec3(0.0));
    let divisor = select(meets, 1.0, is_none);
    let own = select(-p.z, 1.0 / max(-p.z, 1e-6), perspective);
    plane_middle = select(select(-dot(normal, p), -normal.z, perspective) / divisor, own, is_none);
    plane_by_texel = select(by_slope / divisor, vec2(0.0), is_none);
}

// `normal`: of the surface, on the light's side; zero where there is no surface.
fn set_spot(view: GpuView, light: GpuLight, area: GpuArea, point: vec3<f32>, normal: vec3<f32>, bias: f32) {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let perspective = view.perspective > 0.0;
    spot_view = view;
    spot_distance = select(-p.z, max(-p.z, 1e-6), perspective);
    spot_inverse = 1.0 / spot_distance;
    spot_step = (view.far - view.near) / DEPTHS;
    spot_per_metre = DEPTHS / (view.far - view.near);
    let spread = view.scale / select(1.0, spot_distance, perspective);
    spot_place = vec2(p.x, -p.y) * spread + view.size * 0.5;
    spot_depth = fixed_of(spot_distance);
    spot_bias = bias * spot_per_metre;
    let outline = outline_of(view, light, area, p, point);
    spot_turned = outline.turned;
    spot_shear = outline.shear;
    let half = outline.half;
    let radius = max(min(half.x, half.y), max(half.x, half.y) / LONGEST);
    spot_radius = radius * view.scale;
    spot_shape = half / max(radius, 1e-9);
    set_plane_depth(view, p, (view.view_from_world * vec4(normal, 0.0)).xyz);
}

// Radius of a spot at a depth [texels].
fn spot_at(depth: f32) -> f32 {
    let distance = depth * spot_step + spot_view.near;
    let by_distance = 1.0 / max(distance, 1e-6) - spot_inverse;
    return spot_radius * select(spot_distance - distance, by_distance, spot_view.perspective > 0.0);
}

// Depth at which a spot has a radius of `texels`.
fn depth_of_spot(texels: f32) -> f32 {
    let part = texels / max(spot_radius, 1e-9);
    let distance = 1.0 / (spot_inverse + part);
    return fixed_of(select(spot_distance - part, distance, spot_view.perspective > 0.0));
}

// Depth of the receiver along the ray through `texel`, the least within `around` texels.
fn receiver_end(texel: vec2<f32>, around: f32) -> f32 {
    let slack = (abs(plane_by_texel.x) + abs(plane_by_texel.y)) * around;
    let linear = plane_middle + dot(plane_by_texel, texel - spot_view.size * 0.5);
    let by_distance = 1.0 / max(linear + slack, 1e-7);
    let distance = select(linear - slack, by_distance, spot_view.perspective > 0.0);
    return min(fixed_of(distance), spot_depth) - spot_bias;
}

// Window that filters a spot on blocks of an edge, along its axes [blocks]. Together with the overlap of the
// blocks and a block's own width it is closest to a disc at a variance slightly above the disc's.
fn filter_width(texels: f32, per_edge: f32) -> vec2<f32> {
    let radius = spot_shape * (texels * per_edge);
    return sqrt(max(3.0 * radius * radius - (3.25 - 9.0 * per_edge * per_edge), vec2(1.0)));
}

// Share of a window of `width` blocks, at least one, that covers the block `off` its centre, along its axes,
// by area.
fn window_cover(off: vec2<f32>, width: vec2<f32>) -> f32 {
    let over = saturate(0.5 * (width + 1.0) - abs(off));
    return over.x * over.y / (width.x * width.y);
}

// Light behind the nodes of a block so far, and the first depth found so far.
var<private> seek_left: vec3<f32>;
var<private> seek_next: f32;

fn seek_taker(node: vec2<u32>, since: f32, end: f32) {
    let start = node_start(node);
    let light = node_light(node);
    let drop = abs(seek_left - light);
    seek_left = light;
    let first = max(start, since);
    let takes = max(drop.x, max(drop.y, drop.z)) > NOTHING;
    let is = start > 0.0 && takes && start + node_length(node) >= since && first < end;
    seek_next = select(seek_next, min(seek_next, first), is);
}

// Pairs of a block's nodes to evaluate: the second one not, if all of it is behind the receiver.
fn pairs_before(first: vec4<u32>, end: f32) -> u32 {
    let start = node_start(first.zw);
    return select(1u, 2u, start > 0.0 && start < end);
}

// First depth from `since` on at which `blocks` (0 or 4) of a level around the point remove light; NEVER
// for none.
fn next_taker(map: LevelMap, blocks: u32, since: f32, around: f32) -> f32 {
    let corner = vec2<i32>(floor(spot_place / map.edge - 0.5));
    seek_next = NEVER;
    for (var i = 0u; i < blocks; i += 1u) {
        let at = corner + vec2<i32>(vec2(i % 2u, i / 2u));
        let end = receiver_end((vec2<f32>(at) + 0.5) * map.edge, around * map.edge);
        let block = block_number(map, at);
        seek_left = vec3(1.0);
        var nodes = block_nodes(block, 0u);
        let pairs = pairs_before(nodes, end);
        for (var pair = 0u; pair < pairs; pair += 1u) {
            seek_taker(nodes.xy, since, end);
            seek_taker(nodes.zw, since, end);
            nodes = block_nodes(block, 1u);
        }
    }
    return seek_next;
}

// Light of a block behind the nodes so far, and its light at three depths.
var<private> tell_left: vec3<f32>;
var<private> tell_passed: mat3x3<f32>;

fn tell_node(node: vec2<u32>, off: vec2<f32>, per_edge: f32, width: vec2<f32>, bounds: vec3<f32>) {
    let start = node_start(node);
    let length = node_length(node);
    let light = node_light(node);
    let drop = select(vec3(0.0), tell_left - light, start > 0.0);
    tell_left = light;
    let size = abs(drop);
    let takes = max(size.x, max(size.y, size.z)) > NOTHING;
    // `bounds.y` is at most the receiver's depth.
    let follows = takes && start + length > bounds.y && max(start, bounds.y) < bounds.z;
    told.next = select(told.next, min(told.next, max(start, bounds.y)), follows);
    let shares = saturate((bounds - start) * (1.0 / max(length, 1e-3)));
    tell_passed -= mat3x3(drop * shares.x, drop * shares.y, drop * shares.z);
    let texels = spot_at(start + length * 0.5 * (shares.x + shares.y));
    let own = window_cover(off, min(filter_width(texels, per_edge), width));
    told.taken += drop * ((shares.y - shares.x) * own);
}

// Evaluates the depths `since` to `to` on a level; `texels` is the radius of their widest spot.
fn tell_level(map: LevelMap, texels: f32, since: f32, to: f32) {
    let per_edge = 1.0 / map.edge;
    let middle = turned(spot_place * per_edge - 0.5);
    let width = filter_width(texels, per_edge);
    let half = 0.5 * (width + 1.0);
    let low = ceil(middle - half);
    let straight = floor(middle + half) - low + 1.0;
    // A sheared row starts anywhere between two blocks.
    let columns = select(floor(2.0 * half.x) + 1.0, straight.x, spot_shear == 0.0);
    let count = vec2<u32>(vec2(columns, straight.y));
    let reach = select(BLOCK_REACH * map.edge, 1.0, map.edge == 2.0);
    told = Told(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), NEVER);
    for (var i = 0u; i < count.x * count.y; i += 1u) {
        let row = low.y + f32(i / count.x);
        let sheared = spot_shear * (row - middle.y);
        let column = ceil(middle.x + sheared - half.x) + f32(i % count.x);
        let off = vec2(column - sheared, row) - middle;
        let weight = window_cover(off, width);
        let at = turned(vec2(column, row));
        // A block beside the window is as if behind the receiver.
        let end = select(0.0, receiver_end((at + 0.5) * map.edge, reach), weight > 0.0);
        let bounds = min(vec3(since, to, end), vec3(end));
        let block = block_number(map, vec2<i32>(at));
        tell_left = vec3(1.0);
        tell_passed = mat3x3(vec3(1.0), vec3(1.0), vec3(1.0));
        var nodes = block_nodes(block, 0u);
        let pairs = pairs_before(nodes, end);
        for (var pair = 0u; pair < pairs; pair += 1u) {
            tell_node(nodes.xy, off, per_edge, width, bounds);
            tell_node(nodes.zw, off, per_edge, width, bounds);
            nodes = block_nodes(block, 1u);
        }
        told.before += tell_passed[0] * weight;
        told.behind += tell_passed[1] * weight;
        told.end += tell_passed[2] * weight;
    }
    // The light left in a narrower window is part of that in the widest: at most as much per area.
    let least = min(filter_width(spot_at(to), per_edge), width);
    told.most = told.behind * (width.x * width.y / (least.x * least.y));
}
