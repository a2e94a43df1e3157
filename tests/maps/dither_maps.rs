//! Dithered maps and pictures: kernels against the CPU reference, and properties of both.
use crate::common::{
    TIERS, Tier, gpu, map_frame, render,
    rounding::{DITHERED, on, rounds_as_the_cpu},
    scenes::{Chance, empty, flat_view, light, material, pane, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Mat4, Vec3, Vec4},
    model::{LightKind, Material, Pattern, Profile, Shape, Texture, Transfer, View},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference as reference;
use gobo_scene::Scene;

fn dithered(pattern: Pattern, scale: u32) -> Material {
    Material { pattern, pattern_scale: scale, ..material(Transfer::Dither) }
}

/// Discs, textured quads, puffs and triangles under a directional light and a spot.
fn mixture(pattern: Pattern, scale: u32) -> Scene {
    let like =
        |shape, profile, texture| Material { shape, profile, texture, ..dithered(pattern, scale) };
    let mut scene = empty(vec![
        like(Shape::Disc, Profile::Soft, None),
        like(Shape::Quad, Profile::Flat, Some(0)),
        like(Shape::Puff, Profile::Soft, None),
        Material { tint: Vec4::new(1.0, 1.0, 1.0, 0.4), ..dithered(pattern, scale) },
        Material { reflectivity: 0.3, ..like(Shape::Disc, Profile::Flat, None) },
        Material { cutoff: 0.4, ..material(Transfer::Cutout) },
    ]);
    let ramp = (0..16u8).flat_map(|i| [255, 255, 255, i * 17]).collect();
    scene.textures = vec![Texture { name: "ramp".into(), width: 4, height: 4, rgba: ramp }];
    let position = Vec3::new(3.0, 4.0, 2.5);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }),
    ];
    scene.shadow.size = 128;
    scene.particles = random_discs(400, 11);
    let mut chance = Chance::new(4);
    for particle in &mut scene.particles {
        particle.material = [0, 1, 2, 4, 5][chance.below(5)];
        particle.color.w = chance.unit();
    }
    for id in 0..6 {
        let mut face = triangle([0; 3].map(|_| chance.vec3(-2.0, 2.0)), 3);
        face.id = id;
        scene.triangles.push(face);
    }
    scene
}

fn cpu(scene: &Scene) -> Vec<ViewMaps> {
    reference::render_maps(scene, &shadow_views(scene)).0
}

fn opaques(maps: &[ViewMaps]) -> Vec<f32> {
    maps.iter().flat_map(|view| view.opaque.iter().copied()).collect()
}

fn share_apart(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 2e-6).count();
    apart as f64 / a.len() as f64
}

#[test]
fn gpu_matches_reference() {
    for pattern in Pattern::ALL {
        let scene = mixture(pattern, if pattern == Pattern::Bayer4 { 3 } else { 1 });
        let expected = opaques(&cpu(&scene));
        let open = expected.iter().filter(|z| **z == 1.0).count() as f64 / expected.len() as f64;
        assert!((0.2..0.8).contains(&open), "{open}");
        for tier in TIERS {
            let apart = share_apart(&opaques(&map_frame(tier, &scene).maps), &expected);
            assert!(apart <= on(&gpu(tier), DITHERED), "{pattern:?} {tier:?}: {apart}");
        }
    }
    let other = opaques(&cpu(&mixture(Pattern::Bayer8, 1)));
    assert!(share_apart(&opaques(&cpu(&mixture(Pattern::Bayer4, 1))), &other) > DITHERED[1]);
}

/// Panes across the light's axis: no edge is grazed and no depth is rounded.
#[test]
fn gpu_matches_reference_bit_for_bit() {
    for pattern in Pattern::ALL {
        let mut scene =
            empty(vec![Material { tint: Vec4::new(1.0, 1.0, 1.0, 0.37), ..dithered(pattern, 1) }]);
        scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
        for id in 0..3 {
            scene.triangles.extend(pane(0.2 + 0.1 * id as f32, 1.5, 0));
        }
        for (i, face) in scene.triangles.iter_mut().enumerate() {
            face.id = i as u32 / 2;
        }
        let expected = opaques(&cpu(&scene));
        for tier in TIERS {
            let maps = opaques(&map_frame(tier, &scene).maps);
            let bits = |maps: &[f32]| maps.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
            let is_same = if rounds_as_the_cpu(&gpu(tier)) {
                bits(&maps) == bits(&expected)
            } else {
                share_apart(&maps, &expected) <= DITHERED[1]
            };
            assert!(is_same, "{pattern:?} {tier:?}");
        }
    }
}

#[test]
fn the_camera_changes_no_texel() {
    for pattern in Pattern::ALL {
        let scene = mixture(pattern, 1);
        let mut moved = scene.clone();
        moved.camera.eye += Vec3::new(0.3, -0.1, 0.7);
        moved.camera.fov_y *= 0.5;
        let (a, b) = (map_frame(TIERS[1], &scene).maps, map_frame(TIERS[1], &moved).maps);
        assert!(opaques(&a) == opaques(&b), "{pattern:?}");
    }
}

/// One disc, seen from above through 64x64 texels of 1/8 m.
fn disc_map(pattern: Pattern, center: Vec3, view: &View) -> Vec<f32> {
    let flat = Material { profile: Profile::Flat, ..dithered(pattern, 1) };
    let mut scene = empty(vec![flat]);
    scene.particles = vec![particle(center, 3.0, Vec4::new(1.0, 1.0, 1.0, 0.5))];
    reference::render_maps(&scene, std::slice::from_ref(view)).0.remove(0).opaque
}

#[test]
fn the_pattern_lies_still_when_the_view_snaps() {
    for pattern in Pattern::ALL {
        let view = flat_view(64, 8.0);
        let center = Vec3::new(0.3, -0.2, -5.0);
        let snapped = View {
            view_from_world: Mat4::from_translation(Vec3::new(3.0 / 8.0, -2.0 / 8.0, 0.0)),
            ..view.clone()
        };
        let (a, b) = (disc_map(pattern, center, &view), disc_map(pattern, center, &snapped));
        for y in 0..62 {
            for x in 0..61 {
                let same = a[y * 64 + x] == b[(y + 2) * 64 + x + 3];
                assert!(same || pattern == Pattern::Hashed, "{pattern:?} {x} {y}");
            }
        }
    }
}

/// Largest share of its texels that change when a caster of 50% moves by a fraction of a texel: `hashed`
/// moves with it, so a texel changes only when a cell's border crosses it.
#[test]
fn a_moving_hashed_caster_changes_few_texels() {
    let view = flat_view(64, 8.0);
    let center = Vec3::new(0.01, 0.02, -5.0);
    let still = disc_map(Pattern::Hashed, center, &view);
    let inside = std::f32::consts::PI * 24.0 * 24.0;
    for (fraction, most) in [(1.0 / 16.0, 0.06), (1.0 / 8.0, 0.1), (1.0 / 4.0, 0.18)] {
        let moved = disc_map(Pattern::Hashed, center + Vec3::X * (fraction / 8.0), &view);
        let changed = still.iter().zip(&moved).filter(|(a, b)| a != b).count() as f32 / inside;
        assert!(changed <= most && changed > 0.0, "{fraction}: {changed}");
    }
}

/// Shadows are dithered, pictures are not: glass stays smooth and keeps its highlights.
#[test]
fn the_picture_blends_dithered_glass() {
    let with = |transfer| {
        let glass = Material {
            transfer,
            tint: Vec4::new(0.3, 0.8, 0.5, 0.6),
            transmission: 1.0,
            roughness: 0.1,
            ..Material::default()
        };
        let mut scene = empty(vec![glass]);
        scene.background = Vec3::new(0.5, 0.6, 0.7);
        scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
        scene.lights[0].casts = false;
        scene.triangles = pane(0.1, 1.5, 0).to_vec();
        scene
    };
    let (dithered, filtering) = (with(Transfer::Dither), with(Transfer::Filter));
    for tier in tiers(Tier::Native) {
        let picture = render(tier, &dithered).picture;
        assert!(picture.rgb == render(tier, &filtering).picture.rgb);
        assert!(picture.rgb != render(tier, &empty(Vec::new())).picture.rgb);
    }
    let on_cpu = |scene: &Scene| reference::render_picture(scene, &[], &[], &shadow_views).rgb;
    assert!(on_cpu(&dithered) == on_cpu(&filtering));
}

#[test]
fn pictures_of_the_scenes_match_the_reference() {
    for name in ["cutout", "reflectivity", "panes", "patterns"] {
        let set = [("camera.size", "[160, 96]"), ("shadow.size", "256"), ("shadow.soften", "true")]
            .map(|(key, value)| (key.to_owned(), value.to_owned()));
        let path = format!("{}/data/{name}.toml", crate::common::root().display());
        let mut scene = gobo_scene::load_with(path.as_ref(), &set).unwrap();
        scene.set_time(0.5);
        let views = shadow_views(&scene);
        let (maps, _) = reference::render_maps(&scene, &views);
        let expected = reference::render_picture(&scene, &views, &maps, &shadow_views).rgb;
        let actual = render(TIERS[1], &scene).picture.rgb;
        let apart = expected.iter().flatten().zip(actual.iter().flatten());
        let apart = apart.filter(|(a, b)| a.abs_diff(**b) > 4).count();
        assert!(apart as f64 <= 3e-3 * (3 * expected.len()) as f64, "{name}: {apart} channels");
    }
}

/// Tiles and the overflow path, in any order of the casters.
#[test]
fn every_path_draws_the_same() {
    let scene = mixture(Pattern::Blue, 1);
    let mut shuffled = scene.clone();
    Chance::new(8).shuffle(&mut shuffled.particles);
    let mut overflowing = scene.clone();
    overflowing.shadow.pair_budget = 300;
    for tier in tiers(Tier::Native) {
        let whole = opaques(&map_frame(tier, &scene).maps);
        assert!(opaques(&map_frame(tier, &shuffled).maps) == whole, "{tier:?}");
        let frame = map_frame(tier, &overflowing);
        assert!(frame.counters.overflowed > 0);
        assert!(opaques(&frame.maps) == whole, "{tier:?}");
    }
}

/// Long lists in one tile: several segments of layers so thin that no tile is settled. llvmpipe stops all
/// loops of an invocation after 65,535 iterations.
#[test]
#[ignore = "many casters: make test-all"]
fn segments_draw_what_the_reference_does() {
    let mut stack =
        empty(vec![Material { profile: Profile::Flat, ..dithered(Pattern::Bayer8, 1) }]);
    stack.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    stack.particles = (0..6_000)
        .map(|id| {
            let center = Vec3::new(0.0, 0.0, -(id as f32) * 1e-4);
            // Subnormal half floats, below 6e-5, differ between devices.
            let alpha = if id == 5_500 { 0.5 } else { 1e-4 };
            gobo::model::Particle { id, ..particle(center, 0.6, Vec4::new(1.0, 1.0, 1.0, alpha)) }
        })
        .collect();
    let expected = opaques(&cpu(&stack));
    assert!(expected.iter().any(|z| *z < 1.0));
    for tier in TIERS {
        let frame = map_frame(tier, &stack);
        let apart = share_apart(&opaques(&frame.maps), &expected);
        assert!(apart <= on(&gpu(tier), DITHERED), "{tier:?}: {apart} {:?}", frame.counters);
    }
}

/// Share of the light that passes panes of opacity `a`, one behind the other; the panes cover the map.
fn share_through(maps: &[f32]) -> f64 {
    maps.iter().filter(|z| **z == 1.0).count() as f64 / maps.len() as f64
}

/// Half edge of casters that fill a window of 4 m except its margin [m].
const FITTING: f32 = 1.96;

fn stack(pattern: Pattern, a: f32, ids: &[u32]) -> Scene {
    let mut scene =
        empty(vec![Material { tint: Vec4::new(1.0, 1.0, 1.0, a), ..dithered(pattern, 1) }]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    scene.shadow.size = 256;
    for (i, &id) in ids.iter().enumerate() {
        let faces = pane(0.2 + 0.1 * i as f32, FITTING, 0);
        scene.triangles.extend(faces.map(|face| gobo::model::Triangle { id, ..face }));
    }
    scene
}

#[test]
fn two_layers_in_the_map_let_a_quarter_through() {
    for pattern in Pattern::ALL {
        for tier in tiers(Tier::Native) {
            // A view's map is slightly larger than the panes.
            let all = |scene: &Scene| share_through(&opaques(&map_frame(tier, scene).maps));
            let margin = all(&stack(pattern, 1.0, &[0]));
            assert!(margin < 0.05, "{margin}");
            let open = |scene: &Scene| (all(scene) - margin) / (1.0 - margin);
            let two = open(&stack(pattern, 0.5, &[3, 70]));
            assert!((two - 0.25).abs() < 0.05, "{pattern:?} {tier:?}: {two}");
            let same = open(&stack(pattern, 0.5, &[3, 3]));
            assert!((same - 0.5).abs() < 0.05, "{pattern:?} {tier:?}: {same}");
        }
    }
}

/// A mean over many casters, because a single `checkerboard` caster picks a level.
#[test]
fn fading_panes_vanish_from_the_map_without_a_step() {
    for pattern in Pattern::ALL {
        let fading = |a: f32| {
            let mut scene = stack(pattern, a, &[]);
            let mut chance = Chance::new(2);
            scene.particles = (0..256)
                .map(|i| {
                    let at = Vec3::new((i % 16) as f32 - 7.5, (i / 16) as f32 - 7.5, 0.0)
                        * (FITTING / 8.0);
                    let id = chance.below(1 << 24) as u32;
                    gobo::model::Particle { id, ..particle(at, FITTING / 16.0, Vec4::ONE) }
                })
                .collect();
            (scene.materials[0].shape, scene.materials[0].profile) = (Shape::Quad, Profile::Flat);
            1.0 - share_through(&opaques(&map_frame(TIERS[1], &scene).maps))
        };
        let whole = fading(1.0);
        assert!(whole > 0.9, "{whole}");
        for a in [0.1, 0.03, 0.01, 0.003] {
            let share = fading(a) / whole;
            let a = f64::from(a);
            assert!((share - a).abs() <= 0.35 * a + 0.002, "{pattern:?} {a}: {share}");
        }
        assert_eq!(fading(0.0), 0.0, "{pattern:?}");
    }
}
