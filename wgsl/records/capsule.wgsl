// Capsules of strands as uploaded, behind the Gaussians' axes in `casters`. Rust: src/records/capsule.rs.

import package::bind::sampled::casters;
import package::records::caster::CASTER_TEXELS;
import package::records::footprint::Footprint;
import package::records::record::record_texel;

const CAPSULE_MARK: u32 = 0xfffeu; // in place of a footprint's base opacity

struct Capsule {
    first: vec3<f32>, // ends, world space [m]
    last: vec3<f32>,
    radii: vec2<f32>, // [m]
    first_plane: vec3<f32>, // unit normals of the planes through the ends, from the first to the last
    last_plane: vec3<f32>,
}

fn is_capsule(footprint: Footprint) -> bool {
    return (footprint.look.z & 0xffffu) == CAPSULE_MARK;
}

// `record`: of the capsule, stated by its particle's id.
fn capsule_of(record: u32) -> Capsule {
    let at = CASTER_TEXELS * record;
    let first = bitcast<vec4<f32>>(textureLoad(casters, record_texel(at), 0));
    let first_plane = bitcast<vec4<f32>>(textureLoad(casters, record_texel(at + 1u), 0));
    let last = bitcast<vec4<f32>>(textureLoad(casters, record_texel(at + 2u), 0));
    let last_plane = bitcast<vec4<f32>>(textureLoad(casters, record_texel(at + 3u), 0));
    return Capsule(first.xyz, last.xyz, vec2(first.w, last.w), first_plane.xyz, last_plane.xyz);
}
