//! Absorption of puffs along their chord: closed forms against the CPU reference and both tiers.
use crate::common::{
    Tier,
    brute_force::render as brute_force,
    compare::{Tolerance, assert_maps_agree},
    scenes::{Chance, empty, hold_view, light, material, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Vec2, Vec3, Vec4},
    model::{LightKind, Material, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Rounding of the filter's storage, and of 16-bit opacities and colours.
const ROUNDING: f32 = 1e-3;
/// Rounding of depths in 32 bits.
const DEPTH_ROUNDING: f32 = 1e-5;
const COLOR: Vec4 = Vec4::new(0.1, 0.5, 1.0, 0.8);
/// Edge of the map [texels], odd, so that the central ray is the axis.
const SIZE: u32 = 33;
const WALL: u32 = 1;

/// A light at the origin that looks along -z, 20 x 20 x 20 m around it, for any contents.
fn stage(kind: LightKind) -> Scene {
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut scene = empty(vec![puff, material(Transfer::Opaque)]);
    let mut axis = light(kind);
    axis.size = Some(SIZE);
    axis.near = Some(0.01);
    scene.lights.push(axis);
    hold_view(&mut scene, WALL);
    scene
}

fn kinds() -> [LightKind; 3] {
    let (position, direction) = (Vec3::ZERO, Vec3::NEG_Z);
    [
        LightKind::Directional { direction },
        LightKind::Spot { position, direction, angle: 0.8 },
        LightKind::Point { position },
    ]
}

/// Maps of CPU reference and tiers, of the view along -z.
fn maps_of(scene: &Scene) -> Vec<ViewMaps> {
    let along = |maps: Vec<ViewMaps>| {
        let found = maps.into_iter().find(|maps| maps.view.direction().z < -0.99);
        found.expect("a view along -z")
    };
    let mut all = vec![along(render_maps(scene, &shadow_views(scene)).0)];
    all.extend(
        tiers(Tier::Native)
            .into_iter()
            .map(|tier| along(crate::common::map_frame(tier, scene).maps)),
    );
    all
}

/// Checks `F` and, if the ray enters at `enters` [m before the light], `D` of the central texel.
fn assert_middle(scene: &Scene, share: f32, enters: Option<f32>) {
    let whole = Vec3::ONE - COLOR.w * (Vec3::ONE - COLOR.truncate());
    let expected = whole.powf(share);
    for maps in maps_of(scene) {
        let middle = (SIZE * SIZE / 2) as usize;
        let (filter, view) = (Vec3::from_array(maps.filter[middle]), &maps.view);
        let what = format!("share {share} in {view:?}");
        assert!(
            (filter - expected).abs().max_element() <= ROUNDING,
            "{filter}, {expected}, {what}"
        );
        let along = |z: f32| -view.view_from_world.transform_point3(Vec3::new(0.0, 0.0, -z)).z;
        let depth = enters.map_or(1.0, |z| (along(z) - view.near) / (view.far - view.near));
        let nearest = maps.nearest[middle];
        assert!((nearest - depth).abs() <= DEPTH_ROUNDING, "{nearest}, {depth}, {what}");
    }
}

fn puff(x: f32, y: f32, z: f32, radius: f32) -> gobo::model::Particle {
    particle(Vec3::new(x, y, -z), radius, COLOR)
}

fn wall(z: f32) -> gobo::model::Triangle {
    let corner = |x: f32, y: f32| Vec3::new(x * 9.0, y * 9.0, -z);
    triangle([corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)], WALL)
}

#[test]
fn chords_are_shorter_off_the_middle() {
    for kind in kinds() {
        for (x, y) in [(0.0_f32, 0.0_f32), (0.6, 0.0), (-0.5, 0.8), (0.0, -1.19)] {
            let mut scene = stage(kind);
            scene.particles.push(puff(x, y, 5.0, 1.2));
            let half = (1.2 * 1.2 - x * x - y * y).sqrt();
            assert_middle(&scene, half / 1.2, Some(5.0 - half));
        }
        let mut beside = stage(kind);
        beside.particles.push(puff(1.0, 0.7, 5.0, 1.2));
        assert_middle(&beside, 0.0, None);
    }
}

#[test]
fn chords_end_at_the_opaque_surface() {
    for kind in kinds() {
        for z in [5.0, 4.2, 6.5] {
            let mut scene = stage(kind);
            scene.particles.push(puff(0.6, 0.0, 5.0, 1.0));
            scene.triangles.push(wall(z));
            let inside = (z - 4.2).clamp(0.0, 1.6);
            let entered = (inside > 0.0).then_some(4.2);
            assert_middle(&scene, inside / 2.0, entered);
        }
    }
}

#[test]
fn a_light_inside_sees_the_rest_of_the_chord() {
    for kind in kinds() {
        let mut scene = stage(kind);
        scene.particles.push(puff(0.0, 0.0, 1.0, 2.0));
        // A directional light's rays start at its near plane.
        scene.lights[0].near =
            Some(if let LightKind::Directional { .. } = kind { 9.5 } else { 0.01 });
        let start = match kind {
            LightKind::Directional { .. } => {
                let view = &shadow_views(&scene)[0];
                let eye = view.view_from_world.inverse().w_axis;
                view.near - eye.z
            }
            _ => 0.01,
        };
        assert!(start > -1.0 && start < 3.0);
        assert_middle(&scene, (3.0 - start) / 4.0, Some(start));
    }
}

#[test]
fn puffs_multiply() {
    for kind in kinds() {
        let mut scene = stage(kind);
        // Two that overlap and one far behind: the sum of the chords counts.
        scene.particles =
            vec![puff(0.0, 0.0, 3.0, 1.0), puff(0.6, 0.0, 3.5, 1.0), puff(0.0, 0.0, 7.0, 0.5)];
        assert_middle(&scene, 1.0 + 0.8 + 1.0, Some(2.0));
    }
}

/// A puff smaller than a texel is enlarged, with less opacity. Light is conserved at low absorption: the mean
/// of its shadow is `2/3 a pi r^2`, as the mean chord is 2/3 of the diameter.
#[test]
fn puffs_below_a_texel_conserve_light() {
    const CELLS: u32 = 24;
    let alpha = 0.05;
    for radius in [0.5_f32, 1.0, 3.0] {
        let mut scene = stage(LightKind::Directional { direction: Vec3::NEG_Z });
        scene.lights[0].size = Some(512);
        let texel = 1.0 / shadow_views(&scene)[0].scale;
        for i in 0..CELLS * CELLS {
            let cell = Vec2::new((i % CELLS) as f32, (i / CELLS) as f32);
            let part = cell / CELLS as f32;
            let at = (cell - CELLS as f32 / 2.0) * 16.0 + 4.0 + part;
            let black = Vec4::new(0.0, 0.0, 0.0, alpha);
            scene.particles.push(particle((at * texel).extend(-5.0), radius * texel, black));
        }
        let area = f64::from(CELLS * CELLS) * std::f64::consts::PI * f64::from(radius * radius);
        // Mean of a sphere's shadow: 1 - 2 (1 - (1 - a)(1 + k)) / k^2, k = -ln(1 - a).
        let k = -(1.0 - f64::from(alpha)).ln();
        let mean = 1.0 - 2.0 * (1.0 - (-k).exp() * (1.0 + k)) / (k * k);
        for maps in maps_of(&scene) {
            let shadow: f64 = maps.filter.iter().map(|f| 1.0 - f64::from(f[0])).sum();
            let share = shadow / (area * mean);
            assert!((share - 1.0).abs() < 0.02, "{radius}: {share}");
        }
    }
}

/// Clouds against the renderer in 64 bits, which intersects spheres in world space.
#[test]
fn clouds_of_puffs_agree_with_the_formulas() {
    let position = Vec3::new(3.0, 4.0, 2.5);
    let kinds = [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 },
        LightKind::Point { position: Vec3::new(2.2, 0.4, -0.3) },
    ];
    let tolerance = Tolerance { filter: ROUNDING.into(), depth: 1e-5, undecided: 0.4 };
    for kind in kinds {
        let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
        let mut scene = empty(vec![puff, material(Transfer::Opaque)]);
        scene.lights.push(light(kind));
        scene.shadow.size = 48;
        scene.particles = random_discs(60, 23);
        let mut chance = Chance::new(5);
        for _ in 0..3 {
            let center = chance.vec3(-1.0, 1.0);
            let positions = [0; 3].map(|_| center + chance.vec3(-0.8, 0.8));
            scene.triangles.push(triangle(positions, 1));
        }
        let views = shadow_views(&scene);
        let mut all = vec![render_maps(&scene, &views).0];
        all.extend(
            tiers(Tier::Native).into_iter().map(|tier| crate::common::map_frame(tier, &scene).maps),
        );
        for (i, view) in views.iter().enumerate() {
            let expected = brute_force(&scene, view);
            for maps in &all {
                assert_maps_agree(&expected, &maps[i], tolerance);
            }
        }
    }
}
