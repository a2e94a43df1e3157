// Records from textures: where a stage has few storage buffers, or the adapter reads them slowly. Records
// that kernels have written were copied there.

import package::bind::sampled::casters;
import package::records::record::{CasterRecord, record_texel};

const CASTER_TEXELS: u32 = 2u;

fn caster_record(index: u32) -> CasterRecord {
    let at = CASTER_TEXELS * index;
    let place = bitcast<vec4<f32>>(textureLoad(casters, record_texel(at), 0));
    let look = textureLoad(casters, record_texel(at + 1u), 0);
    return CasterRecord(place.xyz, place.w, look.x, look.y, look.z, look.w);
}
