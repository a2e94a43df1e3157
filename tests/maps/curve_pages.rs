//! Curves in pages: the bits of curves that have room for every texel, and what happens without room.
use super::parts;
use crate::common::{
    Tier, gpu,
    scenes::{empty, light, material, random_discs, triangle},
    shadows, tiers,
};
use gobo::{
    CurveMemory, Light, Particle, Prepared, Receiver, ShadowSettings, Shadows, Transfer,
    glam::{UVec2, Vec3},
    gpu::Gpu,
    host::PointBuffers,
    model::{LightKind, Scene, Source},
    records::PackedNode,
    view::shadow_views,
    wgpu::{self, BufferUsages},
};

/// Rounding of a curve's light to 12 bits, and of a filter to half floats, in the nine texels of a look-up.
const ROUNDING: f32 = 1e-3;
/// The same in each of a map's levels, whose blocks are rounded again, and in quotients of their light.
const ROUNDING_OF_LEVELS: f32 = 0.01;
/// Tiles without pages, in `curve_pages.rs`.
const FREE: u32 = 1024;

fn run(gpu: &Gpu, prepared: &Prepared) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
}

fn settings(scene: &Scene, curve_memory: CurveMemory) -> ShadowSettings {
    ShadowSettings { curve_memory, ..scene.shadow }
}

fn prepared(shadows: &mut Shadows, scene: &Scene, memory: CurveMemory) -> Prepared {
    let views = shadow_views(scene);
    shadows.prepare(&scene.casters(), &views, &settings(scene, memory)).unwrap()
}

/// Nodes of a view, texel by texel; unused ones are zeros.
fn nodes(gpu: &Gpu, prepared: &Prepared, view: usize) -> Vec<PackedNode> {
    let (maps, size) = (prepared.maps(), prepared.views()[view].size);
    let places = maps.curve_places(gpu, maps.slots[view], size).unwrap();
    let texture = maps.curves.size();
    let texels: Vec<[PackedNode; 2]> = gpu.read_texture(&maps.curves);
    let used = |node: PackedNode| if node[0] >> 16 == 0 { [0; 2] } else { node };
    let across = size.x.div_ceil(16);
    let mut all = Vec::new();
    for at in (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y))) {
        let place = places[(at.y / 16 * across + at.x / 16) as usize];
        for pair in 0..maps.nodes / 2 {
            let of_page = |place: wgpu::Origin3d| {
                let row = (place.z + pair) * texture.height + place.y + at.y % 16;
                texels[(row * texture.width + place.x + at.x % 16) as usize].map(used)
            };
            all.extend(place.map_or([[0; 2]; 2], of_page));
        }
    }
    all
}

fn assert_same(gpu: &Gpu, [found, expected]: [&Prepared; 2], what: &str) {
    for view in 0..expected.views().len() {
        let same = nodes(gpu, found, view) == nodes(gpu, expected, view);
        assert!(same, "{what}, view {view}");
    }
    let filters = [found, expected].map(|it| gpu.read_texture::<[u16; 4]>(&it.maps().filters));
    assert!(filters[0] == filters[1], "{what}");
}

/// Discs of all looks in maps of more tiles than have room anyway, of sizes that are no multiples of tiles.
fn large(mut scene: Scene) -> Scene {
    let direction = Vec3::new(0.1, -1.0, 0.2).normalize();
    let mut sun = light(LightKind::Directional { direction });
    sun.size = Some(900);
    let (position, direction) = (Vec3::Y * 8.0, Vec3::NEG_Y);
    let mut spot = light(LightKind::Spot { position, direction, angle: 1.3 });
    spot.size = Some(150);
    scene.lights = vec![sun, spot];
    scene.shadow.receiver = Receiver::Curve;
    scene
}

#[test]
fn curves_in_pages_have_the_same_bits() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        for (name, scene) in parts::scenes() {
            if scene.shadow.soften {
                continue;
            }
            let scene = large(scene);
            let [mut whole, mut paged] = [(); 2].map(|()| shadows(&gpu));
            paged.configure(|config| config.toggles.count_first = true);
            let expected = prepared(&mut whole, &scene, CurveMemory::Whole);
            let found = prepared(&mut paged, &scene, CurveMemory::Counted);
            assert!(!expected.maps().has_pages() && found.maps().has_pages(), "{name}");
            run(&gpu, &expected);
            run(&gpu, &found);
            assert_eq!(found.counters().unwrap().short_tiles, 0, "{name}");
            assert_same(&gpu, [&found, &expected], &format!("{tier}, {name}"));
        }
    }
}

/// Light at points of a host, of the first light.
fn lit(gpu: &Gpu, prepared: &Prepared, lights: &[Light], points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let positions = gpu.upload("positions", points, BufferUsages::STORAGE);
    let points = PointBuffers { count: points.len() as u32, positions: &positions, normals: None };
    let light = prepared.light_points(lights, &[0], &points).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    light.record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    let shares: Vec<f32> = gpu.read(light.shares());
    shares[..3 * points.count as usize].as_chunks::<3>().0.to_vec()
}

/// `count` discs that touch nearly every tile of a map with four times as many tiles as pages at first.
fn crowded(count: usize, source: Option<Source>) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    for (i, disc) in random_discs(count, 5).into_iter().enumerate() {
        let center = disc.center + Vec3::Y * (i % 3) as f32 * 0.01;
        let color = disc.color.with_w(disc.color.w * 400.0 / count as f32);
        scene.particles.push(Particle { center, radius: 0.4, color, ..disc });
    }
    let mut sun = light(LightKind::Directional { direction: Vec3::NEG_Y });
    (sun.size, sun.source) = (Some(1024), source);
    scene.lights = vec![sun];
    scene.shadow.receiver = Receiver::Curve;
    scene
}

/// A lattice of points among the discs.
fn among() -> Vec<[f32; 3]> {
    (0..4000).map(|i| [i % 20, i / 20 % 10, i / 200].map(|k| k as f32 / 10.0 - 0.9)).collect()
}

/// Most that light differs.
fn apart<'a>(a: impl IntoIterator<Item = &'a [f32; 3]>, b: &[[f32; 3]]) -> f32 {
    let all = a.into_iter().zip(b).map(|(&a, &b)| (Vec3::from(a) - Vec3::from(b)).abs());
    all.map(Vec3::max_element).fold(0.0, f32::max)
}

#[test]
fn without_room_curves_have_one_node_and_the_next_frame_has_room() {
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let scene = crowded(400, None);
        let [mut whole, mut nearest, mut paged] = [(); 3].map(|()| shadows(&gpu));
        let expected = prepared(&mut whole, &scene, CurveMemory::Whole);
        run(&gpu, &expected);
        let mut first = scene.clone();
        first.shadow.receiver = Receiver::Nearest;
        let at_nearest = prepared(&mut nearest, &first, CurveMemory::Whole);
        run(&gpu, &at_nearest);
        let points = among();
        let [light, one_step] =
            [&expected, &at_nearest].map(|maps| lit(&gpu, maps, &scene.lights, &points));
        assert!(apart(&light, &one_step) > 0.1, "the rules differ");

        let short = prepared(&mut paged, &scene, CurveMemory::Counted);
        run(&gpu, &short);
        let counters = short.counters().unwrap();
        let touched = nodes(&gpu, &expected, 0);
        let in_tile = |tile: u32| {
            let corner = UVec2::new(tile % 64, tile / 64) * 16;
            (0..256).any(|i| {
                let at = corner + UVec2::new(i % 16, i / 16);
                touched[(8 * (at.y * 1024 + at.x)) as usize][0] >> 16 > 0
            })
        };
        let with_nodes = (0..4096).filter(|&tile| in_tile(tile)).count() as u64;
        assert!(counters.page_capacity >= FREE && with_nodes > counters.page_capacity.into());
        // All of them, and tiles whose casters miss every texel.
        assert!(counters.short_tiles >= with_nodes && counters.short_tiles <= 4096);
        let found = lit(&gpu, &short, &scene.lights, &points);
        let rounding = apart(&found, &one_step);
        assert!(rounding <= ROUNDING, "{tier}: {rounding}");

        assert!(paged.grow_from(&counters) && !paged.grow_from(&Default::default()));
        let roomy = prepared(&mut paged, &scene, CurveMemory::Counted);
        run(&gpu, &roomy);
        assert_eq!(roomy.counters().unwrap().short_tiles, 0);
        assert_same(&gpu, [&roomy, &expected], &format!("{tier}"));
        assert!(lit(&gpu, &roomy, &scene.lights, &points) == light, "{tier}");
    }
}

/// A sun with a size, whose light comes from prefiltered levels and from texels close to the receiver: both
/// read one node where there is no page.
#[test]
fn penumbrae_without_room_are_those_of_nearest_depths() {
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        // Half a degree is read from the map; ten also from levels.
        for (angle, most) in [(0.5_f32, ROUNDING), (10.0, ROUNDING_OF_LEVELS)] {
            let scene = crowded(400, Some(Source::Sun { angle: angle.to_radians() }));
            let mut first = scene.clone();
            first.shadow.receiver = Receiver::Nearest;
            let points = among();
            let [whole, nearest, short] = [
                (&scene, CurveMemory::Whole),
                (&first, CurveMemory::Whole),
                (&scene, CurveMemory::Counted),
            ]
            .map(|(scene, memory)| {
                let maps = prepared(&mut shadows(&gpu), scene, memory);
                run(&gpu, &maps);
                let is_short = maps.counters().unwrap().short_tiles > 0;
                assert_eq!(is_short, memory == CurveMemory::Counted);
                lit(&gpu, &maps, &scene.lights, &points)
            });
            assert!(apart(&whole, &nearest) > 0.1, "{angle}: the rules differ");
            let rounding = apart(&short, &nearest);
            assert!(rounding <= most, "{tier}, {angle} degrees: {rounding}");
        }
    }
}

/// Pairs past the budget: a part of the tiles at a time has its pairs, its pages, and is walked.
#[test]
fn parts_of_tiles_have_pages() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        for which in [0, 1] {
            let (name, scene) = parts::scenes().swap_remove(which);
            let mut scene = large(scene);
            let expected = prepared(&mut shadows(&gpu), &scene, CurveMemory::Whole);
            run(&gpu, &expected);
            scene.shadow.pair_budget = expected.counters().unwrap().pairs as u32 / 10;
            let mut paged = shadows(&gpu);
            paged.configure(|config| config.toggles.count_first = true);
            let found = prepared(&mut paged, &scene, CurveMemory::Counted);
            run(&gpu, &found);
            let counters = found.counters().unwrap();
            assert!(found.maps().has_pages() && counters.overflowed > 0, "{name}: {counters:?}");
            assert_eq!((counters.unordered, counters.short_tiles), (0, 0), "{name}");
            assert_same(&gpu, [&found, &expected], &format!("{tier}, {name}"));
        }
    }
}

/// Pages run out in the middle of the parts: tiles of earlier parts keep their nodes, the others have one
/// node, and a second frame from nothing has the same. The next frame has room.
#[test]
fn parts_without_room_have_one_node() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        // A part has room for 2^18 pairs, which are those of less than a thousand tiles.
        let mut scene = crowded(12_000, None);
        let expected = prepared(&mut shadows(&gpu), &scene, CurveMemory::Whole);
        run(&gpu, &expected);
        let mut first = scene.clone();
        first.shadow.receiver = Receiver::Nearest;
        let at_nearest = prepared(&mut shadows(&gpu), &first, CurveMemory::Whole);
        run(&gpu, &at_nearest);
        scene.shadow.pair_budget = expected.counters().unwrap().pairs as u32 / 16;
        let mut paged = shadows(&gpu);
        let [short, again] = [&mut paged, &mut shadows(&gpu)].map(|shadows| {
            let maps = prepared(shadows, &scene, CurveMemory::Counted);
            run(&gpu, &maps);
            maps
        });
        let counters = short.counters().unwrap();
        assert!(counters.overflowed > 0 && counters.unordered == 0, "{counters:?}");
        assert!(counters.pairs_needed > 1 << 19, "few parts: {counters:?}");
        assert_same(&gpu, [&again, &short], &format!("{tier}, again"));
        let (view, maps) = (&short.views()[0], short.maps());
        let places = maps.curve_places(&gpu, maps.slots[0], view.size).unwrap();
        let [some, all] = [&short, &expected].map(|it| nodes(&gpu, it, 0));
        let per_tile = |nodes: &[PackedNode], tile: usize| -> Vec<PackedNode> {
            let corner = (tile / 64 * 16 * 1024 + tile % 64 * 16) * 8;
            (0..16).flat_map(|row| nodes[corner + row * 8192..][..128].to_vec()).collect()
        };
        let (mut with, mut without) = (0, 0);
        for (tile, place) in places.iter().enumerate() {
            let [found, expected] = [&some, &all].map(|nodes| per_tile(nodes, tile));
            let is_empty = expected.iter().all(|node| *node == [0; 2]);
            assert!(place.is_none() || found == expected, "{tier}, tile {tile}");
            with += u64::from(place.is_some());
            without += u64::from(place.is_none() && !is_empty);
        }
        assert!(with > 100 && without > 100, "{with} tiles with pages, {without} without");
        // Tiles whose casters miss every texel are short, too.
        assert!(counters.short_tiles >= without && with + counters.short_tiles <= 4096);

        // Points all of whose texels have pages, and those of which none has.
        let points = among();
        let [of_parts, light, one_step] =
            [&short, &expected, &at_nearest].map(|maps| lit(&gpu, maps, &scene.lights, &points));
        let (mut curved, mut stepped) = (0, 0);
        for (i, &point) in points.iter().enumerate() {
            let at = view.view_from_world.transform_point3(point.into());
            let texel = Vec3::new(at.x, -at.y, 0.0) * view.scale + view.size.x as f32 / 2.0;
            let around = [-3.0, 3.0].map(|by| ((texel + by) / 16.0).as_uvec3());
            let tiles: Vec<_> = (around[0].y..=around[1].y)
                .flat_map(|y| (around[0].x..=around[1].x).map(move |x| (y * 64 + x) as usize))
                .collect();
            let has_page = |tile: &usize| places[*tile].is_some();
            let difference = |to: &[[f32; 3]]| apart([&of_parts[i]], &to[i..]);
            if tiles.iter().all(has_page) {
                curved += 1;
                assert!(difference(&light) == 0.0, "{tier}, {point:?}");
            } else if !tiles.iter().any(has_page) {
                stepped += 1;
                let rounding = difference(&one_step);
                assert!(rounding <= ROUNDING, "{tier}, {point:?}: {rounding}");
            }
        }
        assert!(curved > 100 && stepped > 100, "{curved} and {stepped} points");

        assert!(paged.grow_from(&counters));
        let roomy = prepared(&mut paged, &scene, CurveMemory::Counted);
        run(&gpu, &roomy);
        let counters = roomy.counters().unwrap();
        assert!(counters.overflowed > 0 && counters.short_tiles == 0, "{counters:?}");
        assert_same(&gpu, [&roomy, &expected], &format!("{tier}, with room"));
    }
}

fn curve_bytes(prepared: &Prepared) -> u64 {
    let curves = prepared.memory().0.iter().filter(|(name, _)| *name == "curves");
    curves.map(|(_, bytes)| bytes).sum()
}

/// A cloud that moves through the map of a sun, beside a spot whose map is kept.
#[test]
fn pages_are_put_back() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        let mut scene = large(empty(vec![material(Transfer::Filter)]));
        // The box of the scene stays, and no group of casters has both what moves and what does not.
        let under = Vec3::new(3.5, -3.0, -3.5);
        scene.triangles = [Vec3::splat(-4.0), Vec3::splat(4.0), under]
            .map(|at| triangle([Vec3::X, Vec3::Z, -Vec3::ONE].map(|off| at + 0.2 * off), 0))
            .to_vec();
        let (position, direction) = (under + 5.0 * Vec3::Y, Vec3::NEG_Y);
        scene.lights[1].kind = LightKind::Spot { position, direction, angle: 0.2 };
        let cloud = random_discs(60, 3);
        let views = shadow_views(&scene);
        let mut paged = shadows(&gpu);
        let paged_settings = settings(&scene, CurveMemory::Counted);
        let (mut most, mut all, mut capacity) = (0, 0, 0);
        for step in 0..30 {
            let at = |disc: &Particle| {
                let center = disc.center * 0.4 + Vec3::new(step as f32 * 0.2 - 3.0, 0.0, 1.0);
                Particle { center, ..*disc }
            };
            let mut now = scene.clone();
            now.particles.extend(cloud.iter().map(at));
            let found = paged.prepare(&now.casters(), &views, &paged_settings).unwrap();
            run(&gpu, &found);
            let counters = found.counters().unwrap();
            assert_eq!(counters.short_tiles, 0, "{tier}, step {step}");
            assert_eq!(counters.views_kept, u64::from(step > 0), "{tier}, step {step}");
            capacity = counters.page_capacity as usize;
            let places = |view: usize| {
                let maps = found.maps();
                let size = views[view].size;
                maps.curve_places(&gpu, maps.slots[view], size).unwrap().into_iter().flatten()
            };
            let used: Vec<_> = (0..views.len()).flat_map(places).collect();
            let apart: std::collections::HashSet<_> = used.iter().collect();
            assert_eq!(apart.len(), used.len(), "{tier}, step {step}: a page has two tiles");
            (most, all) = (most.max(used.len()), all + used.len());
            if step % 7 == 3 {
                let mut whole = shadows(&gpu);
                let settings = settings(&now, CurveMemory::Whole);
                let expected = whole.prepare(&now.casters(), &views, &settings).unwrap();
                run(&gpu, &expected);
                assert_same(&gpu, [&found, &expected], &format!("{tier}, step {step}"));
                let [few, all] = [&found, &expected].map(curve_bytes);
                // 16 KiB a page, in rows of 32, and a texel in place of whole curves.
                let pages = u64::from(counters.page_capacity + 2) << 14;
                assert!(few == pages + 16 && 3 * few < all, "{few} of {all} bytes");
            }
        }
        assert!(most < capacity && all > 2 * capacity, "{most} and {all} pages show no leak");
    }
}
