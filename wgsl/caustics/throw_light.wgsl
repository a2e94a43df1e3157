// caustics, throw: adds the light of a map's texels to the texels where glass throws it. One invocation per
// texel and, where glass disperses light, per channel. CPU reference: crates/gobo-reference/src/caustics.rs.
// Rust: src/stage/caustics.rs.

import package::bind::changed::caustics;
import package::bind::read::glass_owners;
import package::bind::sampled::filters;
import package::bind::uniform::{caustic_params, views};
import package::caustics::glass_face::{glass_face, light_ray};
import package::caustics::landing::{Landed, landing};
import package::caustics::light_views::{
    in_view, is_cube, map_place, seen, texel_number, texel_share,
};
import package::records::glass::{CARRY_BITS, CAUSTIC_ONE, THROWN_BIT};

override WORKGROUP_SIZE: u32;

// Most points along the edge of a texel that its light is divided into, over its rays and their footprints.
const MAX_PARTS: u32 = 32u;
// Largest edge of a ray's footprint [texels].
const MAX_FOOTPRINT: f32 = 64.0;
// Edge of a footprint where the neighbouring ray lands nowhere, [texels].
const USUAL_FOOTPRINT: f32 = 8.0;

// Workgroup size.
const TEXEL_LANES: u32 = 64u;
// Points of a row: most rays along the edge of a texel, and the one after them.
const KEPT_POINTS: u32 = 9u;

// Landing places of the row above, of each lane [texels], and their views, or 0 for nowhere, plus 1.
var<workgroup> kept_places: array<vec2<f32>, TEXEL_LANES * KEPT_POINTS>;
var<workgroup> kept_views: array<u32, TEXEL_LANES * KEPT_POINTS>;

// Adds to a texel; a sum past 32 bits carries, so that the result does not depend on the order. `rest`: what
// rounding left of the light before; returns what it leaves now.
fn add_caustic(number: u32, place: vec2<f32>, light: vec3<f32>, rest: vec3<f32>) -> vec3<f32> {
    let first = 4u * (caustic_params.first + texel_number(number, place));
    let whole = light * CAUSTIC_ONE + rest;
    let added = vec3<u32>(whole);
    for (var i = 0u; i < 3u; i += 1u) {
        let former = atomicAdd(&caustics[first + i], added[i]);
        if added[i] > ~former {
            atomicAdd(&caustics[first + 3u], 1u << (CARRY_BITS * i));
        }
    }
    return whole - vec3<f32>(added);
}

fn add_to_four(number: u32, place: vec2<f32>, light: vec3<f32>, before: vec3<f32>) -> vec3<f32> {
    let corner = floor(place - 0.5);
    let far = place - 0.5 - corner;
    let near = 1.0 - far;
    var rest = add_caustic(number, corner, light * (near.x * near.y), before);
    rest = add_caustic(number, corner + vec2(1.0, 0.0), light * (far.x * near.y), rest);
    rest = add_caustic(number, corner + vec2(0.0, 1.0), light * (near.x * far.y), rest);
    return add_caustic(number, corner + vec2(1.0, 1.0), light * (far.x * far.y), rest);
}

// Way from the place of a ray to that of its neighbour, which may be in the map of another face [texels].
fn way_to(landed: Landed, next: Landed, usual: vec2<f32>) -> vec2<f32> {
    var at = next.at;
    if next.is_there && next.number != landed.number {
        let ray = light_ray(next.number, next.at).step;
        at = map_place(views[landed.number], in_view(landed.number, ray));
    }
    let way = select(usual * USUAL_FOOTPRINT, at - landed.at, next.is_there);
    return way * min(1.0, MAX_FOOTPRINT / max(length(way), 1e-6));
}

fn kept_landing(kept: u32) -> Landed {
    let number = kept_views[kept];
    return Landed(number != 0u, max(number, 1u) - 1u, kept_places[kept]);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn throw_light(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    let own = caustic_params.number;
    let view = views[own];
    let width = u32(view.size.x);
    if index >= width * u32(view.size.y) {
        return;
    }
    let texel = caustic_params.base + index;
    let stored = glass_owners[2u * texel];
    if stored == 0u {
        return;
    }
    let owner = ~stored;
    let disperses = glass_face(owner).spread > 0.0;
    if id.z > 0u && !disperses {
        return;
    }
    atomicOr(&caustics[4u * (caustic_params.first + texel) + 3u], THROWN_BIT);
    let shift = select(0.0, f32(id.z) - 1.0, disperses);
    let channel = select(vec3(1.0), vec3(f32(id.z == 0u), f32(id.z == 1u), f32(id.z == 2u)), disperses);
    let at = vec2(index % width, index / width);
    let rays = caustic_params.rays;
    let edge = 1.0 / f32(rays);
    var rest = vec3(0.5);
    let light = textureLoad(filters, view.origin + at, view.layer, 0).rgb * channel * (edge * edge);
    // The texel's rays, and those after the last ones, which end their footprints. No loop depends on
    // uniforms alone.
    let points = select(0u, rays + 1u, stored != 0u);
    for (var i = 0u; i < points * points; i += 1u) {
        let column = i % points;
        let row = i / points;
        let kept = lane * KEPT_POINTS + column;
        let place = vec2<f32>(at) + (vec2(f32(column), f32(row)) + 0.5) * edge;
        // One call for all keeps the kernel small.
        var below = Landed(false, 0u, vec2(0.0));
        if column < rays || row < rays {
            below = landing(own, place, owner, shift);
        }
        // Light of the ray above falls on what lies between the places where it and its neighbours land.
        if row > 0u && column < rays && kept_views[kept] != 0u {
            let landed = kept_landing(kept);
            let across = way_to(landed, kept_landing(kept + 1u), vec2(1.0, 0.0));
            let down = way_to(landed, below, vec2(0.0, 1.0));
            let wide = max(abs(across), abs(down));
            let parts = clamp(u32(ceil(max(wide.x, wide.y))), 1u, MAX_PARTS / rays);
            let share = texel_share(own, place - vec2(0.0, edge));
            let arriving = light * (share / texel_share(landed.number, landed.at));
            for (var k = 0u; k < parts * parts; k += 1u) {
                let part = (vec2(f32(k % parts), f32(k / parts)) + 0.5) / f32(parts) - 0.5;
                let to = landed.at + across * part.x + down * part.y;
                var number = landed.number;
                var texel_at = to;
                if is_cube() & (any(to < vec2(0.0)) | any(to >= view.size)) {
                    let other = seen(light_ray(number, to).step);
                    number = other.number;
                    texel_at = other.place;
                }
                rest = add_to_four(number, texel_at, arriving / f32(parts * parts), rest);
            }
        }
        kept_places[kept] = below.at;
        kept_views[kept] = select(0u, below.number + 1u, below.is_there);
    }
}
