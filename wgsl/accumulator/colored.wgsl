// Accumulator: nearest opaque depth per channel of an invocation's texels. CPU reference:
// crates/gobo-reference/src/occlude.rs.

import package::bind::changed::scattered_tiles;
import package::bind::stored::{colored, opaques};
import package::features::unrolled;
import package::hit::blocks::{blocked_channels, last_depth, nearnesses, small_depth, stored_depth};
import package::hit::caster_hit::caster_hit;
import package::records::footprint::Footprint;
import package::records::tile::{Segment, Tile};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::{depth_to_nearness, nearness_to_depth};
import package::traversal::lane::sum_index;
import choice::rows::ROW_COUNT;
import choice::sums::{clear_sums, load_sums, raise_channels};

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> nearest: array<vec3<f32>, ROW_COUNT>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        nearest[i] = vec3(1.0);
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let texel = corner + vec2(0.5, f32(i) + 0.5);
        let hit = caster_hit(view, footprint, texel, 1.0);
        let blocked = blocked_channels(view, footprint, texel, hit);
        nearest[i] = select(nearest[i], min(nearest[i], vec3(stored_depth(hit))), blocked);
    }
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    var last = vec3(0.0);
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        last = max(last, nearest[i]);
    }
    return all(last <= vec3(front));
}

fn before_tile(view: GpuView, texel: vec2<u32>, tile: Tile) {}

// Whether no caster has the tile in its box.
fn stays_empty(view: GpuView, texel: vec2<u32>, tile: Tile) -> bool {
    return tile.first >= tile.end;
}

fn store_empty(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let at = texel + vec2(0u, i);
        let depth = small_depth(view, at);
        textureStore(opaques, view.origin + at, view.layer, vec4(depth));
        textureStore(colored, view.origin + at, view.layer, vec4(vec3(depth), 1.0));
    }
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let at = texel + vec2(0u, i);
        let depths = min(nearest[i], vec3(small_depth(view, at)));
        textureStore(opaques, view.origin + at, view.layer, vec4(last_depth(depths)));
        textureStore(colored, view.origin + at, view.layer, vec4(depths, 1.0));
    }
}

fn before_segment(index: u32) {}

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        if any(nearest[i] < vec3(1.0)) {
            raise_channels(sum_index(segment.tile, in_tile + vec2(0u, i)), nearnesses(nearest[i]));
        }
    }
}

fn add(view: GpuView, footprint: Footprint, tile_xy: vec2<u32>, in_tile: vec2<u32>) {
    let middle = vec2<f32>(tile_xy * TILE_SIZE + in_tile) + 0.5;
    let hit = caster_hit(view, footprint, middle, 1.0);
    let blocked = blocked_channels(view, footprint, middle, hit);
    if any(blocked) {
        let tile = view.first_tile + tile_xy.y * view.tiles_x + tile_xy.x;
        let value = depth_to_nearness(stored_depth(hit));
        raise_channels(sum_index(tile, in_tile), select(vec3(0u), vec3(value), blocked));
        scattered_tiles[tile] = 1u;
    }
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let sum = sum_index(tile_id, in_tile + vec2(0u, i));
        let at = tile.position * TILE_SIZE + in_tile + vec2(0u, i);
        let sums = load_sums(sum);
        let added =
            vec3(nearness_to_depth(sums.r), nearness_to_depth(sums.g), nearness_to_depth(sums.b));
        let depths = min(added, vec3(small_depth(view, at)));
        let last = max(max(depths.r, depths.g), depths.b);
        textureStore(opaques, view.origin + at, view.layer, vec4(last));
        textureStore(colored, view.origin + at, view.layer, vec4(depths, 1.0));
        clear_sums(sum);
    }
}
