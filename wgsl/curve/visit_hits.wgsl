// A caster of any kind meets the four texels; every hit goes into its curve at once.

import package::curve::gather::{
    corner, join, join_ramp, must_flush, opaque_depth, open_added, open_end, scale, see,
};
import package::curve::light4::{Light4, black4, light4, plus, scaled, selected};
import package::curve::volumes::{change_density, crossed, last_face, surface_scale, surface_light};
import package::features::{HAS_OVER, HAS_PUFFS, HAS_VOLUMES, ROLLED};
import package::hit::caster_hit::{Hit, MISS, caster_hit};
import package::hit::crossing::{Face, added_light, face_crossing, volume_face};
import package::records::view::GpuView;

fn ordered() -> bool {
    return false;
}

fn blocked() -> bool {
    return true;
}

fn slabbed() -> bool {
    return false;
}

fn count_hits(view: GpuView, place: vec4<u32>, look: vec4<u32>) {}

fn hit_texel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) -> Hit {
    let hit = caster_hit(view, place, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth[i]) {
        return MISS;
    }
    return hit;
}

fn added4(met: array<Hit, 4>) -> Light4 {
    return light4(added_light(met[0]), added_light(met[1]), added_light(met[2]), added_light(met[3]));
}

fn face_texel(view: GpuView, look: vec4<u32>, i: u32) -> Face {
    let face = volume_face(view, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    crossed[i] += face_crossing(face);
    return face;
}

fn density_change(face: Face) -> vec3<f32> {
    return face.metres * face.absorption * f32(-face.leaves);
}

fn cross_faces(view: GpuView, look: vec4<u32>) -> vec4<bool> {
    let a = face_texel(view, look, 0u);
    let b = face_texel(view, look, 1u);
    let c = face_texel(view, look, 2u);
    let d = face_texel(view, look, 3u);
    let meets = vec4(a.leaves, b.leaves, c.leaves, d.leaves) != vec4(0);
    // Nothing changes at the last face.
    let depth = select(last_face, vec4(a.depth, b.depth, c.depth, d.depth), meets);
    let change = light4(density_change(a), density_change(b), density_change(c), density_change(d));
    return join_ramp(change_density(depth, selected(black4(), change, meets)));
}

// True where the hits cannot wait.
fn visit(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> bool {
    var ramps = vec4(false);
    if HAS_VOLUMES {
        ramps = cross_faces(view, look);
    }
    var met = array(MISS, MISS, MISS, MISS);
    for (var i = 0u; ROLLED && i < 4u; i += 1u) {
        met[i] = hit_texel(view, place, look, i);
    }
    if !ROLLED {
        met[0] = hit_texel(view, place, look, 0u);
        met[1] = hit_texel(view, place, look, 1u);
        met[2] = hit_texel(view, place, look, 2u);
        met[3] = hit_texel(view, place, look, 3u);
    }
    let light = light4(met[0].light, met[1].light, met[2].light, met[3].light);
    let opacity = vec4(met[0].opacity, met[1].opacity, met[2].opacity, met[3].opacity);
    let depth = vec4(met[0].depth, met[1].depth, met[2].depth, met[3].depth);
    let placed = join(light, depth, opacity);
    see(depth, opacity);
    if HAS_PUFFS {
        open_end = select(open_end, max(open_end, vec4(met[0].end, met[1].end, met[2].end, met[3].end)), placed);
    }
    if HAS_OVER || HAS_VOLUMES {
        scale = scaled(scale, light);
        surface_light = scaled(surface_light, light);
        surface_scale = scaled(surface_scale, light);
    }
    if HAS_OVER {
        let added = added4(met);
        open_added = plus(scaled(open_added, light), added);
        surface_light = plus(surface_light, added);
    }
    return must_flush(ramps | placed);
}
