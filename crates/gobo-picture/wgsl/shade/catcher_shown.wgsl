// Surfaces that show the surroundings behind them, times the share of the light that reaches them: the light
// that `light_points` will multiply with is divided out. CPU reference: `caught` in
// crates/gobo-reference/src/shading/mod.rs.

import package::records::light::{cluster_list, light_record, listed_index};
import package::records::point::{NO_COAT, Point};
import package::shade::environment::from_around;
import package::shade::incoming::incoming;
import package::shade::irradiance::irradiance;
import package::shade::shading::PER_PI;

fn caught(point: Point, catches: bool, to_eye: vec3<f32>) -> Point {
    if !catches {
        return point;
    }
    var whole = irradiance(point.normal);
    let list = cluster_list(point.cluster);
    for (var i = 0u; i < list.count; i += 1u) {
        let arriving = incoming(light_record(listed_index(list, i)), point.position);
        whole += arriving.color * (max(dot(point.normal, arriving.toward), 0.0) * PER_PI);
    }
    let behind = from_around(-to_eye, 0.0);
    let is_lit = whole > vec3(0.0);
    var shown = point;
    shown.albedo = select(vec3(0.0), behind / whole, is_lit);
    shown.emission = select(behind, vec3(0.0), is_lit);
    shown.reflectivity = 0.0;
    shown.polish = 0.0;
    shown.metallic = 0.0;
    shown.coat = NO_COAT;
    return shown;
}
