// shade, surfaces: visible opaque surfaces, or the sky, as points, and a list of those that are lit. One
// invocation per pixel of a band. CPU reference: crates/gobo-reference/src/shade/mod.rs. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::seen_pixels;
import package::bind::picture_out::lit;
import package::bind::uniform::{materials, views};
import package::features::{
    HAS_CAPSULES, HAS_COATS, HAS_DETAILS, HAS_ENVIRONMENT, HAS_PARTICLES, HAS_TEXTURES, HAS_TRIANGLES,
    TAKES_LIGHT,
};
import package::hit::triangle::{triangle_color, triangle_image, triangle_weights};
import package::records::caster::{capsule_of, caster_color, material_of, particle_object};
import package::records::footprint::setup_texel;
import package::records::light::cluster_of;
import package::records::mask::pixel_number;
import package::records::material::{
    GpuMaterial, NO_TEXTURE, SHAPE_CAPSULE, shows_clear, shows_color, shows_surroundings,
};
import package::records::point::{NO_COAT, POINT_LEAF, POINT_NONE, POINT_SOLID, Point};
import package::records::point_list::SURFACE_LIST;
import package::records::record::{TRIANGLE_BIT, record_texel};
import package::records::texel::owner_tag;
import package::records::view::GpuView;
import package::shade::band::band_pixel;
import package::shade::coat::{coat_mirrored, past_coat};
import package::shade::details::{details_at, emission_at, far_side};
import package::shade::environment::from_around;
import package::shade::normals::{normals_at, rounded};
import package::shade::point_light::ambient;
import package::shade::points::{append_point, store_point};
import package::shade::shading::{irradiance, mirrored_solid};
import package::shade::surface::{eye, world_point};
import package::shade::taken_light::taken_light;
import package::traversal::lane::LANES;
import choice::catcher::caught;
import choice::records::caster_record;

fn nothing(view: GpuView, pixel: vec2<f32>) -> Point {
    let ray = normalize(world_point(view, pixel, 1.0) - eye());
    var point: Point;
    point.kind = POINT_NONE;
    point.emission = from_around(ray, 0.0);
    return point;
}

// Where the surroundings are two colours, only metal mirrors them.
fn mirrored_around(
    material: GpuMaterial,
    albedo: vec3<f32>,
    normal: vec3<f32>,
    to_eye: vec3<f32>,
) -> vec3<f32> {
    if !HAS_ENVIRONMENT && material.metallic == 0.0 {
        return vec3(0.0);
    }
    let share = mirrored_solid(albedo, material.metallic, dot(normal, to_eye), material.roughness);
    let shown = select(material.metallic, 1.0, HAS_ENVIRONMENT);
    return share * shown * from_around(reflect(-to_eye, normal), material.roughness);
}

fn of_triangle(view: GpuView, pixel: vec2<f32>, depth: f32, id: u32, setup: u32) -> Point {
    let weights = triangle_weights(setup, pixel).xyz;
    var material = materials[setup_texel(setup, 4u).w];
    var albedo = material.tint.rgb * triangle_color(setup, weights).rgb;
    if HAS_TEXTURES && material.texture != NO_TEXTURE {
        let all_colors = shows_clear(material.transfer);
        let size = material.texture_size;
        albedo *= triangle_image(material.texture, size, setup, pixel, weights, all_colors).rgba.rgb;
    }
    let position = world_point(view, pixel, depth);
    let to_eye = normalize(eye() - position);
    let normals = normals_at(id, setup, weights, to_eye);
    let details = details_at(material, setup, pixel, weights, id, normals.normal);
    material.roughness = details.roughness;
    material.metallic = details.metallic;
    let around = details.open * mirrored_around(material, albedo, details.normal, to_eye);
    let is_lit = !shows_color(material);
    let far = far_side(material, setup, pixel, weights);
    let emission = emission_at(material, setup, pixel, weights) + select(albedo, around, is_lit);
    var point = Point(
        select(POINT_SOLID, POINT_LEAF, far.is_there),
        // Light from the far side is looked up in front of the facet, on that side.
        select(rounded(id, weights, normals.face, position), position, far.is_there),
        normals.face,
        details.normal,
        0.0,
        cluster_of(pixel, depth),
        material.receives,
        owner_tag(setup_texel(setup, 6u).w),
        select(vec3(0.0), albedo * far.near, is_lit),
        material.roughness,
        0.0,
        select(0.0, 1.0, is_lit),
        emission + far.color * irradiance(-details.normal),
        material.metallic,
        pixel_number(pixel),
        0u,
        far.color,
        NO_COAT,
    );
    if HAS_COATS && is_lit && !far.is_there {
        point.coat = details.coat;
        let mirrored = reflect(-to_eye, point.coat.normal);
        let coat = details.open * from_around(mirrored, point.coat.roughness);
        point.emission = mix(point.emission, coat, coat_mirrored(point.coat, to_eye));
    }
    if HAS_DETAILS {
        // Ambient light is added behind the lights.
        let taken = (1.0 - details.open) * past_coat(point, to_eye);
        point.emission -= taken * (1.0 - point.metallic) * point.albedo * ambient(point);
    }
    return caught(point, shows_surroundings(material), to_eye);
}

fn of_particle(view: GpuView, pixel: vec2<f32>, depth: f32, id: u32) -> Point {
    let record = caster_record(id);
    let material = materials[material_of(record)];
    let color = caster_color(record, material.transfer).rgb;
    let position = world_point(view, pixel, depth);
    // Normal of the sphere.
    let aside = (position - record.center) / record.radius;
    let to_eye = normalize(eye() - position);
    var normal = normalize(aside + to_eye * sqrt(max(1.0 - dot(aside, aside), 0.05)));
    var reach = record.radius;
    var object = record.id;
    if HAS_CAPSULES && material.shape == SHAPE_CAPSULE {
        let capsule = capsule_of(record.id);
        let along = capsule.last - capsule.first;
        let off = position - capsule.first;
        let out = off - along * (dot(off, along) / max(dot(along, along), 1e-30));
        reach = length(out);
        normal = select(to_eye, out / reach, reach > 0.0);
        object = particle_object(record.id);
    }
    let albedo = material.tint.rgb * color;
    let point = Point(
        POINT_SOLID,
        position,
        normal,
        normal,
        reach,
        cluster_of(pixel, depth),
        material.receives,
        owner_tag(object),
        albedo,
        material.roughness,
        0.0,
        1.0,
        material.emission + mirrored_around(material, albedo, normal, to_eye),
        material.metallic,
        pixel_number(pixel),
        0u,
        vec3(0.0),
        NO_COAT,
    );
    return caught(point, shows_surroundings(material), to_eye);
}

@compute @workgroup_size(LANES)
fn shade_surfaces(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = views[0];
    let at = band_pixel(workgroup, workgroups, lane, view.tiles_x);
    let pixel = vec2<f32>(at.pixel) + 0.5;
    let found = textureLoad(seen_pixels, record_texel(at.index), 0);
    let depth = bitcast<f32>(found.x);
    var point = nothing(view, pixel);
    if depth < 1.0 {
        if HAS_TRIANGLES && (found.y & TRIANGLE_BIT) != 0u {
            point = of_triangle(view, pixel, depth, found.y, found.z);
        } else if HAS_PARTICLES {
            point = of_particle(view, pixel, depth, found.y);
        }
    }
    store_point(at.index, point);
    if point.kind == POINT_NONE {
        textureStore(lit, record_texel(at.index), vec4(point.emission, 1.0));
    } else if all(at.pixel < vec2<u32>(view.size)) {
        if TAKES_LIGHT {
            let taken = taken_light(at.pixel, point, depth);
            if taken.is_even {
                textureStore(lit, record_texel(at.index), vec4(taken.light, 1.0));
                return;
            }
        }
        append_point(SURFACE_LIST, at.index);
    }
}
