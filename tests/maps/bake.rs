//! Cached maps: the right ones are rendered again, and all equal fresh ones.
use crate::common::{
    ByTier, gpu, map_frame, render,
    scenes::{Chance, empty, light, material, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    Prepared, Shadows,
    glam::{Mat4, Vec3, Vec4},
    gpu::Tier,
    model::{
        Counters, Light, LightKind, Material, Particle, Receiver, Source, Texture, Transfer, View,
    },
    records::ViewMaps,
    view::light_views,
};
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene::Scene;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// A renderer that keeps its maps, with an empty cache.
fn renderer(tier: Tier) -> MutexGuard<'static, Renderer> {
    static RENDERERS: ByTier<OnceLock<Mutex<Renderer>>> =
        [const { OnceLock::new() }; Tier::ALL.len()];
    let renderer =
        RENDERERS[tier as usize].get_or_init(|| Mutex::new(crate::common::renderer(tier)));
    let mut renderer = renderer.lock().unwrap_or_else(PoisonError::into_inner);
    renderer.forget();
    renderer
}

/// A frame of maps that are kept.
fn rendered(renderer: &mut Renderer, scene: &Scene) -> Frame {
    frame(renderer, scene, true)
}

fn frame(renderer: &mut Renderer, scene: &Scene, maps_only: bool) -> Frame {
    let options = RenderOptions { maps: true, keep: true, maps_only, ..RenderOptions::default() };
    renderer.render(scene, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// A frame of a renderer without a cache.
fn fresh(tier: Tier, scene: &Scene) -> Frame {
    let frame = map_frame(tier, scene);
    assert_eq!(views(&frame), (frame.maps.len() as u64, 0));
    frame
}

/// Numbers of rendered and of kept views.
fn views(frame: &Frame) -> (u64, u64) {
    let &Counters { views_rendered, views_kept, .. } = &frame.counters;
    (views_rendered, views_kept)
}

fn same_bits(a: &ViewMaps, b: &ViewMaps) -> bool {
    a.view == b.view
        && a.filter == b.filter
        && a.nearest == b.nearest
        && a.opaque == b.opaque
        && a.curve == b.curve
}

fn differing(a: &Frame, b: &Frame) -> Vec<usize> {
    assert_eq!(a.maps.len(), b.maps.len());
    (0..a.maps.len()).filter(|&i| !same_bits(&a.maps[i], &b.maps[i])).collect()
}

/// A lamp over a part of the ground that is 4 m wide.
fn lamp(x: f32, z: f32) -> Light {
    let position = Vec3::new(x, 6.0, z);
    let spot = LightKind::Spot { position, direction: Vec3::NEG_Y, angle: 0.6 };
    Light { near: Some(0.5), far: Some(8.0), size: Some(64), ..light(spot) }
}

/// A puff of particles around `center`.
fn emitter(center: Vec3, count: usize, seed: u64) -> Vec<Particle> {
    let mut particles = random_discs(count, seed);
    for particle in &mut particles {
        particle.center = particle.center * 0.4 + center;
        particle.radius *= 0.2;
    }
    particles
}

const EMITTERS: [Vec3; 4] = [
    Vec3::new(-10.0, 1.0, -10.0),
    Vec3::new(10.0, 1.0, -10.0),
    Vec3::new(-10.0, 1.0, 10.0),
    Vec3::new(10.0, 1.0, 10.0),
];
/// Particles of each emitter.
const COUNT: usize = 300;

/// A lamp over each emitter and one over none; a solid block under the second lamp.
fn scene() -> Scene {
    let mut scene = empty(vec![
        material(Transfer::Filter),
        material(Transfer::Opaque),
        Material { tint: Vec4::new(0.2, 0.5, 1.0, 0.5), ..material(Transfer::Stain) },
    ]);
    scene.lights = EMITTERS.iter().map(|e| lamp(e.x, e.z)).chain([lamp(0.0, 0.0)]).collect();
    for (seed, &center) in (1..).zip(&EMITTERS) {
        scene.particles.extend(emitter(center, COUNT, seed));
    }
    let corner = |x: f32, z: f32| Vec3::new(x, 0.5, z);
    let block = [corner(9.0, -11.0), corner(11.0, -11.0), corner(10.0, -9.0)];
    scene.triangles = vec![triangle(block, 1)];
    // Fixes the bounds of the scene.
    let far = Vec3::new(20.0, 5.0, 20.0);
    scene.particles.extend([far, -far].map(|center| particle(center, 0.1, Vec4::ONE)));
    scene
}

fn moved(scene: &Scene, emitter: usize, by: Vec3) -> Scene {
    let mut scene = scene.clone();
    for particle in &mut scene.particles[emitter * COUNT..(emitter + 1) * COUNT] {
        particle.center += by;
    }
    scene
}

#[test]
fn a_second_frame_renders_nothing() {
    let mut scene = scene();
    (scene.camera.target, scene.camera.eye) = (EMITTERS[0], EMITTERS[0] + Vec3::splat(4.0));
    for tier in tiers(Tier::Core) {
        let mut renderer = renderer(tier);
        let first = frame(&mut renderer, &scene, false);
        assert_eq!(views(&first), (5, 0));
        assert!(first.maps[0].filter.iter().any(|f| f[0] < 0.9), "there is a shadow");
        let mut around = scene.clone();
        for eye in [scene.camera.eye, EMITTERS[0] + Vec3::new(-3.0, 5.0, 1.0)] {
            around.camera.eye = eye;
            let second = frame(&mut renderer, &around, false);
            assert_eq!(views(&second), (0, 5));
            assert_eq!(second.counters.pairs, 0);
            assert!(
                second.stages.iter().all(|&(name, _)| name == "picture"),
                "{:?}",
                second.stages
            );
            assert!(differing(&first, &second).is_empty());
            assert_eq!(second.picture.rgb == first.picture.rgb, eye == scene.camera.eye);
        }
    }
}

#[test]
fn a_move_renders_only_the_views_that_see_it() {
    let before = scene();
    for tier in tiers(Tier::Core) {
        let mut renderer = renderer(tier);
        let mut last = rendered(&mut renderer, &before);
        let side = Vec3::new(0.0, 0.0, 0.3);
        let away = EMITTERS[3] - EMITTERS[0];
        let nowhere = Vec3::new(5.0, 0.0, 5.0);
        // Each change starts from the scene before it, with the views that see it before or after.
        let mut next = before.clone();
        next.particles[COUNT].color.w = 0.9;
        let mut solid = next.clone();
        solid.triangles[0].positions[0].y = 0.6;
        let mut gone = solid.clone();
        gone.triangles[0].positions = solid.triangles[0].positions.map(|p| p + nowhere);
        let mut turned = gone.clone();
        let LightKind::Spot { direction, .. } = &mut turned.lights[2].kind else { unreachable!() };
        *direction = Vec3::new(0.1, -1.0, 0.0).normalize();
        let steps = [
            (moved(&before, 0, side), vec![0]),
            (moved(&before, 0, away), vec![0, 3]),
            (moved(&before, 0, nowhere), vec![3]),
            (before.clone(), vec![0]),
            (next, vec![1]),
            (solid, vec![1]),
            (gone, vec![1]),
            (turned.clone(), vec![2]),
            (moved(&turned, 0, nowhere), vec![0]),
        ];
        for (step, (scene, seen)) in steps.iter().enumerate() {
            let frame = rendered(&mut renderer, scene);
            let kept = 5 - seen.len() as u64;
            assert_eq!(views(&frame), (seen.len() as u64, kept), "{tier:?}, step {step}");
            assert_eq!(differing(&last, &frame), *seen, "{tier:?}, step {step}");
            last = frame;
        }
        assert!(last.maps[1].opaque.iter().all(|&z| z == 1.0), "the block has left the view");
        assert!(last.maps[0].filter.iter().all(|&f| f == [1.0; 3]), "the puff has left the view");
        let all = fresh(tier, &steps[8].0);
        assert!(differing(&last, &all).is_empty(), "{tier:?}");
    }
}

/// Random changes; each frame is compared with that of a renderer that keeps nothing.
#[test]
#[ignore = "minutes of compiling kernels: make test-all"]
fn kept_frames_equal_fresh_ones() {
    let mut chance = Chance::new(1);
    let mut scene = scene();
    let mut position = EMITTERS[0];
    position.y = 2.0;
    let size = Some(64);
    scene.lights.push(Light { far: Some(12.0), size, ..light(LightKind::Point { position }) });
    scene
        .lights
        .push(light(LightKind::Directional { direction: Vec3::new(0.2, -1.0, 0.1).normalize() }));
    let noise: Vec<u8> = (0..16 * 16 * 4).map(|_| chance.below(256) as u8).collect();
    scene.textures = vec![Texture { name: "noise".into(), width: 16, height: 16, rgba: noise }];
    scene.materials[2].texture = Some(0);
    for particle in &mut scene.particles[3 * COUNT..4 * COUNT] {
        particle.material = 2;
    }
    let mut keeps = renderer(Tier::Native);
    let mut kept = 0;
    for step in 0..10 {
        let frame = frame(&mut keeps, &scene, false);
        let all = render(Tier::Native, &scene);
        assert!(differing(&frame, &all).is_empty(), "step {step}");
        assert!(frame.picture.rgb == all.picture.rgb, "step {step}");
        kept += frame.counters.views_kept;
        match step {
            0 => scene = moved(&scene, 1, Vec3::new(0.2, 0.1, 0.0)),
            1 => scene.materials[2].tint.w = 0.8,
            2 => scene.textures[0].rgba.reverse(),
            3 => scene.lights[1].intensity = 7.0,
            4 => scene.lights.swap(0, 1),
            5 => scene.particles.truncate(4 * COUNT - 3),
            6 => scene.lights[3].size = Some(80),
            7 => scene.particles[5].material = 1,
            _ => {
                let turn = Mat4::from_rotation_y(chance.within(0.0, 6.0));
                for particle in &mut scene.particles {
                    particle.center = turn.transform_point3(particle.center);
                }
            }
        }
    }
    // Twelve views in each of nine frames: some are always kept, others never.
    assert!((30..90).contains(&kept), "{kept}");
}

#[test]
fn softened_maps_stay_too() {
    let mut scene = scene();
    scene.shadow.soften = true;
    scene.materials[0].transfer = Transfer::Dither;
    let mut renderer = renderer(Tier::Native);
    let first = rendered(&mut renderer, &scene);
    let second = rendered(&mut renderer, &scene);
    assert_eq!(views(&second), (0, 5));
    assert!(differing(&first, &second).is_empty());
    let scene = moved(&scene, 2, Vec3::new(0.3, 0.0, 0.0));
    let third = rendered(&mut renderer, &scene);
    assert_eq!(views(&third), (1, 4));
    assert_eq!(differing(&second, &third), [2]);
    assert!(differing(&third, &fresh(Tier::Native, &scene)).is_empty());
}

/// Cached curves; a `gain` caster makes all of them be rendered again.
#[test]
fn curves_stay_too() {
    let mut scene = scene();
    scene.shadow.receiver = Receiver::Curve;
    let mut renderer = renderer(Tier::Native);
    // As in `fresh`.
    renderer.configure(|config| config.toggles.queued = false);
    rendered(&mut renderer, &scene);
    let mut brighter = moved(&scene, 1, Vec3::new(0.2, 0.0, 0.0));
    brighter.materials.push(material(Transfer::Gain));
    let mut gain = brighter.clone();
    gain.particles[0].material = 3;
    let mut resized = scene.clone();
    resized.lights[1].size = Some(32);
    let steps = [(scene.clone(), 0), (moved(&scene, 1, Vec3::X * 0.2), 1), (gain, 5), (resized, 5)];
    for (step, (scene, anew)) in steps.iter().enumerate() {
        let frame = rendered(&mut renderer, scene);
        assert_eq!(views(&frame), (*anew, 5 - anew), "step {step}");
        assert!(frame.maps.iter().all(|maps| maps.curve.is_some()));
        assert!(differing(&frame, &fresh(Tier::Native, scene)).is_empty(), "step {step}");
    }
}

/// A light's viewpoints are rendered again when it or a caster before them moves, and no others.
#[test]
fn maps_of_viewpoints_stay_too() {
    let mut scene = scene();
    let disc = |radius| Some(Source::Disc { radius, direction: Vec3::NEG_Y });
    (scene.lights[1].source, scene.lights[1].viewpoints) = (disc(0.3), 4);
    (scene.lights[2].source, scene.lights[2].viewpoints) = (disc(0.3), 3);
    let mut renderer = renderer(Tier::Native);
    let mut before = frame(&mut renderer, &scene, false);
    assert_eq!(views(&before), (10, 0));
    let [mut brighter, mut aside, mut wider] = [(); 3].map(|()| scene.clone());
    brighter.lights[1].intensity = 9.0;
    aside.lights[1].kind = lamp(10.1, -10.0).kind;
    wider.lights[2].source = disc(0.4);
    let steps = [
        ("the same", scene.clone(), 0),
        ("brighter", brighter, 0),
        ("aside", aside, 4),
        ("back", scene.clone(), 4),
        ("wider", wider, 3),
        ("smoke moves", moved(&scene, 2, Vec3::X * 0.2), 3),
        ("smoke elsewhere moves", moved(&moved(&scene, 2, Vec3::X * 0.2), 0, Vec3::X * 0.2), 1),
    ];
    for (step, scene, anew) in &steps {
        let (kept, all) = (frame(&mut renderer, scene, false), render(Tier::Native, scene));
        assert_eq!(views(&kept), (*anew, 10 - anew), "{step}");
        assert!(differing(&kept, &all).is_empty(), "{step}");
        assert!(kept.picture.rgb == all.picture.rgb, "{step}");
        assert_eq!(differing(&before, &kept).len() as u64, *anew, "{step}");
        before = kept;
    }
}

/// Other sizes pack the atlas anew: cached maps are copied to their new rectangles.
#[test]
fn maps_that_change_places_stay() {
    for soften in [false, true] {
        let mut scene = scene();
        scene.shadow.soften = soften;
        scene.materials[0].transfer = if soften { Transfer::Dither } else { Transfer::Filter };
        let mut renderer = renderer(Tier::Native);
        let first = rendered(&mut renderer, &scene);
        scene.lights[0].size = Some(256);
        scene.lights.push(Light { size: Some(128), ..lamp(-9.0, -9.0) });
        let second = rendered(&mut renderer, &scene);
        assert_eq!(views(&second), (2, 4));
        for view in 1..5 {
            assert!(same_bits(&first.maps[view], &second.maps[view]), "view {view}");
        }
        assert!(differing(&second, &fresh(Tier::Native, &scene)).is_empty());
        scene.lights.pop();
        assert_eq!(views(&rendered(&mut renderer, &scene)), (0, 5));
    }
}

/// If pairs do not fit at first, the views are rendered again, and the next frame keeps them.
#[test]
fn a_frame_that_needed_more_pairs_is_kept() {
    let mut scene = scene();
    scene.lights.iter_mut().for_each(|light| light.size = Some(1024));
    for particle in &mut scene.particles {
        particle.radius *= 8.0;
    }
    let mut renderer = renderer(Tier::Native);
    let first = rendered(&mut renderer, &scene);
    assert!(first.counters.pairs > 5 * 4 * COUNT as u64 + 65536, "{:?}", first.counters);
    let second = rendered(&mut renderer, &scene);
    assert_eq!(views(&second), (0, 5));
    assert!(differing(&first, &second).is_empty());
}

/// A host that prepares without recording loses nothing, and recording twice keeps the maps.
#[test]
fn what_was_not_recorded_is_still_to_be_rendered() {
    let gpu = gpu(Tier::Native);
    let mut shadows = crate::common::shadows(&gpu);
    let scene = scene();
    let bounds = gobo::model::Bounds::EMPTY.with_sphere(Vec3::ZERO, 20.0);
    let views: Vec<View> = (0..)
        .zip(&scene.lights)
        .flat_map(|(index, light)| light_views(index, light, 64, None, &bounds).unwrap())
        .collect();
    let prepare = |shadows: &mut Shadows, scene: &Scene| {
        shadows.prepare(&scene.casters(), &views, &scene.shadow).expect("it fits")
    };
    let rendered =
        |prepared: &Prepared| prepared.counters().expect("it is the last").views_rendered;
    let record = |prepared: &Prepared| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).expect("it is the last");
        gpu.queue.submit([encoder.finish()]);
    };
    let again = |shadows: &mut Shadows, scene: &Scene| {
        let prepared = prepare(shadows, scene);
        (rendered(&prepared), prepared)
    };
    let shadows = &mut shadows;
    assert_eq!(again(shadows, &scene).0, 5);
    let (count, prepared) = again(shadows, &scene);
    assert_eq!(count, 5, "it was not recorded");
    record(&prepared);
    assert_eq!(again(shadows, &scene).0, 0);
    let mut next = scene.clone();
    next.particles[0].center.y += 0.01;
    let (count, prepared) = again(shadows, &next);
    let culled = prepared.counters().expect("it is the last").culled;
    assert!(count == 1 && culled > 2 * COUNT as u64, "{count} {culled}");
    let (count, prepared) = again(shadows, &next);
    assert_eq!(count, 1, "it was not recorded");
    record(&prepared);
    record(&prepared);
    let (count, prepared) = again(shadows, &next);
    assert_eq!(count, 0);
    record(&prepared);
    let full = Counters { pairs_needed: 2, pair_capacity: 1, ..Counters::default() };
    assert!(shadows.grow_from(&full));
    assert_eq!(again(shadows, &next).0, 0, "it rendered nothing");
    next.particles.pop();
    let (count, prepared) = again(shadows, &next);
    assert_eq!(count, 5, "another set");
    record(&prepared);
    assert!(shadows.grow_from(&Counters { pairs_needed: 4, pair_capacity: 3, ..full }));
    assert_eq!(again(shadows, &next).0, 5, "pairs did not fit");
}
