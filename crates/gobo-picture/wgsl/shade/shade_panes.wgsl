// shade, panes: the two nearest panes of the pixels of a band, as points. One invocation per pane. CPU
// reference: crates/gobo-reference/src/shade/mod.rs. Rust: crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::{band, layers};
import package::bind::uniform::{materials, views};
import package::hit::triangle::{triangle_hit, triangle_weights};
import package::records::footprint::setup_texel;
import package::records::light::cluster_of;
import package::records::mask::pixel_number;
import package::records::material::TRANSFER_SMOKE;
import package::records::point::{NO_COAT, POINT_COVER, POINT_LEAF, POINT_PANE, Point};
import package::records::point_list::{point_at, point_count};
import package::records::record::record_texel;
import package::records::texel::owner_tag;
import package::records::view::GpuView;
import package::shade::band::indexed_pixel;
import package::shade::details::far_side;
import package::shade::environment::from_around;
import package::shade::layer::{
    LAYER_TEXELS, Pane, mirrored_share, pane_gloss, pane_of, scattered_share, seen_color,
};
import package::shade::normals::{normals_at, pane_caster};
import package::shade::points::store_point;
import package::shade::shading::irradiance;
import package::shade::surface::{eye, world_point};

override WORKGROUP_SIZE: u32;

fn of_pane(view: GpuView, pixel: vec2<f32>, pane: Pane) -> Point {
    let hit = triangle_hit(pane.setup, pixel, 1.0);
    let material = materials[hit.material];
    let position = world_point(view, pixel, pane.depth);
    let to_eye = normalize(eye() - position);
    let weights = triangle_weights(pane.setup, pixel).xyz;
    let normals = normals_at(pane_caster(pane.setup), pane.setup, weights, to_eye);
    let gloss = pane_gloss(hit, material);
    let mirror = mirrored_share(hit, material, normals.normal, to_eye);
    let scattered = scattered_share(hit, material, true) * (1.0 - mirror);
    let far = far_side(material, pane.setup, pixel, weights);
    let mirrored = mirror * from_around(reflect(-to_eye, normals.normal), material.roughness);
    let kind = select(POINT_PANE, POINT_COVER, material.transfer == TRANSFER_SMOKE);
    return Point(
        select(kind, POINT_LEAF, far.is_there),
        position,
        normals.face,
        normals.normal,
        0.0,
        cluster_of(pixel, pane.depth),
        material.receives,
        owner_tag(setup_texel(pane.setup, 6u).w),
        scattered * far.near * seen_color(hit, material.transfer),
        material.roughness,
        gloss.reflectivity,
        gloss.polish,
        mirrored + scattered * far.color * irradiance(-normals.normal),
        0.0,
        pixel_number(pixel),
        0u,
        scattered * far.color,
        NO_COAT,
    );
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_panes(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if index >= point_count() {
        return;
    }
    let view = views[0];
    let point = point_at(index);
    let at = indexed_pixel(point % band.pixel_count, view.tiles_x);
    let slot = point / band.pixel_count - 1u;
    let pane = pane_of(textureLoad(layers, record_texel(at.index * LAYER_TEXELS + 2u + slot), 0));
    store_point(point, of_pane(view, vec2<f32>(at.pixel) + 0.5, pane));
}
