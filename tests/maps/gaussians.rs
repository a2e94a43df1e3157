//! Gaussians: the CPU reference and the kernels against the definition in 64 bits.
use crate::common::{
    Tier,
    brute_force::render,
    compare::{Tolerance, assert_maps_agree, compare_maps},
    scenes::{Chance, empty, hold_view, light, material, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Quat, Vec3, Vec4},
    model::{Gaussian, GaussianOpacity, LightKind, Material, Projection, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Cut-off of each at its last 8192th, and 16-bit colours; depths in 32 bits.
const TOLERANCE: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.02 };
/// A medium's thickness is stored in 16 bits.
const OF_MEDIA: Tolerance = Tolerance { undecided: 0.1, ..TOLERANCE };

pub(super) fn kinds() -> [LightKind; 3] {
    let position = Vec3::new(3.0, 4.0, 2.5);
    [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 },
        // Among the Gaussians: every face of the cube sees some, and some cross its seams.
        LightKind::Point { position: Vec3::new(0.1, 0.2, -0.1) },
    ]
}

pub(super) fn splats(transfer: Transfer) -> Material {
    Material { shape: Shape::Gaussian, ..material(transfer) }
}

pub(super) fn medium(density: f32) -> Material {
    let gaussian = GaussianOpacity::Medium { density };
    Material { gaussian, ..splats(Transfer::Filter) }
}

/// Needles, pancakes and balls around the origin, the longest 8 times as long as the thinnest.
fn random_gaussians(count: u32, thinnest: f32, seed: u64) -> Vec<Gaussian> {
    let mut chance = Chance::new(seed);
    let one = |id| {
        let long = thinnest * 8.0_f32.powf(chance.unit());
        let sigma = match chance.below(3) {
            0 => Vec3::new(long, thinnest, thinnest),
            1 => Vec3::new(long, thinnest, long),
            _ => Vec3::new(long, long * 0.5, long * 0.7).max(Vec3::splat(thinnest)),
        };
        let axis = chance.vec3(-1.0, 1.0).normalize_or(Vec3::X);
        Gaussian {
            center: chance.vec3(-1.6, 1.6),
            rotation: Quat::from_axis_angle(axis, chance.within(0.0, 3.0)),
            sigma,
            color: chance.vec3(0.0, 1.0),
            opacity: chance.unit(),
            id,
            ..Gaussian::default()
        }
    };
    (0..count).map(one).collect()
}

/// Gaussians of a material, as thin as a map's largest texel.
pub(super) fn lit_by(kind: LightKind, materials: Vec<Material>, count: u32) -> Scene {
    let mut scene = empty(materials);
    scene.shadow.size = 128;
    scene.lights.push(light(kind));
    let mut thinnest = 0.02;
    for _ in 0..6 {
        scene.gaussians = random_gaussians(count, thinnest, 3);
        let texels = shadow_views(&scene).into_iter().flat_map(|view| {
            let centers = scene.gaussians.iter().map(|g| g.center);
            let depths = centers.map(move |c| -view.view_from_world.transform_point3(c).z);
            let parallel = view.projection == Projection::Orthographic;
            depths.map(move |depth| if parallel { 1.0 } else { depth } / view.scale)
        });
        thinnest = 0.75 * texels.fold(0.0, f32::max);
    }
    scene
}

pub(super) fn all_maps(scene: &Scene) -> Vec<Vec<ViewMaps>> {
    let mut all = vec![render_maps(scene, &shadow_views(scene)).0];
    let kernels = tiers(Tier::Native).into_iter();
    all.extend(kernels.map(|tier| crate::common::map_frame(tier, scene).maps));
    all
}

pub(super) fn assert_agrees(scene: &Scene, tolerance: Tolerance) {
    let views = shadow_views(scene);
    let truth: Vec<_> = views.iter().map(|view| render(scene, view)).collect();
    for maps in all_maps(scene) {
        for (truth, maps) in truth.iter().zip(&maps) {
            assert_maps_agree(truth, maps, tolerance);
        }
    }
}

#[test]
fn gaussian_splats_agree_with_their_definition() {
    for kind in kinds() {
        assert_agrees(&lit_by(kind, vec![splats(Transfer::Filter)], 60), TOLERANCE);
    }
}

#[test]
fn gaussian_media_agree_with_quadrature() {
    for kind in kinds() {
        let mut scene = lit_by(kind, vec![medium(3.0), material(Transfer::Opaque)], 40);
        let mut chance = Chance::new(5);
        for _ in 0..3 {
            let center = chance.vec3(-1.0, 1.0);
            let positions = [0; 3].map(|_| center + chance.vec3(-0.8, 0.8));
            scene.triangles.push(triangle(positions, 1));
        }
        assert_agrees(&scene, OF_MEDIA);
    }
}

/// All transfers of splats, with discs, a pane of glass and opaque triangles.
#[test]
fn gaussians_mix_with_all_other_casters() {
    for kind in kinds() {
        let glass = Material { tint: Vec4::new(0.9, 0.5, 0.3, 0.7), ..material(Transfer::Filter) };
        let neutral = Material { neutral: true, ..splats(Transfer::Filter) };
        let materials = vec![
            splats(Transfer::Filter),
            splats(Transfer::Stain),
            splats(Transfer::Smoke),
            neutral,
            material(Transfer::Filter),
            glass,
            material(Transfer::Opaque),
        ];
        let mut scene = lit_by(kind, materials, 40);
        for (gaussian, material) in scene.gaussians.iter_mut().zip((0..4).cycle()) {
            gaussian.material = material;
            if material == 1 {
                // With another colour, a stain would end at an edge.
                gaussian.color = Vec3::ONE;
            }
        }
        scene.particles = random_discs(60, 11);
        scene.particles.retain(|p| p.center.distance(Vec3::new(0.1, 0.2, -0.1)) > 0.8);
        scene.particles.iter_mut().for_each(|p| p.material = 4);
        let mut chance = Chance::new(9);
        for i in 0..6 {
            let center = chance.vec3(-1.5, 1.5);
            let positions = [0; 3].map(|_| center + chance.vec3(-0.6, 0.6));
            scene.triangles.push(triangle(positions, 5 + u32::from(i % 3 == 0)));
        }
        assert_agrees(&scene, Tolerance { undecided: 0.25, ..TOLERANCE });
    }
}

#[test]
fn a_gaussian_left_out_or_turned_is_noticed() {
    let scene = lit_by(kinds()[1], vec![splats(Transfer::Filter)], 60);
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    let differs = |scene: &Scene| {
        let (maps, _) = render_maps(scene, std::slice::from_ref(view));
        compare_maps(&expected, &maps[0], TOLERANCE).is_err()
    };
    assert!(!differs(&scene));
    let seen = |g: &Gaussian| g.opacity > 0.3 && g.sigma.x > 4.0 * g.sigma.y;
    let seen = scene.gaussians.iter().position(seen).expect("a needle");
    let mut fewer = scene.clone();
    fewer.gaussians.remove(seen);
    assert!(differs(&fewer));
    let mut turned = scene.clone();
    turned.gaussians[seen].rotation *= Quat::from_rotation_z(0.2);
    assert!(differs(&turned));
}

/// Smaller than a texel: enlarged, with less opacity, so that the shadow's sum is the splat's: opacity times
/// `2 pi sigma^2`.
#[test]
fn gaussians_below_a_texel_conserve_light() {
    const CELLS: u32 = 12;
    for (sigma, is_medium) in [0.3, 0.5, 1.0].into_iter().flat_map(|s| [(s, false), (s, true)]) {
        let mut scene = empty(vec![splats(Transfer::Filter), material(Transfer::Opaque)]);
        let mut axis = light(LightKind::Directional { direction: Vec3::NEG_Z });
        axis.size = Some(256);
        scene.lights.push(axis);
        hold_view(&mut scene, 1);
        let texel = 1.0 / shadow_views(&scene)[0].scale;
        let deviation: f32 = sigma * texel;
        if is_medium {
            scene.materials[0] = medium(1.0 / (deviation * std::f32::consts::TAU.sqrt()));
        }
        for i in 0..CELLS * CELLS {
            let cell = Vec3::new((i % CELLS) as f32, (i / CELLS) as f32, 0.0);
            let at = (cell - CELLS as f32 / 2.0) * 18.0 + 4.0 + cell / CELLS as f32;
            scene.gaussians.push(Gaussian {
                center: at.with_z(0.0) * texel,
                sigma: Vec3::splat(deviation),
                color: Vec3::ZERO,
                ..Gaussian::default()
            });
        }
        // For an optical depth of 1: the exponential integral, the sum of -(-1)^n / (n n!).
        let mean = if is_medium { 0.796_599_599 } else { 1.0 };
        let area = std::f64::consts::TAU * f64::from(sigma * sigma) * f64::from(CELLS * CELLS);
        for maps in all_maps(&scene) {
            let shadow: f64 = maps[0].filter.iter().map(|f| 1.0 - f64::from(f[0])).sum();
            let share = shadow / (area * mean);
            // Cut-off at a 256th, and light in 16 bits.
            assert!((share - 1.0).abs() < 0.02, "{sigma}, {is_medium}: {share}");
        }
    }
}
