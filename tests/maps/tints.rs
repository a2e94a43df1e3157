//! Casters that tint a receiver: those in front of it, none, or all except its own object's.
use crate::common::{
    TIERS, Tier,
    scenes::{Chance, empty, light, material, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{UVec2, Vec3, Vec4},
    model::{Camera, LightKind, Material, Particle, Profile, Receives, Transfer, Triangle},
    records::{NO_OWNER, owner_tag},
    view::shadow_views,
};
use gobo_reference::{render_maps, render_picture};
use gobo_scene::Scene;

const UPPER: u32 = 7;
/// With the same lower half as `UPPER`.
const LOWER: u32 = 7 | 5 << 16;

/// Form of a receiver.
#[derive(Clone, Copy, Debug)]
enum Form {
    Pane,
    Ball,
    Floor,
}

/// An invisible caster above a receiver without shadow, seen from above.
fn stack(form: Form, receives: Receives, id: u32, upper: Transfer) -> Scene {
    let tint = Vec4::new(0.8, 0.8, 0.8, 1.0);
    let transfer = if let Form::Floor = form { Transfer::Opaque } else { Transfer::Over };
    let profile = Profile::Flat;
    let own = Material { tint, receives, casts: false, profile, ..material(transfer) };
    let tint = Vec4::new(1.0, 0.1, 0.0, 1.0);
    let above = Material { tint, visible: false, ..material(upper) };
    let mut scene = empty(vec![own, above]);
    scene.lights.push(light(LightKind::Directional { direction: Vec3::NEG_Y }));
    scene.lights[0].intensity = 2.0;
    scene.shadow.size = 32;
    let (eye, up) = (Vec3::new(0.0, 5.0, 0.1), Vec3::Z);
    scene.camera = Camera { eye, up, target: Vec3::ZERO, fov_y: 0.5, size: UVec2::splat(16) };
    let square = |y: f32, half: f32, material: u32, id: u32| {
        let corner = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
        let (a, b, c, d) =
            (corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0));
        [[a, b, c], [a, c, d]].map(|p| Triangle {
            id,
            normals: [Vec3::Y; 3],
            ..triangle(p, material)
        })
    };
    scene.triangles.extend(square(1.0, 3.0, 1, UPPER));
    match form {
        Form::Pane | Form::Floor => scene.triangles.extend(square(-1.0, 2.5, 0, id)),
        Form::Ball => {
            scene.particles.push(Particle { id, ..particle(Vec3::NEG_Y, 0.9, Vec4::ONE) });
        }
    }
    scene
}

/// Central pixel by each renderer.
fn middles(scene: &Scene) -> Vec<[u8; 3]> {
    let views = shadow_views(scene);
    let (maps, _) = render_maps(scene, &views);
    let mut all = vec![render_picture(scene, &views, &maps, &shadow_views)];
    all.extend(
        tiers(Tier::Native).into_iter().map(|tier| crate::common::render(tier, scene).picture),
    );
    all.iter().map(|picture| picture.rgb[8 * 16 + 8]).collect()
}

#[track_caller]
fn assert_same(found: &[[u8; 3]], expected: &[[u8; 3]]) {
    for (found, expected) in found.iter().zip(expected) {
        let apart = (0..3).map(|c| found[c].abs_diff(expected[c])).max();
        assert!(apart <= Some(1), "{found:?} instead of {expected:?}");
    }
}

#[test]
fn receivers_choose_who_tints_them() {
    use Receives::{Curve, Nearest, Opaque, Others};
    for form in [Form::Pane, Form::Ball, Form::Floor] {
        let under = |receives, id, upper| middles(&stack(form, receives, id, upper));
        let filter = Transfer::Filter;
        let tinted = under(Curve, LOWER, filter);
        let lit = under(Curve, LOWER, Transfer::None);
        let dark = under(Curve, LOWER, Transfer::Opaque);
        for ((tinted, lit), dark) in tinted.iter().zip(&lit).zip(&dark) {
            assert!(tinted[0] + 10 > lit[0] && tinted[1] + 40 < lit[1], "{tinted:?} {lit:?}");
            assert!(dark[0] + 40 < lit[0], "{dark:?}");
        }
        assert_same(&under(Nearest, UPPER, filter), &tinted);
        assert_same(&under(Opaque, LOWER, filter), &lit);
        assert_same(&under(Others, UPPER, filter), &lit);
        assert_same(&under(Others, LOWER, filter), &tinted);
        // Opaque casters shade all.
        assert_same(&under(Opaque, LOWER, Transfer::Opaque), &dark);
        assert_same(&under(Others, UPPER, Transfer::Opaque), &dark);
    }
}

/// Triangles and discs; in `count` times as many segments.
fn crowd(count: usize) -> Scene {
    let glass = material(Transfer::Filter);
    let others = Material { receives: Receives::Others, ..glass.clone() };
    let mut scene = empty(vec![glass, others]);
    scene.lights.push(light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3) }));
    scene.particles = random_discs(count, 5);
    for particle in &mut scene.particles {
        particle.color.w = 0.05;
        particle.radius = particle.radius.max(0.1);
    }
    let mut chance = Chance::new(9);
    for i in 0..12 {
        let center = chance.vec3(-1.5, 1.5);
        let positions = [0; 3].map(|_| center + chance.vec3(-0.9, 0.9));
        scene.materials[0].tint.w = 0.5;
        scene.triangles.push(Triangle { id: 100_000 + i, ..triangle(positions, 0) });
    }
    scene
}

#[test]
fn maps_say_whose_the_nearest_depth_is() {
    for (count, size) in [(300, 64), (3000, 16)] {
        let mut scene = crowd(count);
        scene.shadow.size = size;
        let (cpu, counters) = render_maps(&scene, &shadow_views(&scene));
        assert_eq!(counters.segments > 1 && size == 16, count == 3000);
        let cpu = &cpu[0];
        let tags: Vec<u16> = (0..count as u32).chain(100_000..100_012).map(owner_tag).collect();
        for (tag, depth) in cpu.owner.iter().zip(&cpu.nearest) {
            assert_eq!(*tag == NO_OWNER, *depth == 1.0);
            assert!(*tag == NO_OWNER || tags.contains(tag));
        }
        for tier in tiers(Tier::Native) {
            let frame = crate::common::map_frame(tier, &scene);
            let maps = &frame.maps[0];
            let other = maps.owner.iter().zip(&cpu.owner).filter(|(a, b)| a != b).count();
            // Rounding decides at edges, and which of two equal depths is the nearest.
            assert!(other * 200 <= cpu.owner.len(), "{tier:?}: {other}");
            let depths =
                maps.nearest.iter().zip(&cpu.nearest).zip(maps.owner.iter().zip(&cpu.owner));
            for ((a, b), (own, other)) in depths {
                assert!((a - b).abs() < 1e-5 || own != other, "{a} {b}");
            }
        }
    }
    let mut plain = crowd(100);
    plain.materials.pop();
    assert!(render_maps(&plain, &shadow_views(&plain)).0[0].owner.is_empty());
    assert!(crate::common::map_frame(TIERS[0], &plain).maps[0].owner.is_empty());
}
