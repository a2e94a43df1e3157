//! Curves: light at receivers between the hits.
use super::{curve::curved, curve_bounds::LIGHT_ROUNDING};
use crate::{
    common::{
        map_frame, render,
        scenes::{Chance, empty, light, material, particle, triangle},
        tiers,
    },
    rivals::{Hit, exact},
};
use gobo::{
    glam::{UVec2, Vec2, Vec3, Vec4},
    gpu::Tier,
    model::{LightKind, Material, Particle, Profile, Transfer, Triangle, View},
};
use gobo_reference::shading::to_screen;
use gobo_scene as scene;
use gobo_scene::Scene;

const HEIGHTS: [f32; 6] = [1.5, 1.1, 0.55, 0.5, -0.3, -1.2];
const TINTS: [[f32; 4]; 6] = [
    [1.0, 0.5, 0.5, 0.4],
    [0.2, 0.9, 1.0, 0.5],
    [0.9, 0.9, 0.1, 0.3],
    [0.5, 0.5, 0.5, 0.5],
    [0.9, 0.1, 0.9, 0.2],
    [0.3, 1.0, 0.3, 0.6],
];
const STEPS: u32 = 100;

/// A light from above through panes, and white particles, each lower than the last.
fn stairs(clear: bool) -> Scene {
    let tint = |tint: [f32; 4]| if clear { Vec4::ONE } else { tint.into() };
    let pane = |own| Material { tint: tint(own), ..material(Transfer::Filter) };
    let mut materials: Vec<_> = TINTS.map(pane).into();
    // White: visible, but not filtering.
    materials.push(Material { profile: Profile::Flat, ..material(Transfer::Filter) });
    let mut scene = empty(materials);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.lights[0].intensity = 8.0;
    scene.shadow.bias = Some(0.002);
    scene.shadow.size = 512;
    scene.camera.eye = Vec3::new(0.0, 0.0, 8.0);
    scene.camera.fov_y = 0.55;
    scene.camera.size = UVec2::new(480, 480);
    for (i, &y) in HEIGHTS.iter().enumerate() {
        let corner = |x: f32, z: f32| Vec3::new(x, y, z);
        let (a, b, c, d) =
            (corner(-3.0, -2.0), corner(3.0, -2.0), corner(3.0, 0.05), corner(-3.0, 0.05));
        for corners in [[a, b, c], [a, c, d]] {
            scene.triangles.push(triangle(corners, i as u32));
        }
    }
    for id in 0..STEPS {
        let center = stair(id);
        scene.particles.push(Particle { material: 6, id, ..particle(center, RADIUS, Vec4::ONE) });
    }
    curved(scene, 8)
}

const RADIUS: f32 = 0.02;

fn stair(id: u32) -> Vec3 {
    let share = (id as f32 + 0.5) / STEPS as f32;
    Vec3::new(-1.9 + 3.8 * share, 1.9 - 3.8 * share, 0.0)
}

/// Transmittance of the panes above `y`, and whether no pane is within the bias.
fn through(y: f32) -> (Vec3, bool) {
    let mut light = Vec3::ONE;
    for (height, tint) in HEIGHTS.iter().zip(TINTS) {
        if y < *height {
            light *= Vec3::ONE - tint[3] * (Vec3::ONE - Vec3::new(tint[0], tint[1], tint[2]));
        }
    }
    (light, HEIGHTS.iter().all(|height| (height - y).abs() > 0.05))
}

#[test]
fn a_particle_gets_the_panes_before_it_and_no_others() {
    let scene = stairs(false);
    for tier in tiers(Tier::Native) {
        let bare = render(tier, &stairs(true)).picture;
        let frame = render(tier, &scene);
        let (map, curve) = (&frame.maps[0], frame.maps[0].curve.as_ref().unwrap());
        let camera = View::from_camera(&scene.camera, &scene.bounds());
        let mut seen = 0;
        for id in 0..STEPS {
            let (light, is_clear) = through(stair(id).y);
            if !is_clear {
                continue;
            }
            seen += 1;
            let p = map.view.view_from_world.transform_point3(stair(id));
            let at = Vec2::new(p.x, -p.y) * map.view.scale + map.view.size.as_vec2() * 0.5;
            let texel = at.y as usize * map.view.size.x as usize + at.x as usize;
            let z = (-p.z - map.view.near) / (map.view.far - map.view.near);
            let bias = 0.002 / (map.view.far - map.view.near);
            let is = curve.light_at(texel, z - bias);
            assert!((is - light).abs().max_element() <= LIGHT_ROUNDING, "{id}: {is} {light}");
            // In the picture: its colour without panes, times the panes' transmittance.
            let p = camera.view_from_world.transform_point3(stair(id));
            let at = Vec2::new(p.x, -p.y) * (camera.scale / -p.z) + camera.size.as_vec2() * 0.5;
            let pixel = at.y as usize * 480 + at.x as usize;
            let expected = to_screen(light * linear(bare.rgb[pixel][0]));
            for (is, should) in frame.picture.rgb[pixel].into_iter().zip(expected) {
                assert!(is.abs_diff(should) <= 3, "{id} {tier:?}: {is} {should}");
            }
            assert!(bare.rgb[pixel][0] > 180, "{:?}", bare.rgb[pixel]);
        }
        assert!(seen > 75, "{seen}");
    }
}

/// Linear grey whose screen value is `level`.
fn linear(level: u8) -> f32 {
    (0..4000).map(|i| i as f32 / 4000.0).find(|&v| to_screen(Vec3::splat(v))[0] >= level).unwrap()
}

/// Large triangles that intersect: they are sorted by their nearest corner, and their hits have another order
/// in each texel.
#[test]
fn crossing_triangles_are_in_order_in_every_texel() {
    let mut chance = Chance::new(21);
    let pane =
        |_| Material { tint: chance.vec3(0.1, 1.0).extend(0.5), ..material(Transfer::Filter) };
    let mut scene = empty((0..8).map(pane).collect());
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    for i in 0..8 {
        let mut height = || chance.within(-2.0, 2.0);
        let corners = [(-9.0, -9.0), (9.0, -9.0), (0.0, 12.0)];
        let corners = corners.map(|(x, z)| Vec3::new(x, height(), z));
        scene.triangles.push(triangle(corners, i));
    }
    let scene = curved(scene, 8);
    for tier in tiers(Tier::Native) {
        let frame = map_frame(tier, &scene);
        let map = &frame.maps[0];
        let (view, curve) = (&map.view, map.curve.as_ref().unwrap());
        let mut orders = std::collections::HashSet::new();
        for texel in 0..map.filter.len() {
            let (x, y) = (texel % view.size.x as usize, texel / view.size.x as usize);
            let at = (Vec2::new(x as f32, y as f32) + 0.5 - view.size.as_vec2() * 0.5) / view.scale;
            let mut hits: Vec<(Hit, usize)> = scene
                .triangles
                .iter()
                .enumerate()
                .filter_map(|(i, triangle)| {
                    let depth = met(view, triangle, Vec2::new(at.x, -at.y))?;
                    let tint = scene.materials[i].tint;
                    Some(((depth, 1.0 - tint.w * (1.0 - tint.truncate())), i))
                })
                .collect();
            hits.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
            orders.insert(hits.iter().map(|hit| hit.1).collect::<Vec<_>>());
            let hits: Vec<Hit> = hits.into_iter().map(|hit| hit.0).collect();
            // Depths are interpolated in the map and solved for here.
            let near = |z: f32| hits.iter().any(|hit| (hit.0 - z).abs() < 1e-4);
            for i in 0..40 {
                let z = (i as f32 + 0.5) / 40.0;
                let apart = (curve.light_at(texel, z) - exact(&hits, z)).abs().max_element();
                assert!(near(z) || apart <= 2.0 * LIGHT_ROUNDING, "{tier:?} {x} {y} {z}: {apart}");
            }
        }
        assert!(orders.len() > 10, "{}", orders.len());
        assert_eq!(frame.counters.disordered, 0);
    }
}

/// Light depth at which the ray through a point of the view's plane meets a triangle.
fn met(view: &View, triangle: &Triangle, at: Vec2) -> Option<f32> {
    let [a, b, c] = triangle.positions.map(|p| view.view_from_world.transform_point3(p));
    let cross = |p: Vec3, q: Vec3| (p.truncate() - at).perp_dot(q.truncate() - at);
    let (u, v, w) = (cross(b, c), cross(c, a), cross(a, b));
    let inside = (u > 0.0) == (v > 0.0) && (v > 0.0) == (w > 0.0);
    let depth = -(a.z * u + b.z * v + c.z * w) / (u + v + w);
    inside.then_some((depth - view.near) / (view.far - view.near))
}

/// Thirteen segments whose curves are appended.
#[test]
#[ignore = "many casters: make test-all"]
fn a_hundred_thousand_casters_on_one_tile() {
    const COUNT: u32 = 100_000;
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.shadow.size = 16;
    let mut chance = Chance::new(2);
    // Discs so large that their profile is 1 all over the map.
    let disc = |id| {
        let center = Vec3::new(0.0, 1.0 - 2.0 * (id as f32 + chance.unit()) / COUNT as f32, 0.0);
        let color = Vec4::new(0.9, 0.5, 0.0, 2e-5);
        Particle { id, ..particle(center, 50.0, color) }
    };
    scene.particles = (0..COUNT).map(disc).collect();
    let opacity = half::f16::from_f32(2e-5).to_f32();
    let scene = curved(scene, 8);
    for tier in tiers(Tier::Native) {
        let frame = map_frame(tier, &scene);
        let map = &frame.maps[0];
        let curve = map.curve.as_ref().unwrap();
        assert!(frame.counters.segments > 10, "{:?}", frame.counters);
        let center = 8 * 16 + 8;
        for i in 0..50 {
            let z = (i as f32 + 0.5) / 50.0;
            let y = map.view.position().y - map.view.near;
            let distance = map.view.near + z * (map.view.far - map.view.near);
            let height =
                map.view.view_from_world.inverse().transform_point3(Vec3::NEG_Z * distance).y;
            let share = ((1.0 - height) / 2.0).clamp(0.0, 1.0);
            let tau = share * COUNT as f32 * opacity * Vec3::new(0.1, 0.5, 1.0);
            let (is, should) = (curve.light_at(center, z), (-tau).exp());
            assert!((is - should).abs().max_element() < 0.02, "{tier:?} {z} {y}: {is} {should}");
        }
    }
}

/// Red smoke behind blue smoke in the light of a spot.
#[test]
fn smoke_behind_smoke_is_darker_and_bluer() {
    let set = [("camera.size", "[240, 135]"), ("shadow.size", "256")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    let path = crate::common::root().join("data/resolved.toml");
    let both = scene::load_with(&path, &set).unwrap_or_else(|error| panic!("{error}"));
    let red = both.materials.iter().position(|m| m.tint.x > m.tint.z && m.tint.w < 0.5).unwrap();
    let mut alone = both.clone();
    alone.particles.retain(|particle| particle.material == red as u32);
    assert!(alone.particles.len() < both.particles.len());
    let (with, without) =
        (render(Tier::Native, &both).picture, render(Tier::Native, &alone).picture);
    let (mut sums, mut count) = ([[0.0; 3]; 2], 0.0);
    for (a, b) in with.rgb.iter().zip(&without.rgb) {
        // Pixels of the red smoke.
        if b[0] > b[2].saturating_add(40) {
            for i in 0..3 {
                sums[0][i] += f64::from(a[i]);
                sums[1][i] += f64::from(b[i]);
            }
            count += 1.0;
        }
    }
    assert!(count > 300.0, "{count}");
    let brightness = |sum: [f64; 3]| (sum[0] + sum[1] + sum[2]) / count;
    let blueness = |sum: [f64; 3]| sum[2] / sum[0];
    assert!(brightness(sums[0]) < 0.8 * brightness(sums[1]), "{sums:?}");
    assert!(blueness(sums[0]) > 1.3 * blueness(sums[1]), "{sums:?}");
}
