//! Pictures do not depend on where records are.
use crate::common::{
    Tier, gpu,
    scenes::{Chance, empty, light, material, random_discs, triangle},
    tiers,
};
use gobo::{
    LightKind, Scene, Transfer,
    glam::{Quat, UVec2, Vec3},
    gpu::RecordForm,
    model::{Gaussian, Material, Shape},
};
use gobo_picture::{Frame, RenderOptions, Renderer};

/// Discs, Gaussians and panes above a floor.
fn scene(pair_budget: u32) -> Scene {
    let splat = Material { shape: Shape::Gaussian, ..material(Transfer::Filter) };
    let looks = vec![material(Transfer::Filter), material(Transfer::Opaque), splat];
    let mut scene = empty(looks);
    scene.camera.size = UVec2::new(96, 80);
    scene.shadow.size = 64;
    scene.shadow.pair_budget = pair_budget;
    scene.particles = random_discs(300, 4);
    let mut chance = Chance::new(5);
    scene.gaussians = (0..40)
        .map(|id| Gaussian {
            center: chance.vec3(-1.0, 1.0),
            rotation: Quat::from_rotation_z(chance.within(0.0, 3.0)),
            sigma: chance.vec3(0.02, 0.3),
            color: chance.vec3(0.0, 1.0),
            opacity: chance.unit(),
            material: 2,
            id,
        })
        .collect();
    let [a, b, c] = [[-9.0, -2.0, 9.0], [9.0, -2.0, 9.0], [0.0, -2.0, -9.0]].map(Vec3::from);
    scene.triangles = vec![triangle([a, b, c], 1)];
    for _ in 0..8 {
        scene.triangles.push(triangle([0; 3].map(|_| chance.vec3(-1.0, 1.0)), 0));
    }
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.1) })];
    scene
}

fn frame(tier: Tier, scene: &Scene, form: RecordForm) -> Frame {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| config.tuning.record_form = form);
    renderer.render(scene, &RenderOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// With room for all pairs, and drawn in parts, which clip rectangles.
#[test]
fn pictures_have_the_same_bits_in_both_forms() {
    for tier in tiers(Tier::Native) {
        for pair_budget in [1 << 20, 300] {
            let scene = scene(pair_budget);
            let [buffers, textures] =
                [RecordForm::Buffers, RecordForm::Textures].map(|form| frame(tier, &scene, form));
            let what = format!("{tier}, room for {pair_budget} pairs");
            assert!(buffers.picture.rgb == textures.picture.rgb, "{what}");
            let is_clipped = buffers.memory.iter().any(|(name, _)| *name == "clipped_rects");
            assert_eq!(is_clipped, pair_budget < 1 << 20, "{what}");
        }
    }
}
