//! Curves: light as a function of depth.
use crate::{
    common::{
        TIERS, render,
        scenes::{Chance, empty, light, material, particle, random_discs, triangle},
    },
    curves::{Method, Rays, Sample},
    rivals::{Fourier, Hit, Moments, exact},
};
use gobo::{
    glam::{UVec2, Vec2, Vec3, Vec4},
    gpu::Tier,
    model::{
        LightKind, Material, Particle, Profile, Receiver, ShadowSettings, Shape, Transfer,
        Triangle, View,
    },
    records::ViewMaps,
    reference::{
        self,
        curve::{MAX_NODES, Streaming, light_at},
        shading::to_screen,
    },
    scene::{self, Scene},
    view::shadow_views,
};

/// Of a stored depth and of a stored channel.
const DEPTH_ROUNDING: f32 = 0.5 / 65535.0;
const LIGHT_ROUNDING: f32 = 0.5 / 4095.0 + 1.0 / 65535.0;

fn random_hits(count: usize, seed: u64) -> Vec<Hit> {
    let mut chance = Chance::new(seed);
    (0..count).map(|_| (chance.within(0.001, 0.999), chance.vec3(0.3, 1.0))).collect()
}

fn streamed(hits: &[Hit], nodes: u32) -> Vec<[u32; 2]> {
    let mut curve = Streaming::new(nodes, false);
    for &(depth, light) in hits {
        curve.insert(depth, depth, light);
    }
    curve.pack().collect()
}

/// Largest difference of a channel; light under 1/1024 is stored as 0.
fn apart(packed: &[[u32; 2]], hits: &[Hit], z: f32) -> f32 {
    let (is, should) = (light_at(packed, z, false), exact(hits, z));
    let channel = |i: usize| {
        let black = is[i] == 0.0 && should[i] < reference::resolve::BLACK + LIGHT_ROUNDING;
        if black { 0.0 } else { (is[i] - should[i]).abs() }
    };
    (0..3).map(channel).fold(0.0, f32::max)
}

/// Depths that no rounding of a hit's depth reaches.
fn clear_depths(hits: &[Hit]) -> impl Iterator<Item = f32> {
    let near = |z: f32| hits.iter().any(|hit| (hit.0 - z).abs() <= 2.0 * DEPTH_ROUNDING);
    (0..997).map(|i| (i as f32 + 0.5) / 997.0).filter(move |&z| !near(z))
}

#[test]
fn curves_beat_what_others_store() {
    for rays in Rays::ALL {
        let sample = Sample::new(rays);
        let (fourier, moments) = (sample.error(Method::Fourier), sample.error(Method::Moments));
        let share = match rays {
            Rays::Smoke => 1.2,
            Rays::Panes => 0.01,
            Rays::Puffs => 0.25,
        };
        for method in [Method::Curve(8), Method::Slabs(8)] {
            let mean = sample.error(method).mean;
            assert!(mean <= share * fourier.mean, "{rays:?} {method:?}: {mean} {fourier:?}");
            assert!(mean <= 0.25 * moments.mean, "{rays:?} {method:?}: {mean} {moments:?}");
        }
        // More nodes are better, and none are bad: the comparison can fail.
        let of = |nodes| sample.error(Method::Curve(nodes)).mean;
        assert!(of(16) < of(8) && of(8) < of(4), "{rays:?}");
        assert!(sample.error(Method::Nearest).mean > 2.0 * fourier.mean, "{rays:?}");
    }
}

/// The rivals are what they claim to be: exact where their papers say so.
#[test]
fn rivals_are_honest() {
    let hits = random_hits(6, 3);
    let fourier = Fourier::new(&hits);
    // The integral over the whole range is the constant coefficient's.
    assert!((fourier.light_at(1.0) - exact(&hits, 1.0)).abs().max_element() < 1e-4);
    // Four moments bound a single step from both sides: 0 before it, all of it behind.
    let single = [(0.5, Vec3::splat(0.25))];
    let moments = Moments::new(&single);
    assert!((moments.light_at(0.2) - Vec3::ONE).abs().max_element() < 0.01);
    assert!((moments.light_at(0.8) - Vec3::splat(0.25)).abs().max_element() < 0.01);
}

#[test]
fn exact_while_at_most_k_hits_in_any_order() {
    for nodes in [4, 8, 16] {
        for seed in 0..20 {
            let hits = random_hits(nodes as usize, seed);
            let packed = streamed(&hits, nodes);
            for z in clear_depths(&hits) {
                let apart = apart(&packed, &hits, z);
                assert!(apart <= LIGHT_ROUNDING, "{nodes} {seed} {z}: {apart}");
            }
        }
        // One hit more is not: the check can fail.
        let hits = random_hits(nodes as usize + 1, 7);
        let packed = streamed(&hits, nodes);
        assert!(clear_depths(&hits).any(|z| apart(&packed, &hits, z) > LIGHT_ROUNDING), "{nodes}");
    }
}

/// Whatever is merged, the error is at most what the light loses in one node.
#[test]
fn the_bound_holds() {
    for (count, seed) in [(9, 1), (12, 2), (30, 3), (100, 4), (300, 5)] {
        let mut hits = random_hits(count, seed);
        for hit in &mut hits {
            hit.1 = hit.1.powf(8.0 / count as f32);
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        for nodes in [4, 8, MAX_NODES as u32] {
            let packed = streamed(&hits, nodes);
            // Behind the last of the first i nodes.
            let behind = |i: usize| light_at(&packed[..i], 2.0, false);
            let loss = |i: usize| (behind(i) - behind(i + 1)).max_element();
            let bound = (0..packed.len()).map(loss).fold(0.0, f32::max);
            let worst = clear_depths(&hits).map(|z| apart(&packed, &hits, z)).fold(0.0, f32::max);
            assert!(worst <= bound + 2.0 * LIGHT_ROUNDING, "{count} {nodes}: {worst} > {bound}");
            assert!(worst > 0.0);
        }
    }
}

#[test]
fn light_never_grows_with_depth() {
    let mut hits = random_hits(200, 9);
    hits.iter_mut().for_each(|hit| hit.1 = hit.1.powf(0.05));
    let packed = streamed(&hits, 8);
    let mut before = Vec3::ONE;
    for i in 0..=2000 {
        let light = light_at(&packed, i as f32 / 2000.0, false);
        assert!(light.cmple(before + 1e-6).all(), "{i}");
        before = light;
    }
}

#[test]
fn a_curve_may_brighten() {
    let hits = [(0.2, Vec3::splat(4.0)), (0.5, Vec3::new(0.5, 2.0, 1.0)), (0.7, Vec3::splat(0.1))];
    let mut curve = Streaming::new(4, true);
    for (depth, light) in hits {
        curve.insert(depth, depth, light);
    }
    let packed: Vec<_> = curve.pack().collect();
    for z in [0.1, 0.3, 0.6, 0.9] {
        let (is, should) = (light_at(&packed, z, true), exact(&hits, z));
        // 20 octaves in 4,095 steps.
        assert!(((is - should) / should).abs().max_element() < 0.003, "{z}: {is} {should}");
    }
}

pub(crate) fn curved(scene: Scene, nodes: u32) -> Scene {
    let shadow = ShadowSettings { receiver: Receiver::Curve, nodes, ..scene.shadow };
    Scene { shadow, ..scene }
}

/// Discs of all sizes, a plain sort, seen by a directional light and a spot.
pub(crate) fn discs(nodes: u32) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    let position = Vec3::new(3.0, 4.0, 2.5);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }),
    ];
    scene.particles = random_discs(3000, 5);
    for particle in &mut scene.particles {
        particle.color.w *= 0.3;
    }
    curved(scene, nodes)
}

/// Share of the texels whose curves differ by more than rounding at some depth.
pub(crate) fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    let (mut apart, mut count) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.curve.as_ref().unwrap(), b.curve.as_ref().unwrap());
        for texel in 0..a.packed.len() / a.nodes {
            let far = (0..50).any(|i| {
                let z = (i as f32 + 0.5) / 50.0;
                (a.light_at(texel, z) - b.light_at(texel, z)).abs().max_element() > 0.004
            });
            apart += usize::from(far);
            count += 1;
        }
    }
    apart as f64 / f64::from(count)
}

/// Share of the texels that a ray which grazes an edge, or a merge that costs the same as another,
/// may set apart.
const GRAZED: f64 = 2e-3;

/// Casters of every kind, opaque ones too.
pub(crate) fn mixture() -> Scene {
    let like = |transfer, shape, profile| Material { shape, profile, ..material(transfer) };
    let mut scene = discs(8);
    scene.materials = vec![
        like(Transfer::Filter, Shape::Disc, Profile::Soft),
        like(Transfer::Smoke, Shape::Quad, Profile::Flat),
        like(Transfer::Filter, Shape::Puff, Profile::Soft),
        Material { tint: Vec4::new(0.3, 0.9, 0.5, 0.6), ..material(Transfer::Stain) },
        like(Transfer::Opaque, Shape::Disc, Profile::Flat),
    ];
    scene.particles.truncate(600);
    let mut chance = Chance::new(8);
    for particle in &mut scene.particles {
        particle.material = [0, 0, 1, 2, 4][chance.below(5)];
    }
    for id in 0..8 {
        let corners = [0; 3].map(|_| chance.vec3(-2.0, 2.0));
        scene.triangles.push(Triangle { id, ..triangle(corners, 3) });
    }
    scene
}

pub(crate) fn twin(scene: &Scene) -> Vec<ViewMaps> {
    reference::render_maps(scene, &shadow_views(scene)).0
}

pub(crate) fn holds(tier: Tier, scene: &Scene, name: &str) {
    let expected = twin(scene);
    let frame = render(tier, scene);
    let apart = share_apart(&frame.maps, &expected);
    assert!(apart <= GRAZED, "{name} {tier:?}: {apart}");
    for (map, expected) in frame.maps.iter().zip(&expected) {
        let pairs = map.filter.iter().zip(&expected.filter);
        let far = pairs.filter(|(a, b)| (0..3).any(|i| (a[i] - b[i]).abs() > 0.004)).count();
        assert!(far as f64 <= GRAZED * map.filter.len() as f64, "{name} {tier:?}: F {far}");
        assert_eq!(map.nearest.len(), expected.nearest.len());
    }
}

#[test]
fn gpu_matches_twin() {
    holds(Tier::Native, &discs(8), "8 nodes");
    holds(Tier::Native, &discs(16), "16 nodes");
    holds(Tier::Core, &discs(4), "4 nodes");
    // The comparison can fail, and there is something to compare.
    let (four, eight) = (twin(&discs(4)), twin(&discs(8)));
    assert!(share_apart(&four, &eight) > 0.05);
}

#[test]
fn gpu_matches_twin_of_every_kind() {
    holds(Tier::Core, &mixture(), "mixture");
    let mut gain = mixture();
    gain.materials[1].transfer = Transfer::Gain;
    holds(Tier::Native, &gain, "gain");
}

#[test]
fn what_has_no_room_falls_behind() {
    let mut scene = discs(8);
    scene.shadow.pair_budget = 3000;
    let frame = render(Tier::Native, &scene);
    assert!(frame.counters.overflowed > 0, "{:?}", frame.counters);
    let whole = render(Tier::Native, &discs(8));
    for (few, whole) in frame.maps.iter().zip(&whole.maps) {
        for texel in 0..few.filter.len() {
            let apart = (0..3).map(|i| (few.filter[texel][i] - whole.filter[texel][i]).abs());
            assert!(apart.fold(0.0, f32::max) < 0.003, "light is lost at {texel}");
        }
    }
    holds(Tier::Core, &scene, "overflow");
}

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
    // White: seen, and no filter.
    materials.push(Material { profile: Profile::Flat, ..material(Transfer::Filter) });
    let mut scene = empty(materials);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.lights[0].intensity = 4.0;
    scene.shadow.bias = 0.002;
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

/// The panes above `y`, and whether a pane is clear of the bias.
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
    for tier in TIERS {
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
            // The picture: what was seen without panes, times what they let pass.
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

/// The grey that shows as `level`.
fn linear(level: u8) -> f32 {
    (0..4000).map(|i| i as f32 / 4000.0).find(|&v| to_screen(Vec3::splat(v))[0] >= level).unwrap()
}

/// Large triangles that cross: sorted by their nearest corner, they meet each texel in another
/// order.
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
    for tier in TIERS {
        let frame = render(tier, &scene);
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

/// Thirteen segments' curves after each other.
#[test]
#[ignore = "many casters: make test-all"]
fn a_hundred_thousand_casters_on_one_tile() {
    const COUNT: u32 = 100_000;
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.shadow.size = 16;
    let mut chance = Chance::new(2);
    // So large that their profile is 1 wherever the map is.
    let disc = |id| {
        let center = Vec3::new(0.0, 1.0 - 2.0 * (id as f32 + chance.unit()) / COUNT as f32, 0.0);
        let color = Vec4::new(0.9, 0.5, 0.0, 2e-5);
        Particle { id, ..particle(center, 50.0, color) }
    };
    scene.particles = (0..COUNT).map(disc).collect();
    let opacity = half::f16::from_f32(2e-5).to_f32();
    let scene = curved(scene, 8);
    for tier in TIERS {
        let frame = render(tier, &scene);
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
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/resolved.toml");
    let both = scene::load_with(&path, &set).unwrap_or_else(|error| panic!("{error}"));
    let red = both.materials.iter().position(|m| m.tint.x > m.tint.z && m.tint.w < 0.5).unwrap();
    let mut alone = both.clone();
    alone.particles.retain(|particle| particle.material == red as u32);
    assert!(alone.particles.len() < both.particles.len());
    let (with, without) =
        (render(Tier::Native, &both).picture, render(Tier::Native, &alone).picture);
    let (mut sums, mut count) = ([[0.0; 3]; 2], 0.0);
    for (a, b) in with.rgb.iter().zip(&without.rgb) {
        // Where the red smoke is.
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

/// The page says what is measured.
#[test]
fn the_page_is_in_step() {
    let page = include_str!("../../docs/curves.md");
    let samples = Rays::ALL.map(Sample::new);
    for method in Method::ALL {
        let start = format!("| {} | {} |", method.name(), method.bytes());
        let line = page.lines().find(|line| line.starts_with(&start));
        let line = line.unwrap_or_else(|| panic!("no line {start}: run make quality"));
        let cells: Vec<f32> = line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        for (i, sample) in samples.iter().enumerate() {
            let (error, stated) = (sample.error(method), &cells[1 + 3 * i..]);
            // Elementary functions differ in their last bits between platforms.
            assert!((error.mean - stated[0]).abs() <= 2e-5 + 0.01 * stated[0], "{line}");
            assert!((error.max - stated[1]).abs() <= 0.011, "{line}");
        }
    }
}
