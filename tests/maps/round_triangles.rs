//! Triangles at round positions: edges in the plane of a lamp or an eye, lamps on faces, edges and corners,
//! edges through texel centres. Truth: the renderer in 64 bits, and rays in 64 bits through closed bodies.
use super::{
    brute_force::assert_agrees,
    curve::curved,
    round::Round,
    volumes::{COLOR, DISTANCE, all_maps, cuboid, fog, ray},
};
use crate::common::{
    Tier,
    brute_force::{render, seen},
    compare::Tolerance,
    reference_picture,
    scenes::{empty, light, material, triangle},
    tiers,
};
use gobo::{
    glam::{DVec3, UVec2, Vec3, Vec4},
    model::{Camera, Light, LightKind, Material, Transfer, Triangle},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_scene::Scene;

/// Rays within a twentieth of a texel of an edge are left out: rounding decides on which side they pass.
const TOLERANCE: Tolerance = Tolerance { filter: 1e-3, depth: 1e-5, undecided: 0.25 };
const SOLID: u32 = 0;
const GLASS: u32 = 1;
const FOG: u32 = 2;
const TINT: Vec4 = Vec4::new(0.5, 0.75, 1.0, 0.5);

fn materials() -> Vec<Material> {
    vec![material(Transfer::Opaque), Material { tint: TINT, ..material(Transfer::Filter) }, fog()]
}

fn lit_by(light: Light) -> Scene {
    Scene { lights: vec![light], ..empty(materials()) }
}

/// Area below which a ray sees a triangle edge-on; it then meets others at their edges [m2].
const EDGE_ON: f64 = 1e-9;

/// A parallelogram of half edges `x` and `y`.
fn pane(center: Vec3, x: Vec3, y: Vec3, material: u32) -> [Triangle; 2] {
    let [a, b, c, d] = [-x - y, x - y, x + y, y - x].map(|corner| center + corner);
    [[a, b, c], [a, c, d]].map(|corners| triangle(corners, material))
}

fn spot_down(position: Vec3, degrees: f32) -> Light {
    let kind = LightKind::Spot { position, direction: Vec3::NEG_Y, angle: degrees.to_radians() };
    Light { near: Some(0.1), far: Some(6.0), size: Some(64), ..light(kind) }
}

/// A wall of 4 x 3 m, 1 m behind a lamp at the height of its top.
fn wall(material: u32) -> [Triangle; 2] {
    pane(Vec3::new(0.0, 1.5, -1.0), Vec3::X * 2.0, Vec3::Y * 1.5, material)
}

#[test]
fn a_wall_as_high_as_the_lamp_is_whole() {
    let lamp = Vec3::Y * 3.0;
    for material in [SOLID, GLASS] {
        let point = light(LightKind::Point { position: lamp });
        for light in [spot_down(lamp, 120.0), Light { size: Some(32), ..point }] {
            let mut scene = lit_by(light);
            scene.triangles.extend(wall(material));
            assert_agrees(&scene, TOLERANCE);
        }
    }
    // The truth itself: the wall extends from 45 degrees below the horizon down to its foot.
    let mut scene = lit_by(spot_down(lamp, 120.0));
    scene.triangles.extend(wall(SOLID));
    let truth = render(&scene, &shadow_views(&scene)[0]);
    assert_eq!(truth.iter().filter(|texel| texel.opaque < 1.0).count(), 1464);
}

/// A texel centre on the edge shared by two triangles belongs to one of them, whether or not the other
/// reaches behind the lamp.
#[test]
fn a_shared_edge_is_met_once() {
    // In the map, the edge from a to c is x + run * y = -sum texels from the centre: through texel centres.
    // The numbers of its plane are rounded in different directions.
    for (run, sum, xs, side) in [
        (1.0, 16.0, [-0.5, 0.5], 1.0),
        (2.0, 32.5, [-1.046_875, 0.984_375], 1.0),
        (2.0, 32.5, [-1.046_875, 0.984_375], -1.0),
        (3.0, 40.0, [-0.75, 1.75], 1.0),
        (3.0, 40.0, [-0.75, 1.75], -1.0),
    ] {
        let at = |x: f32, y: f32| Vec3::new(side * x, y, -1.0);
        let mut scene = lit_by(spot_down(Vec3::Y * 3.0, 90.0));
        let (a, b, c, d) = (at(xs[0], 0.0), at(1.0, 0.0), at(xs[1], 2.0), at(-1.0, 4.0));
        scene.triangles = [[a, b, c], [a, c, d]].map(|corners| triangle(corners, GLASS)).into();
        let expected = Vec3::ONE - TINT.w * (Vec3::ONE - TINT.truncate());
        for (maps, _) in all_maps(&scene) {
            let maps = &maps[0];
            let mut met = 0;
            for (texel, filter) in maps.filter.iter().enumerate() {
                let (_, way) = ray(maps, texel);
                let slope = way / -way.y * 32.0;
                let x = f64::from(side) * slope.x;
                if (x + run * slope.z + sum).abs() < 1e-6 && (-5.0..15.0).contains(&x) {
                    let wrong = (Vec3::from_array(*filter) - expected).abs().max_element();
                    assert!(wrong < 1e-3, "{run} {side}, texel {texel}: {filter:?}");
                    met += 1;
                }
            }
            assert_eq!(met, (20.0 / run) as usize);
        }
    }
}

/// `count` panes of the materials in turn, along axes and in each other's planes, around the lamps.
fn panes(seed: u64, materials: Vec<Material>, count: usize) -> Scene {
    let mut round = Round::new(seed);
    let kinds = materials.len();
    let mut scene = empty(materials);
    let mut places = Vec::new();
    for i in 0..count {
        let (center, axis) = (round.place(2.0), i % 3);
        let [x, y] =
            [(axis + 1) % 3, (axis + 2) % 3].map(|axis| Vec3::AXES[axis] * round.half(0.5, 1.5));
        places.push(round.on_box(center, x + y));
        scene.triangles.extend(pane(center, x, y, (i % kinds) as u32));
    }
    let size = round.one_of(&[32, 33]);
    scene.lights = round.lights(&places, size).into();
    scene
}

#[test]
fn panes_at_round_places() {
    let tinted = |transfer, w| Material { tint: TINT.with_w(w), ..material(transfer) };
    let solid = vec![
        tinted(Transfer::Filter, 0.5),
        material(Transfer::Opaque),
        tinted(Transfer::Stain, 0.5),
        Material { cutoff: 0.75, ..tinted(Transfer::Cutout, 0.5) },
        tinted(Transfer::Smoke, 1.0),
        tinted(Transfer::Dither, 1.0),
        tinted(Transfer::Gain, 1.0),
    ];
    let over = vec![tinted(Transfer::Over, 0.5), tinted(Transfer::Over, 1.0)];
    for (materials, count) in [(solid, 7), (over, 4)] {
        for seed in 0..3 {
            let scene = panes(seed, materials.clone(), count);
            // Panes in one plane: rounding decides the order of equal depths.
            let tolerance = Tolerance { undecided: 0.4, ..TOLERANCE };
            assert_agrees(&scene, tolerance);
            assert_agrees(&curved(scene, 8), tolerance);
        }
    }
}

/// Number of texels whose filter and nearest depth equal those of rays in 64 bits through the bodies of fog,
/// between solid triangles.
fn check_bodies(scene: &Scene, maps: &ViewMaps) -> usize {
    /// Distance to an edge, or between depths, below which rounding decides [share of a side, m].
    const MARGIN: f64 = 0.01;
    let mut compared = 0;
    for texel in 0..maps.filter.len() {
        let (start, way) = ray(maps, texel);
        let axis = maps.view.direction().as_dvec3();
        let far = f64::from(maps.view.far - maps.view.near) / way.dot(axis);
        let (mut faces, mut end, mut is_clear) = (Vec::new(), far, true);
        for triangle in &scene.triangles {
            let [a, b, c] = triangle.positions.map(Vec3::as_dvec3);
            let (ab, ac, s) = (b - a, c - a, start - a);
            let (p, q) = (way.cross(ac), s.cross(ab));
            let whole = ab.dot(p);
            if whole.abs() < EDGE_ON {
                continue;
            }
            let (u, v, t) = (s.dot(p) / whole, way.dot(q) / whole, ac.dot(q) / whole);
            let inside = u.min(v).min(1.0 - u - v);
            // A lamp on a face meets it at distance 0.
            is_clear &= inside.abs() > MARGIN || t < 0.0;
            if inside > 0.0 && triangle.material == FOG {
                faces.push((t, if whole < 0.0 { 1.0 } else { -1.0 }));
            } else if inside > 0.0 && t > 0.0 {
                end = end.min(t);
            }
        }
        if !is_clear {
            continue;
        }
        let metres: f64 = faces.iter().map(|(t, leaves)| leaves * t.clamp(0.0, end)).sum();
        let light = COLOR.powf(metres / DISTANCE);
        let found = DVec3::from_array(maps.filter[texel].map(f64::from));
        let what = format!("{} texel {texel}", maps.view.name);
        assert!((found - light).abs().max_element() < 1e-3, "{what}: {found} after {metres} m");
        let around: f64 = faces.iter().filter(|face| face.0 > 0.0).map(|face| face.1).sum();
        let entered = faces.iter().filter(|face| face.1 < 0.0 && face.0 > 0.0);
        let first = entered.map(|face| face.0).fold(f64::INFINITY, f64::min);
        let first = if around > 0.5 { 0.0 } else { first };
        if (first - end).abs() > MARGIN {
            let depth = if first < end { first / far } else { 1.0 };
            let nearest = f64::from(maps.nearest[texel]);
            assert!((nearest - depth).abs() < 1e-5, "{what}: {nearest} instead of {depth}");
        }
        compared += 1;
    }
    compared
}

fn assert_bodies(scene: &Scene) {
    for (maps, _) in all_maps(scene) {
        let texels: usize = maps.iter().map(|maps| maps.filter.len()).sum();
        let compared: usize = maps.iter().map(|maps| check_bodies(scene, maps)).sum();
        assert!(compared * 4 > texels * 3, "{compared} of {texels}");
    }
}

#[test]
fn a_body_as_high_as_the_lamp_is_whole() {
    let mut scene = lit_by(spot_down(Vec3::Y * 3.0, 120.0));
    scene.triangles = cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, -1.0), FOG);
    assert_bodies(&scene);
    scene.lights =
        vec![Light { size: Some(32), ..light(LightKind::Point { position: Vec3::Y * 3.0 }) }];
    assert_bodies(&scene);
}

#[test]
fn bodies_at_round_places() {
    for seed in 0..3 {
        let mut round = Round::new(seed);
        let mut scene = empty(materials());
        let mut places = Vec::new();
        for _ in 0..3 {
            let (center, half) = (round.place(1.5), Vec3::ONE * round.half(0.5, 1.0));
            places.push(round.on_box(center, half));
            scene.triangles.extend(cuboid(center - half, center + half, FOG));
        }
        scene.triangles.extend(pane(
            Vec3::NEG_Y * round.half(0.0, 2.0),
            Vec3::X * 2.0,
            Vec3::Z * 2.0,
            SOLID,
        ));
        let size = round.one_of(&[32, 33]);
        scene.lights = round.lights(&places, size).into();
        assert_bodies(&scene);
    }
}

/// Pictures of solid, shining casters equal those by rays in 64 bits; returns the number of pixels that are
/// not background.
pub(super) fn assert_seen(scene: &Scene) -> usize {
    let mut pictures = vec![reference_picture(scene)];
    let tiers = tiers(Tier::Native).into_iter();
    pictures.extend(tiers.map(|tier| crate::common::render(tier, scene).picture));
    let truth = seen(scene);
    for picture in pictures {
        for (pixel, truth) in truth.iter().enumerate() {
            let Ok(material) = truth else { continue };
            let expected = material.map_or(Vec3::ZERO, |id| scene.materials[id as usize].emission);
            let found = Vec3::from_array(picture.light[pixel]);
            assert!(
                (found - expected).abs().max_element() < 1e-3,
                "pixel {pixel}: {found} instead of {expected}"
            );
        }
    }
    let clear = truth.iter().filter(|truth| truth.is_ok()).count();
    assert!(clear * 4 > truth.len() * 3, "{clear} of {}", truth.len());
    truth.iter().filter(|truth| matches!(truth, Ok(Some(_)))).count()
}

/// A camera at a round place.
pub(super) fn camera(round: &mut Round) -> Camera {
    let (eye, direction) = (round.place(1.5), round.direction());
    Camera {
        eye,
        target: eye + direction,
        up: if direction.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y },
        fov_y: round.one_of(&[60.0_f32, 90.0]).to_radians(),
        size: round.one_of(&[UVec2::new(48, 32), UVec2::new(33, 33)]),
    }
}

/// A scene of solid materials that shine.
pub(super) fn shining(camera: Camera) -> Scene {
    let solid = |emission: Vec3| Material { emission, ..material(Transfer::Opaque) };
    let lights = [Vec3::splat(0.5), Vec3::new(0.5, 1.0, 0.5), Vec3::new(1.0, 0.5, 0.5)];
    Scene { camera, ..empty(lights.map(solid).into()) }
}

#[test]
fn a_floor_that_ends_below_the_eye_is_seen_whole() {
    let mut scene = shining(Camera {
        eye: Vec3::new(0.0, 1.0, 6.0),
        target: Vec3::Y,
        up: Vec3::Y,
        fov_y: 60_f32.to_radians(),
        size: UVec2::new(64, 48),
    });
    scene.triangles.extend(pane(Vec3::ZERO, Vec3::X * 6.0, Vec3::NEG_Z * 6.0, 0));
    scene.triangles.extend(wall(1));
    assert!(assert_seen(&scene) > 1500);
}

#[test]
fn pictures_from_round_places() {
    for seed in 0..4 {
        let mut round = Round::new(seed);
        let mut scene = shining(camera(&mut round));
        for material in 0..3 {
            let (center, half) = (round.place(2.0), Vec3::ONE * round.half(0.5, 1.0));
            scene.triangles.extend(cuboid(center - half, center + half, material));
        }
        assert_seen(&scene);
    }
}
