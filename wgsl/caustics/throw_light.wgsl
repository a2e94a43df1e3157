// caustics, throw: adds the light of a map's texels to the texels where glass throws it. One invocation per
// texel. CPU reference: crates/gobo-reference/src/caustics.rs. Rust: src/stage/caustics.rs.

import package::bind::changed::caustics;
import package::bind::read::glass_owners;
import package::bind::sampled::filters;
import package::bind::uniform::{caustic_params, views};
import package::caustics::landing::landing;
import package::records::glass::{CARRY_BITS, CAUSTIC_ONE, THROWN_BIT};
import package::records::view::GpuView;

override WORKGROUP_SIZE: u32;

// Adds to a texel; a sum past 32 bits carries, so that the result does not depend on the order.
fn add_caustic(view: GpuView, place: vec2<f32>, light: vec3<f32>) {
    let texel = vec2<u32>(clamp(place, vec2(0.0), view.size - 1.0));
    let first = 4u * (caustic_params.first + texel.y * u32(view.size.x) + texel.x);
    let added = vec3<u32>(light * CAUSTIC_ONE + 0.5);
    for (var i = 0u; i < 3u; i += 1u) {
        let former = atomicAdd(&caustics[first + i], added[i]);
        if added[i] > ~former {
            atomicAdd(&caustics[first + 3u], 1u << (CARRY_BITS * i));
        }
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn throw_light(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    let view = views[0];
    let width = u32(view.size.x);
    if index >= width * u32(view.size.y) {
        return;
    }
    let owner = glass_owners[2u * index];
    if owner == 0u {
        return;
    }
    atomicOr(&caustics[4u * (caustic_params.first + index) + 3u], THROWN_BIT);
    let texel = vec2(index % width, index / width);
    let rays = caustic_params.rays;
    let count = select(0u, rays * rays, owner != 0u);
    let light = textureLoad(filters, view.origin + texel, view.layer, 0).rgb / f32(rays * rays);
    for (var i = 0u; i < count; i += 1u) {
        let part = vec2(f32(i % rays), f32(i / rays)) + 0.5;
        let landed = landing(view, vec2<f32>(texel) + part / f32(rays), ~owner);
        if landed.is_there {
            let corner = floor(landed.at - 0.5);
            let far = landed.at - 0.5 - corner;
            let near = 1.0 - far;
            add_caustic(view, corner, light * (near.x * near.y));
            add_caustic(view, corner + vec2(1.0, 0.0), light * (far.x * near.y));
            add_caustic(view, corner + vec2(0.0, 1.0), light * (near.x * far.y));
            add_caustic(view, corner + vec2(1.0, 1.0), light * (far.x * far.y));
        }
    }
}
