// shade, casters: centre of each visible translucent particle, as a point. One invocation per footprint of
// the camera's view. CPU reference: crates/gobo-reference/src/shade/mod.rs. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::sampled::{casters, rects};
import package::bind::uniform::{materials, point_batch};
import package::features::HAS_CAPSULES;
import package::records::capsule::capsule_of;
import package::records::caster::{look_material, particle_object};
import package::records::footprint::caster_of;
import package::records::footprint_loaded::load_footprint;
import package::records::light::cluster_of;
import package::records::material::SHAPE_CAPSULE;
import package::records::owner::owner_tag;
import package::records::point::{POINT_NONE, POINT_PARTICLE, POINT_STRAND, Point};
import package::records::record::record_texel;
import package::shade::store_point::store_point;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_casters(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if index >= point_batch.count {
        return;
    }
    let id_in_view = point_batch.first + index;
    let footprint = load_footprint(id_in_view);
    let is_particle = !footprint.is_triangle;
    let is_seen = textureLoad(rects, record_texel(id_in_view), 0).g != 0u;
    let caster = select(0u, caster_of(footprint), is_particle);
    let sphere = bitcast<vec4<f32>>(textureLoad(casters, record_texel(caster * 2u), 0));
    let look = textureLoad(casters, record_texel(caster * 2u + 1u), 0);
    var point: Point;
    point.kind = select(POINT_NONE, POINT_PARTICLE, is_particle && is_seen);
    point.position = sphere.xyz;
    // Does not shadow itself: the bias is its radius.
    point.reach = sphere.w;
    point.cluster = cluster_of(footprint.bounds.xy, footprint.bounds.w);
    point.receives = materials[look_material(look)].receives;
    point.tag = owner_tag(look.w);
    point.albedo = vec3(1.0);
    if HAS_CAPSULES && is_particle && materials[look_material(look)].shape == SHAPE_CAPSULE {
        let capsule = capsule_of(look.w);
        let along = capsule.last - capsule.first;
        point.kind = select(POINT_NONE, POINT_STRAND, is_seen);
        point.normal = along / max(length(along), 1e-30);
        point.reach = max(capsule.radii.x, capsule.radii.y);
        point.tag = owner_tag(particle_object(look.w));
        point.roughness = materials[look_material(look)].roughness;
    }
    store_point(index, point);
}
