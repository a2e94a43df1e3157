//! Light is neither made nor lost: a white body cannot be seen in an even sky, and no caster sends out more
//! light than it takes.
use crate::common::{
    TIERS, Tier, reference_picture, render,
    scenes::{empty, light, material, particle, triangle},
    tiers,
};
use gobo::{
    glam::{Affine3A, IVec3, Quat, UVec2, UVec3, Vec2, Vec3, Vec4},
    model::{
        Air, Brick, Density, Environment, Gaussian, GaussianOpacity, Grid, Light, LightKind,
        Material, Receiver, Shape, Sky, Strand, StrandVertex, Transfer,
    },
    records::Picture,
};
use gobo_reference::shading::{Coat, Gloss, Lighting, Point, PointKind, Receiver as Reader};
use gobo_scene::Scene;
use std::{
    f32::consts::{FRAC_PI_2, PI, TAU},
    sync::Arc,
};

const SIZE: UVec2 = UVec2::new(64, 48);
const PER_METRE: f32 = 12.0;

fn place(slot: usize) -> Vec3 {
    Vec3::new(0.9 * ((slot % 5) as f32 - 2.0), 1.2 * (1.0 - (slot / 5) as f32), 0.0)
}

/// Light in the middle of a slot.
fn at(picture: &Picture, slot: usize) -> f32 {
    let pixel = SIZE.as_vec2() * 0.5 + PER_METRE * place(slot).truncate() * Vec2::new(1.0, -1.0);
    picture.light[pixel.y as usize * SIZE.x as usize + pixel.x as usize][1]
}

fn seen_from_afar(materials: Vec<Material>) -> Scene {
    let mut scene = empty(materials);
    (scene.camera.eye, scene.camera.size) = (Vec3::new(0.0, 0.0, 40.0), SIZE);
    scene.camera.fov_y = 2.0 * (0.5 * SIZE.y as f32 / PER_METRE / 40.0).atan();
    scene.shadow.receiver = Receiver::Curve;
    scene
}

fn cube(factor: f32, edge: f32, middle: Vec3, material: u32, anisotropy: f32) -> Grid {
    let size = UVec3::splat(8);
    let low = Affine3A::from_translation(middle - 0.5 * edge);
    Grid {
        world_from_index: low * Affine3A::from_scale(Vec3::splat(edge / 8.0)),
        bricks: vec![Brick::new(IVec3::ZERO, Density::Constant { size, density: 1.0 })],
        factor,
        material,
        anisotropy,
        ..Grid::default()
    }
}

/// Casters of all kinds, each with `albedo` in a slot of its own, in a sky of radiance 0.5.
fn furnace(albedo: f32) -> Scene {
    let tint = Vec3::splat(albedo).extend(1.0);
    let of = |shape: Shape, transfer: Transfer| Material { tint, shape, ..material(transfer) };
    let opaque = |roughness: f32, metallic: f32| Material {
        roughness,
        metallic,
        ..of(Shape::Disc, Transfer::Opaque)
    };
    let filter = |shape: Shape| of(shape, Transfer::Filter);
    let medium = GaussianOpacity::Medium { density: 4.0 };
    let mut scene = seen_from_afar(vec![
        filter(Shape::Disc),
        filter(Shape::Quad),
        filter(Shape::Puff),
        filter(Shape::Gaussian),
        Material { gaussian: medium, ..filter(Shape::Gaussian) },
        filter(Shape::Brick),
        filter(Shape::Capsule),
        opaque(0.05, 0.0),
        opaque(0.6, 0.0),
        opaque(0.5, 1.0),
        opaque(0.3, 0.0),
        Material { roughness: 0.4, ..of(Shape::Capsule, Transfer::Opaque) },
        Material { tint: tint.truncate().extend(0.6), ..filter(Shape::Disc) },
        Material { tint: tint.truncate().extend(0.6), ..of(Shape::Disc, Transfer::Smoke) },
        Material { transmission: 1.0, roughness: 0.1, reflectivity: 0.2, ..filter(Shape::Disc) },
    ]);
    for slot in 0..scene.materials.len() {
        let (center, material) = (place(slot), slot as u32);
        match slot {
            0..=2 | 7..=9 => {
                let color = Vec4::new(1.0, 1.0, 1.0, 0.6);
                scene
                    .particles
                    .push(gobo::model::Particle { material, ..particle(center, 0.35, color) });
            }
            3 | 4 => {
                let sigma = Vec3::new(0.1, 0.14, 0.12);
                let opacity = 0.8;
                scene.gaussians.push(Gaussian {
                    center,
                    sigma,
                    opacity,
                    material,
                    rotation: Quat::from_rotation_z(0.6),
                    ..Gaussian::default()
                });
            }
            5 => scene.grids.push(cube(3.0, 0.6, center, material, 0.5)),
            6 | 11 => {
                let aside = Vec3::new(0.3, 0.1, 0.1);
                let vertices = [center - aside, center + aside];
                let vertices = vertices.map(|end| StrandVertex::new(end, 0.15)).to_vec();
                scene.strands.push(Strand { vertices, material, id: material });
            }
            _ => {
                let corner = |x: f32, y: f32| center + 0.35 * Vec3::new(x, y, 0.8 * x - 0.4 * y);
                let corners =
                    [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
                for last in [2, 3] {
                    let positions = [corners[0], corners[last - 1], corners[last]];
                    let triangle = triangle(positions, material);
                    scene
                        .triangles
                        .push(gobo::model::Triangle { normals: [normal; 3], ..triangle });
                }
            }
        }
    }
    let sky = Vec3::splat(0.5);
    let sky = Sky { zenith: sky, horizon: sky, ground: sky, sun: None };
    scene.environment = Some(Arc::new(Environment::of_sky(&sky, 1.0)));
    scene
}

fn pictures(scene: &Scene) -> Vec<Picture> {
    let of_tiers = tiers(Tier::Native).into_iter().map(|tier| render(tier, scene).picture);
    [reference_picture(scene)].into_iter().chain(of_tiers).collect()
}

/// Rounding of half floats, and of roughness and polish in 12 bits, at 0.5.
const ROUNDED: f32 = 1e-3;

#[test]
fn white_casters_cannot_be_seen_in_an_even_sky() {
    for air in [None, Some(Air::default())] {
        let white = Scene { air, ..furnace(1.0) };
        for picture in pictures(&white) {
            for (i, light) in picture.light.iter().enumerate() {
                let apart = (Vec3::from(*light) - 0.5).abs().max_element();
                let pixel = (i as u32 % SIZE.x, i as u32 / SIZE.x);
                assert!(apart < ROUNDED, "{light:?} at {pixel:?}, air {}", white.air.is_some());
            }
        }
    }
    for picture in pictures(&furnace(0.0)) {
        for slot in 0..15 {
            assert!(at(&picture, slot) < 0.47, "slot {slot}: {}", at(&picture, slot));
        }
    }
}

/// Bodies without a face have ambient light, too.
#[test]
fn white_smoke_cannot_be_seen_in_ambient_light() {
    let mut white = Scene { environment: None, ..furnace(1.0) };
    (white.ambient, white.background) = (Vec3::splat(0.5), Vec3::splat(0.5));
    white.particles.retain(|particle| particle.material < 3);
    white.strands.retain(|strand| strand.material == 6);
    white.triangles.clear();
    for light in pictures(&white).iter().flat_map(|picture| &picture.light) {
        let apart = (Vec3::from(*light) - 0.5).abs().max_element();
        assert!(apart < ROUNDED, "{light:?}");
    }
}

/// A caster sends its share of a sun's light evenly to all sides; a grid sends it by its phase function, like
/// the air.
#[test]
fn thin_casters_scatter_what_they_take() {
    const TAKEN: f32 = 0.02;
    let of = |shape: Shape| Material { shape, ..material(Transfer::Filter) };
    let density = -(1.0 - TAKEN).ln() / (0.15 * TAU.sqrt());
    let medium = GaussianOpacity::Medium { density };
    let mut scene = seen_from_afar(vec![
        of(Shape::Disc),
        of(Shape::Quad),
        of(Shape::Puff),
        of(Shape::Gaussian),
        Material { gaussian: medium, ..of(Shape::Gaussian) },
        of(Shape::Brick),
        of(Shape::Brick),
    ]);
    for slot in 0..3 {
        let disc = particle(place(slot), 0.35, Vec4::new(1.0, 1.0, 1.0, TAKEN));
        scene.particles.push(gobo::model::Particle { material: slot as u32, ..disc });
    }
    for (slot, opacity) in [(3, TAKEN), (4, 1.0)] {
        let (center, sigma, material) = (place(slot), Vec3::splat(0.15), slot as u32);
        scene.gaussians.push(Gaussian { center, sigma, opacity, material, ..Gaussian::default() });
    }
    let factor = -(1.0 - TAKEN).ln() / 0.6;
    scene.grids = [(5, 0.0), (6, 0.6)]
        .map(|(slot, g)| cube(factor, 0.6, place(slot), slot as u32, g))
        .to_vec();
    let direction = Vec3::new(0.3, -0.4, -1.0).normalize();
    scene.lights = vec![light(LightKind::Directional { direction })];
    let phase = |g: f32| {
        let spread = 1.0 + g * g - 2.0 * g * direction.z;
        (1.0 - g * g) / (4.0 * PI * spread.powf(1.5))
    };
    let mut all = vec![reference_picture(&scene)];
    all.extend(TIERS.map(|tier| render(tier, &scene).picture));
    for picture in &all {
        for (slot, g) in [(0, 0.0), (1, 0.0), (2, 0.0), (3, 0.0), (4, 0.0), (5, 0.0), (6, 0.6)] {
            // A pixel's middle is beside the caster's, and a grid shades itself a little.
            let share = at(picture, slot) / (TAKEN * phase(g));
            assert!((0.97..1.005).contains(&share), "slot {slot}: {share}");
        }
    }
}

/// Light that a point sends to all sides from a sun at `angle` to its normal or axis Y, as a share of the
/// arriving light.
fn sent(kind: PointKind, angle: f32, roughness: f32, metallic: f32, coat: Coat) -> f32 {
    const STEPS: u32 = 240;
    let mut scene = empty(Vec::new());
    let toward = Vec3::new(angle.sin(), angle.cos(), 0.0);
    let sun = light(LightKind::Directional { direction: -toward });
    scene.lights = vec![Light { casts: false, ..sun }];
    let lighting = Lighting::new(&scene, &[], &[]);
    let is_strand = kind == PointKind::Strand;
    let step = PI / STEPS as f32;
    let mut sum = 0.0;
    // From the axis on, and around.
    for i in 0..STEPS / if is_strand { 1 } else { 2 } {
        let down = (i as f32 + 0.5) * step;
        for j in 0..STEPS {
            let (sin, cos) = ((j as f32 + 0.5) * step).sin_cos();
            let to_eye = Vec3::new(down.sin() * cos, down.cos(), down.sin() * sin);
            let point = Point {
                kind,
                position: Vec3::ZERO,
                pixel: UVec2::ZERO,
                face: Vec3::Y,
                normal: Vec3::Y,
                to_eye,
                reach: 0.0,
                receiver: Reader::AIR,
                albedo: Vec3::ONE,
                roughness,
                gloss: Gloss::SOLID,
                emission: Vec3::ZERO,
                metallic,
                far: Vec3::ZERO,
                coat,
            };
            let across = if is_strand { down.sin() } else { down.cos() };
            sum += lighting.light(&point, None).x * across * down.sin();
        }
    }
    // Both halves around.
    let arrives = if is_strand { angle.sin() } else { angle.cos() };
    2.0 * sum * step * step / arrives
}

#[test]
fn surfaces_and_strands_send_out_no_more_than_arrives() {
    for angle in [0.02, 0.5, 1.0, 1.4, FRAC_PI_2 - 0.02] {
        for roughness in [0.3, 0.5, 0.6, 0.8, 0.95, 1.0] {
            let dull = sent(PointKind::Solid, angle, roughness, 0.0, Coat::NONE);
            assert!((0.9..1.002).contains(&dull), "{angle}, {roughness}: {dull}");
            let metal = sent(PointKind::Solid, angle, roughness, 1.0, Coat::NONE);
            assert!(metal < 1.002, "{angle}, {roughness}: metal {metal}");
            let strand = sent(PointKind::Strand, angle, roughness, 0.0, Coat::NONE);
            assert!((0.96..1.002).contains(&strand), "{angle}, {roughness}: strand {strand}");
            let coat = Coat { share: 1.0, roughness, normal: Vec3::Y };
            let coated = sent(PointKind::Solid, angle, 0.6, 1.0, coat);
            assert!(coated < 1.002, "{angle}, {roughness}: coated {coated}");
        }
    }
}

/// Over the directions of a cube's faces and corners (Lebedev 1976, of degree 5).
#[test]
fn grids_send_out_no_more_than_they_take() {
    const AWAY: f32 = 50.0;
    const WIDTH: f32 = 2.0;
    let directions = (0..27).filter_map(|i| {
        let way = IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
        match way.abs().element_sum() {
            1 => Some((way.as_vec3(), 1.0 / 15.0)),
            3 => Some((way.as_vec3().normalize(), 3.0 / 40.0)),
            _ => None,
        }
    });
    let directions: Vec<_> = directions.collect();
    for (depth, least) in [(0.02, 0.97), (0.5, 0.8), (4.0, 0.3)] {
        let mut sum = 0.0;
        for &(way, weight) in &directions {
            let brick = Material { shape: Shape::Brick, ..material(Transfer::Filter) };
            let mut scene = seen_from_afar(vec![brick]);
            scene.grids = vec![cube(depth, 1.0, Vec3::ZERO, 0, 0.0)];
            scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
            scene.camera.eye = AWAY * way;
            scene.camera.up = if way.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y };
            scene.camera.size = UVec2::splat(24);
            scene.camera.fov_y = 2.0 * (0.5 * WIDTH / AWAY).atan();
            let picture = render(Tier::Native, &scene).picture;
            let light: f32 = picture.light.iter().map(|light| light[1]).sum();
            sum += weight * light * (WIDTH / 24.0).powi(2);
        }
        let share = 4.0 * PI * sum / (1.0 - (-depth).exp());
        println!("optical depth {depth}: {share}");
        assert!((least..1.01).contains(&share), "optical depth {depth}: {share}");
    }
}
