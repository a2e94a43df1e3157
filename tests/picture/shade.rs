//! The lit picture: kernels against the CPU reference, and expected contents of pictures.
use crate::common::{
    TIERS, reference_picture, render,
    scenes::{Chance, empty, light, material, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{UVec2, Vec2, Vec3, Vec4},
    gpu::Tier,
    model::{
        Light, LightKind, Material, Particle, Profile, Receiver, ShadowSettings, Shape, Texture,
        Transfer, Triangle,
    },
    records::Picture,
};
use gobo_scene::Scene;

const STONE: u32 = 0;
const GLASS: u32 = 1;
const GEL: u32 = 2;
const SMOKE: u32 = 3;
const FIRE: u32 = 4;
const BALL: u32 = 5;
const PUFF: u32 = 6;

fn materials() -> Vec<Material> {
    let tinted =
        |transfer, tint: [f32; 4]| Material { tint: Vec4::from_array(tint), ..material(transfer) };
    vec![
        tinted(Transfer::Opaque, [0.7, 0.68, 0.6, 1.0]),
        Material {
            transmission: 1.0,
            roughness: 0.2,
            ..tinted(Transfer::Filter, [0.9, 0.2, 0.1, 1.0])
        },
        tinted(Transfer::Stain, [0.2, 0.9, 0.4, 0.6]),
        tinted(Transfer::Smoke, [0.6, 0.6, 0.9, 0.3]),
        Material { emission: Vec3::new(0.6, 0.2, 0.0), ..tinted(Transfer::None, [0.3; 4]) },
        Material { profile: Profile::Flat, ..tinted(Transfer::Opaque, [0.2, 0.3, 0.9, 1.0]) },
        Material { shape: Shape::Puff, ..tinted(Transfer::Filter, [0.9, 0.8, 0.3, 0.5]) },
    ]
}

fn square(middle: Vec3, x: Vec3, y: Vec3, material: u32) -> [Triangle; 2] {
    let corner = |u: f32, v: f32| middle + x * u + y * v;
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    let normals = [x.cross(y).normalize(); 3];
    [[a, b, c], [a, c, d]].map(|corners| Triangle { normals, ..triangle(corners, material) })
}

fn bright(kind: LightKind, intensity: f32) -> Light {
    Light { intensity, ..light(kind) }
}

/// A floor under one light of each kind, two panes, and particles of every sort.
fn stage() -> Scene {
    let mut scene = empty(materials());
    scene.camera.size = UVec2::new(150, 101); // no whole number of tiles
    scene.ambient = Vec3::new(0.1, 0.12, 0.15);
    scene.background = Vec3::new(0.3, 0.4, 0.6);
    scene.shadow.size = 128;
    let spot = Vec3::new(2.0, 3.5, 1.0);
    scene.lights = vec![
        bright(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }, 2.0),
        bright(LightKind::Spot { position: spot, direction: -spot.normalize(), angle: 0.8 }, 20.0),
        Light {
            far: Some(5.0),
            ..bright(LightKind::Point { position: Vec3::new(-1.1, 1.2, 0.4) }, 4.0)
        },
    ];
    let down = Vec3::new(0.0, -1.0, 0.0);
    scene.triangles.extend(square(down, Vec3::X * 4.0, Vec3::NEG_Z * 4.0, STONE));
    scene.triangles.extend(square(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 0.8, Vec3::Y, GLASS));
    scene.triangles.extend(square(Vec3::new(1.2, 0.0, 0.5), Vec3::Z * 1.5, Vec3::Y, GEL));
    let mut chance = Chance::new(7);
    for (i, mut disc) in random_discs(400, 11).into_iter().enumerate() {
        disc.material = [SMOKE, SMOKE, SMOKE, FIRE, PUFF, BALL][chance.below(6)];
        disc.radius = if disc.material == BALL { 0.08 } else { 0.05 + 0.2 * chance.unit() };
        disc.center *= 0.9;
        disc.id = i as u32;
        scene.particles.push(disc);
    }
    scene
}

/// Mean difference of the channels, and the share of them that differ by more than 4 of 255.
fn apart(a: &Picture, b: &Picture) -> (f64, f64) {
    assert_eq!(a.size, b.size);
    assert_eq!(a.rgb.len(), (a.size.x * a.size.y) as usize);
    let channels = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
    let differences: Vec<u8> = channels.map(|(a, b)| a.abs_diff(*b)).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().map(|&d| f64::from(d)).sum::<f64>() / count;
    (mean, differences.iter().filter(|&&d| d > 4).count() as f64 / count)
}

fn assert_matches_reference(scene: &Scene) {
    let expected = reference_picture(scene);
    for tier in TIERS {
        let (mean, off) = apart(&render(tier, scene).picture, &expected);
        assert!(mean < 1.0 && off < 1e-3, "{tier:?}: mean {mean}, {off} of the channels off");
    }
}

#[test]
fn gpu_matches_reference() {
    assert_matches_reference(&stage());
}

#[test]
fn gpu_matches_reference_of_nothing() {
    let mut scene = stage();
    scene.particles.clear();
    scene.triangles.clear();
    assert_matches_reference(&scene);
    scene.lights.clear();
    assert_matches_reference(&scene);
}

#[test]
fn a_missing_pane_is_noticed() {
    let scene = stage();
    let mut without = scene.clone();
    without.triangles.retain(|t| t.material != GLASS);
    let (mean, off) = apart(&render(Tier::Native, &without).picture, &reference_picture(&scene));
    assert!(mean >= 1.0 && off >= 1e-3, "mean {mean}, {off} of the channels off");
}

/// A tile with more pairs than a segment: the nearest opaque caster, and all of the smoke.
#[test]
fn long_tiles_are_whole() {
    let mut scene = empty(materials());
    scene.camera.size = UVec2::new(48, 48);
    scene.camera.eye = Vec3::new(0.0, 0.0, 6.0);
    scene.ambient = Vec3::ONE;
    let mut chance = Chance::new(3);
    let faint = |center| Particle {
        material: SMOKE,
        ..particle(center, 0.2, Vec4::new(1.0, 0.5, 0.2, 0.002))
    };
    for _ in 0..20_000 {
        scene.particles.push(faint(chance.vec3(-0.2, 0.2)));
    }
    let solid = |center| Particle { material: BALL, ..particle(center, 0.02, Vec4::ONE) };
    for _ in 0..9_000 {
        scene.particles.push(solid(chance.vec3(-0.3, 0.3) - Vec3::Z));
    }
    assert_matches_reference(&scene);
}

/// More discs than a segment has pairs, too faint to be visible.
fn unseen_discs(center: Vec3, spread: f32) -> Vec<Particle> {
    let mut chance = Chance::new(5);
    let disc = |_| {
        let center = center + chance.vec3(-spread, spread);
        Particle { material: SMOKE, ..particle(center, 0.3, Vec3::ONE.extend(1e-7)) }
    };
    (0..5000).map(disc).collect()
}

/// A lump of amber: a box from `low` to `high` whose faces point outwards.
fn lump(low: Vec3, high: Vec3, material: u32) -> Vec<Triangle> {
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let side = |axis: usize, sign: f32| {
        let [mut out, mut x, mut y] = [Vec3::ZERO; 3];
        out[axis] = half[axis] * sign;
        x[(axis + 1) % 3] = half[(axis + 1) % 3];
        y[(axis + 2) % 3] = half[(axis + 2) % 3] * sign;
        square(middle + out, x, y, material)
    };
    (0..3).flat_map(|axis| [side(axis, -1.0), side(axis, 1.0)]).flatten().collect()
}

/// Largest change of a channel by the rounding of faint discs, in steps of 8 bits.
const UNSEEN: u8 = 1;

fn assert_same_beside_unseen_discs(scene: &Scene, center: Vec3) {
    let mut crowded = scene.clone();
    crowded.particles.extend(unseen_discs(center, 0.1));
    let expected = reference_picture(scene);
    let mut pictures =
        vec![("cpu".to_owned(), reference_picture(&crowded), reference_picture(scene))];
    for tier in tiers(Tier::Core) {
        let [crowded, plain] = [&crowded, scene].map(|scene| render(tier, scene).picture);
        pictures.push((format!("{tier:?}"), crowded, plain));
    }
    let background = expected.rgb[0];
    assert!(expected.rgb.iter().any(|rgb| rgb[2].abs_diff(background[2]) > 20), "nothing is seen");
    for (name, crowded, plain) in pictures {
        let channels = crowded.rgb.iter().flatten().zip(plain.rgb.iter().flatten());
        let most = channels.map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(UNSEEN), "{name}: {most:?} of 255");
    }
}

/// A volume that a ray has entered continues, however many pairs come before the ray leaves it.
#[test]
fn a_volume_reaches_across_segments() {
    let mut scene = empty(materials());
    let amber = Material {
        attenuation_color: Vec3::new(0.9, 0.5, 0.1),
        attenuation_distance: 0.5,
        transmission: 1.0,
        ..scene.materials[GLASS as usize].clone()
    };
    scene.materials.push(Material { tint: Vec4::ONE, ..amber });
    scene.camera.size = UVec2::new(48, 48);
    scene.camera.eye = Vec3::new(0.3, 0.2, 6.0);
    scene.background = Vec3::ONE;
    scene.triangles = lump(Vec3::splat(-1.0), Vec3::splat(1.0), PUFF + 1);
    assert_same_beside_unseen_discs(&scene, Vec3::ZERO);
}

/// A pane that reaches far back waits for nearer casters, however many pairs come between.
#[test]
fn a_pane_waits_across_segments() {
    let mut scene = empty(materials());
    scene.camera.size = UVec2::new(48, 48);
    scene.camera.eye = Vec3::new(0.0, 0.0, 6.0);
    scene.ambient = Vec3::ONE;
    scene.triangles.extend(square(Vec3::ZERO, Vec3::new(1.0, 0.0, 2.0), Vec3::Y, GLASS));
    for _ in 0..40 {
        let smoke = particle(Vec3::new(0.0, 0.0, 0.5), 0.4, Vec4::new(0.0, 0.0, 1.0, 1.0));
        scene.particles.push(Particle { material: SMOKE, ..smoke });
    }
    assert_same_beside_unseen_discs(&scene, Vec3::new(0.0, 0.0, 1.0));
}

/// The picture does not depend on the pair budget, and reports if it was too small.
#[test]
fn nothing_is_lost_past_the_pair_budget() {
    let mut scene = stage();
    scene.lights.iter_mut().for_each(|light| light.casts = false);
    for tier in tiers(Tier::Core) {
        scene.shadow.pair_budget = ShadowSettings::default().pair_budget;
        let whole = render(tier, &scene);
        assert_eq!(whole.counters.overflowed, 0, "{tier:?}");
        for budget in [200, 7] {
            scene.shadow.pair_budget = budget;
            let frame = render(tier, &scene);
            assert!(frame.counters.overflowed > 100, "{tier:?}: {}", frame.counters.overflowed);
            assert!(frame.picture.rgb == whole.picture.rgb, "{tier:?}, {budget} pairs");
        }
    }
}

/// Nor does the picture depend on the pair budget of the shadows, by curves or by the nearest depth.
#[test]
fn no_shadow_is_lost_past_the_pair_budget() {
    let mut scene = stage();
    for receiver in [Receiver::Curve, Receiver::Nearest] {
        scene.shadow.receiver = receiver;
        for tier in tiers(Tier::Core) {
            scene.shadow.pair_budget = ShadowSettings::default().pair_budget;
            let whole = render(tier, &scene);
            for budget in [200, 7] {
                scene.shadow.pair_budget = budget;
                let frame = render(tier, &scene);
                assert!(frame.counters.overflowed > 100, "{tier:?}: {}", frame.counters.overflowed);
                assert!(frame.picture.rgb == whole.picture.rgb, "{receiver:?}, {tier:?}, {budget}");
            }
        }
    }
}

fn middle(picture: &Picture) -> [u8; 3] {
    picture.rgb[(picture.size.y / 2 * picture.size.x + picture.size.x / 2) as usize]
}

/// A large pane's nearest point is closer to the eye than smoke in front of its centre.
#[test]
fn smoke_before_a_slanted_pane_keeps_its_colour() {
    let mut scene = empty(materials());
    scene.camera.eye = Vec3::new(0.0, 0.0, 6.0);
    scene.ambient = Vec3::ONE;
    let slanted = Vec3::new(1.0, 0.0, 2.0);
    scene.triangles.extend(square(Vec3::ZERO, slanted, Vec3::Y, GLASS));
    for _ in 0..40 {
        let smoke = particle(Vec3::new(0.0, 0.0, 0.5), 0.4, Vec4::new(0.0, 0.0, 1.0, 1.0));
        scene.particles.push(Particle { material: SMOKE, ..smoke });
    }
    for picture in [reference_picture(&scene), render(Tier::Core, &scene).picture] {
        let [red, _, blue] = middle(&picture);
        assert!(blue > 100 && red < 60, "{:?}", middle(&picture));
    }
}

/// An image that is black on the left and white on the right.
#[test]
fn emission_is_that_of_its_texture() {
    for transfer in [Transfer::Opaque, Transfer::Filter] {
        let emission = Vec3::new(2.0, 1.0, 0.5);
        let shining = Material { emission, emissive_texture: Some(0), ..material(transfer) };
        let mut scene = empty(vec![Material { tint: Vec4::W, ..shining }]);
        scene.camera.eye = Vec3::new(0.0, 0.0, 6.0);
        let rgba = [[0, 0, 0, 255], [255; 4]].concat();
        scene.textures.push(Texture { name: String::new(), width: 2, height: 1, rgba });
        let mut faces = square(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0, 0);
        for face in &mut faces {
            face.uvs = face.positions.map(|p| Vec2::new(0.5 + p.x / 2.0, 0.5));
        }
        scene.triangles.extend(faces);
        let pictures = TIERS.map(|tier| render(tier, &scene).picture);
        for picture in pictures.into_iter().chain([reference_picture(&scene)]) {
            let row = 32 * picture.size.x as usize;
            // u = 0.25 is 0.5 m left of the middle, of 64 pixels for 5.07 m.
            let [left, right] = [25, 38].map(|x| Vec3::from(picture.light[row + x]));
            assert!(left.max_element() < 0.05 * emission.max_element(), "{transfer:?} {left}");
            assert!((right / emission - 1.0).abs().max_element() < 0.05, "{transfer:?} {right}");
        }
    }
}

#[test]
fn row_0_is_the_top() {
    let mut scene = stage();
    scene.particles.clear();
    scene.triangles.truncate(2);
    scene.camera.eye = Vec3::new(0.0, 1.0, 6.0);
    scene.camera.target = Vec3::Y;
    for picture in [reference_picture(&scene), render(Tier::Core, &scene).picture] {
        let column = picture.size.x as usize / 2;
        let [sky, floor] = [picture.rgb[column], picture.rgb[picture.rgb.len() - column]];
        assert!(sky[2] > sky[0] && floor[0] >= floor[2], "{sky:?} above {floor:?}");
    }
}
