//! Absorbing closed meshes: closed forms, and rays in 64 bits, against the CPU reference and both tiers.
use crate::common::{
    Tier,
    files::read,
    scenes::{empty, hold_view, light, material, triangle},
    tiers,
};
use gobo::{
    glam::{DVec3, Mat3, Vec3, Vec4},
    model::{
        Counters, LightKind, Material, Projection, Transfer, Triangle, is_closed, turn_outwards,
    },
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Rounding of the filter's storage.
const ROUNDING: f64 = 1e-3;
/// Transmittance of [`DISTANCE`] metres.
pub(crate) const COLOR: DVec3 = DVec3::new(0.25, 0.5, 1.0);
pub(crate) const DISTANCE: f64 = 2.0;
pub(crate) const FOG: u32 = 0;
pub(crate) const WALL: u32 = 1;

pub(crate) fn fog() -> Material {
    let (attenuation_color, attenuation_distance) = (COLOR.as_vec3(), DISTANCE as f32);
    Material { attenuation_color, attenuation_distance, ..material(Transfer::Filter) }
}

fn passed(metres: f64) -> DVec3 {
    COLOR.powf(metres / DISTANCE)
}

/// A light that looks along -z from above the origin, 20 x 20 m, for any contents.
pub(crate) fn stage(kind: LightKind) -> Scene {
    let mut scene = empty(vec![fog(), material(Transfer::Opaque)]);
    scene.lights.push(light(kind));
    scene.shadow.size = 48;
    hold_view(&mut scene, 1);
    scene
}

pub(crate) const SUN: LightKind = LightKind::Directional { direction: Vec3::NEG_Z };

pub(crate) fn spot() -> LightKind {
    LightKind::Spot { position: Vec3::Z * 9.0, direction: Vec3::NEG_Z, angle: 1.0 }
}

/// A box, counterclockwise from outside.
pub(crate) fn cuboid(min: Vec3, max: Vec3, material: u32) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in [
        Mat3::IDENTITY,
        Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X),
        Mat3::from_cols(Vec3::Z, Vec3::X, Vec3::Y),
    ] {
        for side in [-1.0, 1.0] {
            let corner = |x: f32, y: f32| {
                let unit = axis * Vec3::new(x * side, y, side);
                (min + max) * 0.5 + unit * (max - min) * 0.5
            };
            let (a, b, c, d) =
                (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
            triangles.extend([[a, b, c], [a, c, d]].map(|p| triangle(p, material)));
        }
    }
    assert!(is_closed(&triangles));
    let before = triangles.clone();
    turn_outwards(&mut triangles);
    assert_eq!(triangles, before);
    triangles
}

/// A floor as large as the stage.
pub(crate) fn floor(z: f32, material: u32) -> [Triangle; 2] {
    let corner = |x: f32, y: f32| Vec3::new(x * 9.9, y * 9.9, z);
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    [[a, b, c], [a, c, d]].map(|positions| triangle(positions, material))
}

/// Maps and counters of CPU reference and tiers.
pub(crate) fn all_maps(scene: &Scene) -> Vec<(Vec<ViewMaps>, Counters)> {
    let mut all = vec![render_maps(scene, &shadow_views(scene))];
    for tier in tiers(Tier::Native) {
        let frame = crate::common::map_frame(tier, scene);
        all.push((frame.maps, frame.counters));
    }
    all
}

/// Origin and unit direction of a texel's ray, in 64 bits.
pub(crate) fn ray(maps: &ViewMaps, texel: usize) -> (DVec3, DVec3) {
    let view = &maps.view;
    let (x, y) = (texel as u32 % view.size.x, texel as u32 / view.size.x);
    let scale = f64::from(view.scale);
    let size = view.size.as_dvec2();
    let aside_x = (f64::from(x) + 0.5 - size.x * 0.5) / scale;
    let aside_y = (size.y * 0.5 - f64::from(y) - 0.5) / scale;
    let world = view.view_from_world.as_dmat4().inverse();
    let near = f64::from(view.near);
    if view.projection == Projection::Perspective {
        let way = world.transform_vector3(DVec3::new(aside_x, aside_y, -1.0));
        (world.w_axis.truncate() + way * near, way.normalize())
    } else {
        let start = world.transform_point3(DVec3::new(aside_x, aside_y, -near));
        (start, world.transform_vector3(DVec3::NEG_Z))
    }
}

/// Distances along the ray of its hits with triangles of a material, and the smallest distance of a miss from
/// an edge [share of a side]. Möller and Trumbore 1997.
pub(crate) fn meet(scene: &Scene, material: u32, start: DVec3, way: DVec3) -> (Vec<f64>, f64) {
    let (mut met, mut edge) = (Vec::new(), 1.0_f64);
    for triangle in scene.triangles.iter().filter(|t| t.material == material) {
        let [a, b, c] = triangle.positions.map(Vec3::as_dvec3);
        let (ab, ac, s) = (b - a, c - a, start - a);
        let p = way.cross(ac);
        let q = s.cross(ab);
        let whole = ab.dot(p);
        if whole.abs() < 1e-12 {
            continue;
        }
        let (u, v, t) = (s.dot(p) / whole, way.dot(q) / whole, ac.dot(q) / whole);
        let inside = u.min(v).min(1.0 - u - v);
        edge = edge.min(inside.abs());
        if inside >= 0.0 {
            met.push(t);
        }
    }
    met.sort_by(f64::total_cmp);
    (met, edge)
}

/// Checks all texels whose rays are clear of edges against rays in 64 bits.
fn check(scene: &Scene) {
    let mut compared = 0;
    for (maps, _) in all_maps(scene) {
        for maps in &maps {
            for texel in 0..maps.filter.len() {
                let (start, way) = ray(maps, texel);
                let (faces, edge) = meet(scene, FOG, start, way);
                let (walls, _) = meet(scene, WALL, start, way);
                if edge < 0.02 {
                    continue;
                }
                let axis = maps.view.direction().as_dvec3();
                let far = f64::from(maps.view.far - maps.view.near) / way.dot(axis);
                let end = walls.iter().copied().find(|t| *t > 0.0).unwrap_or(far).min(far);
                // Faces behind the start are entered before it.
                let ways: Vec<f64> = faces.iter().map(|t| t.clamp(0.0, end)).collect();
                assert!(ways.len().is_multiple_of(2));
                let metres: f64 = ways.chunks(2).map(|pair| pair[1] - pair[0]).sum();
                let found = Vec3::from_array(maps.filter[texel]).as_dvec3();
                let wrong = (found - passed(metres)).abs().max_element();
                assert!(wrong <= ROUNDING, "texel {texel}: {found} after {metres} m");
                let inside = faces.iter().filter(|t| **t < 0.0).count() % 2 == 1;
                let enters = ways.iter().copied().find(|t| *t > 0.0 && *t < end);
                let first = if inside { Some(0.0) } else { enters };
                let depth = first.map_or(1.0, |t| t / far);
                assert!((f64::from(maps.nearest[texel]) - depth).abs() < 1e-5, "texel {texel}");
                compared += 1;
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

fn middle(maps: &ViewMaps) -> usize {
    (maps.view.size.y / 2 * maps.view.size.x + maps.view.size.x / 2) as usize
}

#[test]
fn a_box_absorbs_along_its_depth() {
    for kind in [SUN, spot()] {
        let mut scene = stage(kind);
        scene.triangles.extend(cuboid(Vec3::new(-3.0, -2.5, -1.5), Vec3::new(2.6, 3.3, 1.7), FOG));
        check(&scene);
        let (maps, _) = &all_maps(&scene)[1];
        let found = Vec3::from_array(maps[0].filter[middle(&maps[0])]).as_dvec3();
        let stretch = if kind == SUN { 1.0 } else { 1.0003 };
        assert!((found - passed(3.2 * stretch)).abs().max_element() < ROUNDING, "{found}");
    }
}

#[test]
fn the_air_between_two_volumes_does_not_count() {
    let mut scene = stage(SUN);
    for (low, high) in [(-7.0, -6.0), (1.5, 2.0), (4.0, 5.5)] {
        let aside = Vec3::splat(low * 0.3);
        let min = Vec3::new(-3.3, -3.1, low) + aside * Vec3::new(1.0, 1.0, 0.0);
        let max = Vec3::new(3.1, 3.7, high) + aside * Vec3::new(1.0, 1.0, 0.0);
        scene.triangles.extend(cuboid(min, max, FOG));
    }
    check(&scene);
}

#[test]
fn half_in_the_ground_stops_at_the_ground() {
    for kind in [SUN, spot()] {
        let mut scene = stage(kind);
        scene.triangles.extend(cuboid(Vec3::new(-3.0, -2.5, -4.0), Vec3::new(2.6, 3.3, 1.7), FOG));
        scene.triangles.extend(floor(-1.0, WALL));
        check(&scene);
        // Entirely in the ground.
        scene.triangles.extend(floor(3.0, WALL));
        check(&scene);
    }
}

#[test]
fn a_light_inside_sees_the_rest() {
    let mut scene = stage(LightKind::Point { position: Vec3::new(0.3, -0.4, 0.2) });
    scene.shadow.size = 20;
    scene.triangles.extend(cuboid(Vec3::new(-3.0, -2.5, -4.0), Vec3::new(2.6, 3.3, 1.7), FOG));
    check(&scene);
    let mut cut = stage(SUN);
    // Near and far planes within the box.
    (cut.lights[0].near, cut.lights[0].far) = (Some(9.0), Some(12.0));
    cut.triangles.extend(cuboid(Vec3::new(-3.0, -2.5, -4.0), Vec3::new(2.6, 3.3, 1.7), FOG));
    check(&cut);
}

/// A sphere of `level` subdivisions of an icosahedron.
pub(crate) fn ball(level: u32, center: Vec3, radius: f32) -> Vec<Triangle> {
    let toml = format!(
        "[[material]]\nname = \"a\"\nattenuation_distance = 1\nattenuation_color = [0, 0, 0]\n\
         [[shape]]\nkind = \"sphere\"\nmaterial = \"a\"\nlevel = {level}\n\
         translation = {center:?}\nscale = [{0}, {0}, {0}]\n",
        radius * 2.0,
        center = center.to_array(),
    );
    read(&toml).unwrap().triangles
}

#[test]
fn balls_absorb_along_their_chord() {
    for kind in [SUN, spot()] {
        let mut scene = stage(kind);
        scene.shadow.size = 24;
        scene.triangles.extend(ball(2, Vec3::new(1.0, -0.5, -1.0), 4.1));
        scene.triangles.extend(ball(1, Vec3::new(-2.0, 0.7, 5.5), 1.5));
        scene.triangles.extend(floor(-2.0, WALL));
        check(&scene);
    }
}

/// Slabs one behind another that fill half of `depth`.
fn slabs(count: u32, depth: f32) -> Vec<Triangle> {
    let step = depth / count as f32;
    let slab = |i: u32| {
        let z = depth * 0.5 - i as f32 * step;
        cuboid(Vec3::new(-3.1, -3.3, z - step * 0.5), Vec3::new(3.3, 3.7, z), FOG)
    };
    (0..count).flat_map(slab).collect()
}

#[test]
fn segments_of_signed_sums_are_composed() {
    let mut scene = stage(SUN);
    scene.shadow.size = 16;
    scene.triangles.extend(slabs(1200, 8.0));
    for (maps, counters) in all_maps(&scene) {
        assert!(counters.segments >= 3, "{counters:?}");
        let found = Vec3::from_array(maps[0].filter[middle(&maps[0])]).as_dvec3();
        let wrong = (found - passed(4.0)).abs().max_element();
        assert!(wrong <= ROUNDING, "{found} instead of {}", passed(4.0));
    }
}

#[test]
fn overflow_costs_volumes_nothing() {
    let mut scene = stage(SUN);
    scene.shadow.size = 16;
    scene.triangles.extend(slabs(100, 8.0));
    scene.triangles.extend(floor(-1.05, WALL));
    scene.shadow.pair_budget = 150;
    for (maps, counters) in all_maps(&scene) {
        assert!(counters.overflowed > 0 && counters.unordered == 0, "{counters:?}");
        let found = Vec3::from_array(maps[0].filter[middle(&maps[0])]).as_dvec3();
        // 63 slabs, and 1 cm of the next.
        let metres = 63.0 * 0.04 + 0.01;
        let wrong = (found - passed(metres)).abs().max_element();
        assert!(wrong <= ROUNDING, "{found} instead of {}", passed(metres));
    }
}

/// Volumes with panes and `over`, which are composed first.
#[test]
fn volumes_filter_beside_other_casters() {
    let gel = Material { tint: Vec4::new(0.5, 0.9, 0.3, 0.8), ..material(Transfer::Filter) };
    let over = Material { tint: Vec4::new(0.2, 0.3, 0.9, 0.5), ..material(Transfer::Over) };
    let mut scene = stage(SUN);
    scene.materials.extend([gel, over]);
    scene.triangles.extend(cuboid(Vec3::new(-3.0, -2.5, -1.5), Vec3::new(2.6, 3.3, 1.7), FOG));
    for (z, material) in [(3.0, 2), (-3.0, 3)] {
        scene.triangles.extend(floor(z, material));
    }
    let gel = DVec3::ONE - 0.8 * (DVec3::ONE - DVec3::new(0.5, 0.9, 0.3));
    let expected = (gel * 0.5 + 0.5 * DVec3::new(0.2, 0.3, 0.9)) * passed(3.2);
    for (maps, _) in all_maps(&scene) {
        let found = Vec3::from_array(maps[0].filter[middle(&maps[0])]).as_dvec3();
        assert!((found - expected).abs().max_element() <= ROUNDING, "{found} {expected}");
    }
}

#[test]
fn bodies_that_are_mirrored_or_open() {
    let solid = ball(1, Vec3::ZERO, 1.0);
    let mut mirrored: Vec<_> = solid.clone();
    for triangle in &mut mirrored {
        triangle.positions = triangle.positions.map(|p| p * Vec3::new(-1.0, 1.0, 1.0));
    }
    let flipped = mirrored.clone();
    turn_outwards(&mut mirrored);
    assert!(is_closed(&mirrored) && mirrored != flipped);
    assert!(!is_closed(&solid[1..]));
    let material =
        "[[material]]\nname = \"a\"\nattenuation_distance = 1\nattenuation_color = [0, 1, 1]\n";
    for kind in ["plane", "pane"] {
        let toml = format!("{material}[[shape]]\nkind = \"{kind}\"\nmaterial = \"a\"\n");
        assert!(read(&toml).unwrap_err().to_string().contains("needs an inside"));
    }
    let particles = format!(
        "{material}[[particles]]\nmaterial = \"a\"\ngenerate = {{ kind = \"cloud\", count = 1 }}\n"
    );
    assert!(read(&particles).unwrap_err().to_string().contains("no volume"));
}

/// A volume thicker than the sums can hold is black, not bright.
#[test]
fn tar_is_black() {
    let mut scene = stage(SUN);
    scene.materials[0].attenuation_distance = 1e-6;
    scene.triangles.extend(cuboid(Vec3::new(-9.0, -9.0, -9.0), Vec3::new(9.0, 9.0, 9.0), FOG));
    for (maps, _) in all_maps(&scene) {
        assert_eq!(maps[0].filter[middle(&maps[0])], [0.0, 0.0, 1.0]);
    }
}
