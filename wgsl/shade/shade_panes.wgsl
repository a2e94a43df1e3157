// shade, panes: the two nearest panes of each pixel of a band, as points. One invocation per pixel.
// CPU twin: src/reference/shade/mod.rs. Host: src/stage/shade.rs.

import package::bind::sampled::layers;
import package::bind::uniform::{band, materials, views};
import package::hit::caster_hit::{triangle_hit, triangle_weights};
import package::records::light::cluster_of;
import package::records::owner::owner_tag;
import package::records::point::{POINT_PANE, Point, pixel_number};
import package::records::record::record_texel;
import package::records::setup::setup_texel;
import package::records::view::GpuView;
import package::shade::band::band_pixel;
import package::shade::environment::from_around;
import package::shade::layer::{LAYER_TEXELS, NOWHERE, Pane, pane_of};
import package::shade::pane::{mirrored_share, scattered_share, seen_color, pane_gloss};
import package::shade::store_point::store_point;
import package::shade::surface::{eye, normals_at, pane_caster, world_point};
import package::walk::lane::LANES;

fn of_pane(view: GpuView, pixel: vec2<f32>, pane: Pane) -> Point {
    let hit = triangle_hit(pane.setup, pixel);
    let material = materials[hit.material];
    let position = world_point(view, pixel, pane.depth);
    let to_eye = normalize(eye() - position);
    let weights = triangle_weights(pane.setup, pixel).xyz;
    let normals = normals_at(pane_caster(pane.setup), pane.setup, weights, to_eye);
    let gloss = pane_gloss(hit, material);
    let mirror = mirrored_share(hit, material, normals.normal, to_eye);
    let scattered = scattered_share(hit, material, true) * (1.0 - mirror);
    return Point(
        POINT_PANE,
        position,
        normals.face,
        normals.normal,
        0.0,
        cluster_of(pixel, pane.depth),
        material.receives,
        owner_tag(setup_texel(pane.setup, 6u).w),
        scattered * seen_color(hit, material.transfer),
        material.roughness,
        gloss.reflectivity,
        gloss.polish,
        mirror * from_around(reflect(-to_eye, normals.normal), material.roughness),
        0.0,
        pixel_number(pixel),
    );
}

@compute @workgroup_size(LANES)
fn shade_panes(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = views[0];
    let at = band_pixel(workgroup, workgroups, lane, view.tiles_x);
    for (var i = 0u; i < 2u; i += 1u) {
        let pane = pane_of(textureLoad(layers, record_texel(at.index * LAYER_TEXELS + 2u + i), 0));
        var point: Point;
        if pane.depth < NOWHERE {
            point = of_pane(view, vec2<f32>(at.pixel) + 0.5, pane);
        }
        store_point((1u + i) * band.pixel_count + at.index, point);
    }
}
