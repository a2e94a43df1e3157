//! Light clusters: kernels against the CPU reference, and the picture against the one that evaluates all
//! lights.
mod alone;
mod reach;

use crate::common::{
    ByTier, TIERS, gpu,
    scenes::{Chance, empty, light, material, random_discs, triangle},
    shadows,
};
use gobo::{
    Error, Shadows,
    glam::{UVec2, Vec2, Vec3, Vec4},
    gpu::{Gpu, Tier, Timeline},
    model::{Cascades, Light, LightKind, Material, Shape, Transfer, Triangle, View},
    records::{Picture, Reach},
    view::shadow_views,
};
use gobo_picture::picture::{PictureCapacity, PictureRequest, PreparedPicture};
use gobo_reference::cluster::{Clusters, assign};
use gobo_reference::records::{ClusterCounters, ClusterGrid};
use gobo_scene::Scene;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Results of a picture on the GPU.
struct Shot {
    lists: Vec<Option<Vec<u32>>>,
    counters: ClusterCounters,
    surfaces: Vec<[u32; 4]>,
    lit: Vec<[u32; 4]>,
    picture: Picture,
}

/// Prepares and records maps and picture on the tier's device, and reads results.
fn on_device<T>(
    tier: Tier,
    scene: &Scene,
    count_cost: bool,
    read: impl FnOnce(&Gpu, &PreparedPicture) -> Result<T, Error>,
) -> Result<T, Error> {
    static SHADOWS: ByTier<OnceLock<(Gpu, Mutex<Shadows>)>> =
        [const { OnceLock::new() }; Tier::ALL.len()];
    let (gpu, shadows) = SHADOWS[tier as usize].get_or_init(|| {
        let gpu = gpu(tier);
        let shadows = shadows(&gpu);
        (gpu, Mutex::new(shadows))
    });
    let mut shadows = shadows.lock().unwrap_or_else(PoisonError::into_inner);
    shadows.forget();
    let prepared = shadows.prepare(&scene.casters(), &shadow_views(scene), &scene.shadow)?;
    shadows.configure(|config| config.toggles.count_cost = count_cost);
    let camera = &View::from_camera(&scene.camera, &scene.bounds());
    let capacity = PictureCapacity::default();
    let request = PictureRequest { scene, camera, prepared: &prepared, capacity };
    let picture = PreparedPicture::new(&shadows, &request, &mut Default::default())?;
    let mut timeline = Timeline::untimed();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder)?;
    picture.record(&mut encoder, &mut timeline);
    gpu.queue.submit([encoder.finish()]);
    read(gpu, &picture)
}

fn costs(tier: Tier, scene: &Scene) -> Vec<[u16; 2]> {
    let read = |gpu: &Gpu, picture: &PreparedPicture| picture.read_costs(gpu);
    on_device(tier, scene, true, read).unwrap_or_else(|error| panic!("{error}"))
}

fn try_shoot(tier: Tier, scene: &Scene) -> Result<Shot, Error> {
    on_device(tier, scene, false, |gpu, picture| {
        let surfaces = picture.read_radiance(gpu)?;
        Ok(Shot {
            lists: picture.read_clusters(gpu)?,
            counters: picture.read_cluster_counters(gpu)?,
            surfaces: surfaces.iter().map(|texel| texel.map(f32::to_bits)).collect(),
            lit: picture.read_lit(gpu)?.iter().map(|texel| texel.map(f32::to_bits)).collect(),
            picture: picture.read(gpu)?,
        })
    })
}

fn shoot(tier: Tier, scene: &Scene) -> Shot {
    try_shoot(tier, scene).unwrap_or_else(|error| panic!("{error}"))
}

fn camera(scene: &Scene) -> View {
    View::from_camera(&scene.camera, &scene.bounds())
}

fn grid(scene: &Scene) -> ClusterGrid {
    ClusterGrid::new(&scene.clusters, &camera(scene), scene.lights.len())
}

fn reaches(scene: &Scene) -> Vec<Reach> {
    let camera = camera(scene);
    scene.lights.iter().map(|light| Reach::new(light, &camera)).collect()
}

fn cpu(scene: &Scene) -> Clusters {
    let grid = grid(scene);
    assign(&grid, &reaches(scene), grid.capacity(&scene.clusters, scene.lights.len()))
}

/// Lights of all kinds, with and without an end, around the origin; none has a shadow.
fn lights(count: usize, chance: &mut Chance) -> Vec<Light> {
    let lights = (0..count).map(|i| {
        let position = chance.vec3(-4.0, 4.0);
        let direction = (chance.vec3(-1.0, 1.0) + Vec3::splat(1e-3)).normalize();
        let kind = match i % 8 {
            3 => LightKind::Directional { direction },
            0 | 4 | 6 => {
                let angle = chance.within(1e-3, 3.13);
                LightKind::Spot { position, direction, angle }
            }
            _ => LightKind::Point { position },
        };
        let far = (i % 8 != 6).then(|| chance.within(0.3, 3.0));
        let color = chance.vec3(0.0, 1.0);
        Light { far, color, intensity: 0.5, casts: false, ..light(kind) }
    });
    lights.collect()
}

fn square(middle: Vec3, x: Vec3, y: Vec3, material: u32) -> [Triangle; 2] {
    let corner = |u: f32, v: f32| middle + x * u + y * v;
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    let normals = [x.cross(y).normalize(); 3];
    [[a, b, c], [a, c, d]].map(|corners| Triangle { normals, ..triangle(corners, material) })
}

/// A floor, a pane and particles, some of them outside the picture; a few lights cast shadows.
fn stage(light_count: usize) -> Scene {
    let tinted =
        |transfer, tint: [f32; 4]| Material { tint: Vec4::from_array(tint), ..material(transfer) };
    let mut scene = empty(vec![
        tinted(Transfer::Opaque, [0.7, 0.68, 0.6, 1.0]),
        tinted(Transfer::Stain, [0.2, 0.9, 0.4, 0.6]),
        tinted(Transfer::Smoke, [0.6, 0.6, 0.9, 0.3]),
        Material { shape: Shape::Puff, ..tinted(Transfer::Filter, [0.9, 0.8, 0.3, 0.5]) },
        tinted(Transfer::Opaque, [0.2, 0.3, 0.9, 1.0]),
    ]);
    scene.camera.size = UVec2::new(110, 75); // no whole number of tiles
    scene.ambient = Vec3::splat(0.02);
    let mut chance = Chance::new(5);
    scene.lights = lights(light_count, &mut chance);
    for light in scene.lights.iter_mut().step_by(9) {
        (light.casts, light.size) = (true, Some(32));
    }
    scene.triangles.extend(square(Vec3::NEG_Y, Vec3::X * 4.0, Vec3::NEG_Z * 4.0, 0));
    scene.triangles.extend(square(Vec3::new(1.2, 0.0, 0.5), Vec3::Z * 1.5, Vec3::Y, 1));
    for (i, mut disc) in random_discs(300, 11).into_iter().enumerate() {
        disc.material = [2, 3, 4][i % 3];
        disc.radius = 0.05 + 0.3 * chance.unit();
        disc.center *= 2.0;
        scene.particles.push(disc);
    }
    scene
}

#[test]
fn kernels_match_the_reference() {
    let mut scene = stage(75);
    for (tile, slices, near) in [(32, 24, None), (16, 64, Some(3.0)), (256, 1, None)] {
        scene.clusters.tile = tile;
        (scene.clusters.slices, scene.clusters.near) = (slices, near);
        let expected = cpu(&scene);
        assert_eq!(expected.counters.overflowed, 0);
        for tier in TIERS {
            let shot = shoot(tier, &scene);
            assert_eq!(shot.lists, expected.lists, "{tier:?}, {tile}");
            assert_eq!(shot.counters, expected.counters, "{tier:?}, {tile}");
        }
    }
}

fn assert_same(shot: &Shot, all: &Shot, what: &str) {
    assert!(shot.surfaces == all.surfaces, "{what}: surfaces differ");
    assert!(shot.lit == all.lit, "{what}: light of particles differs");
    assert!(shot.picture.rgb == all.picture.rgb, "{what}: pictures differ");
}

#[test]
fn a_picture_is_that_of_all_lights() {
    let mut scene = stage(50);
    for tier in TIERS {
        scene.clusters.budget = 1 << 22;
        let shot = shoot(tier, &scene);
        assert!(shot.lists.iter().all(Option::is_some));
        scene.clusters.budget = 0;
        let all = shoot(tier, &scene);
        assert!(all.lists.iter().all(Option::is_none));
        assert_same(&shot, &all, &format!("{tier:?}"));
        assert!(shot.lit.iter().any(|texel| texel[0] > 0x3000), "no particle is lit");
    }
}

/// Overflow costs time, not light.
#[test]
fn clusters_that_do_not_fit_ask_all_lights() {
    let mut scene = stage(40);
    let needed = cpu(&scene).counters.needed;
    for tier in TIERS {
        scene.clusters.budget = 1 << 22;
        let shot = shoot(tier, &scene);
        for budget in [needed, needed - 1, needed / 3] {
            scene.clusters.budget = budget;
            let less = shoot(tier, &scene);
            let expected = cpu(&scene);
            assert_eq!(less.lists, expected.lists);
            assert_eq!(less.counters, expected.counters);
            assert_eq!(less.counters.needed, needed);
            assert_eq!(less.counters.overflowed > 0, budget < needed);
            let kept: usize = less.lists.iter().flatten().map(Vec::len).sum();
            assert!(kept <= budget as usize);
            assert_same(&shot, &less, &format!("{tier:?}, {budget}"));
        }
    }
}

/// Costs of a picture without panes: each pixel outside the sky evaluates the list of its cluster, or all
/// lights.
#[test]
fn costs_are_what_pixels_ask() {
    let mut scene = stage(30);
    scene.triangles.truncate(2);
    let grid = grid(&scene);
    let width = scene.camera.size.x as usize;
    for (tier, budget) in [(Tier::Core, 1 << 22), (Tier::Native, 1 << 22), (Tier::Native, 0)] {
        scene.clusters.budget = budget;
        let shot = shoot(tier, &scene);
        let (mut lit, mut walked) = (0, 0);
        for (i, (&[pairs, lights], surface)) in
            costs(tier, &scene).iter().zip(&shot.surfaces).enumerate()
        {
            let pixel = Vec2::new((i % width) as f32, (i / width) as f32) + 0.5;
            let depth = f32::from_bits(surface[3]);
            let list = grid.cluster(pixel, depth).and_then(|c| shot.lists[c as usize].as_ref());
            let expected = if depth < 1.0 { list.map_or(30, Vec::len) } else { 0 };
            assert_eq!(usize::from(lights), expected, "{tier:?} {pixel}");
            assert!(depth == 1.0 || pairs > 0, "{tier:?} {pixel}");
            lit += u32::from(lights > 0);
            walked += u32::from(pairs > 5);
        }
        // The smaller the block that a subgroup culls for, the fewer: 5,392 with whole tiles, 760 with
        // subgroups of 8, 176 of 4.
        assert!(lit > 1000 && walked > 100, "{tier:?}: {lit}, {walked}");
    }
}

/// The light of a spot or a point fades towards its range, and is zero beyond.
#[test]
fn light_ends_without_a_step() {
    let mut scene = empty(vec![Material { tint: Vec4::ONE, ..material(Transfer::Opaque) }]);
    scene.camera.size = UVec2::new(96, 96);
    (scene.camera.eye, scene.camera.up) = (Vec3::new(0.0, 6.0, 0.0), Vec3::Z);
    scene.triangles.extend(square(Vec3::ZERO, Vec3::X * 4.0, Vec3::NEG_Z * 4.0, 0));
    let lamp = light(LightKind::Point { position: Vec3::Y });
    scene.lights = vec![Light { far: Some(2.0), casts: false, ..lamp.clone() }];
    let endless = Scene { lights: vec![Light { casts: false, ..lamp }], ..scene.clone() };
    let camera = camera(&scene);
    for tier in TIERS {
        let (shot, endless) = (shoot(tier, &scene), shoot(tier, &endless));
        let mut inside = 0;
        for (i, (texel, whole)) in shot.surfaces.iter().zip(&endless.surfaces).enumerate() {
            let pixel = Vec2::new((i % 96) as f32, (i / 96) as f32) + 0.5;
            let aside = (pixel - 48.0) / camera.scale * 6.0;
            let distance = (aside.length_squared() + 1.0).sqrt();
            let [red, whole] = [texel[0], whole[0]].map(f32::from_bits);
            let window = (1.0 - (distance / 2.0).powi(4)).max(0.0).powi(2);
            // Rounding of the point, relative to the brightest.
            assert!((red - whole * window).abs() < 1e-4, "{tier:?} {pixel} {red} {whole}");
            assert!(distance < 2.0 || red == 0.0, "{tier:?} {pixel} {red}");
            inside += u32::from(red > 0.0);
        }
        assert!((1000..9000).contains(&inside), "{inside}");
    }
}

/// A sun in four cascades and 256 lights, most of which have six shadow views.
#[test]
fn hundreds_of_lights_cast_shadows() {
    let mut scene = stage(0);
    scene.particles.truncate(30);
    scene.camera.size = UVec2::new(64, 48);
    let mut chance = Chance::new(17);
    scene.lights = lights(256, &mut chance);
    let sun = light(LightKind::Directional { direction: Vec3::new(-0.5, -0.8, -0.3).normalize() });
    scene.lights.push(Light { cascades: Some(Cascades::default()), ..sun });
    for light in &mut scene.lights {
        (light.casts, light.size) = (true, Some(16));
    }
    let views = shadow_views(&scene).len();
    assert!(views > 850, "{views}");
    // The tier with the tighter limits.
    let shot = shoot(Tier::Core, &scene);
    scene.clusters.budget = 0;
    assert_same(&shot, &shoot(Tier::Core, &scene), "many");
}

#[test]
fn too_many_lights_are_refused() {
    let mut scene = stage(1);
    scene.camera.size = UVec2::new(32, 32);
    scene.particles.clear();
    scene.lights = vec![scene.lights[0].clone(); 4097];
    for light in &mut scene.lights {
        light.casts = false;
    }
    let error = try_shoot(Tier::Core, &scene).err().expect("more than fit");
    assert!(matches!(error, Error::Limit { have: 4096, need: 4097, .. }), "{error}");
    scene.lights.truncate(4096);
    assert_eq!(shoot(Tier::Core, &scene).lists.len(), cpu(&scene).lists.len());
}

/// A grid stays within its memory for any settings.
#[test]
fn grids_are_bounded() {
    let mut scene = stage(0);
    for (size, tile, slices, lights) in [
        (UVec2::splat(4096), 16, 64, 4096),
        (UVec2::new(1, 1), 256, 1, 0),
        (UVec2::new(4096, 1), 16, 64, 1),
    ] {
        scene.camera.size = size;
        (scene.clusters.tile, scene.clusters.slices) = (tile, slices);
        let grid = ClusterGrid::new(&scene.clusters, &camera(&scene), lights);
        let params = grid.params(&scene.clusters, lights);
        assert!(params.cluster_count >= 1 && params.cluster_count * params.word_count <= 1 << 21);
        assert!(params.capacity <= scene.clusters.budget);
        let last = grid.cluster(size.as_vec2() - 0.5, 1.0).expect("inside");
        assert_eq!(last + 1, params.cluster_count);
        assert_eq!(grid.cluster(size.as_vec2() * Vec2::new(-0.1, 0.5), 0.5), None);
        assert_eq!(grid.cluster(size.as_vec2() * 0.5, 1.01), None);
        assert!(grid.bounds.iter().all(|[low, high]| low < high));
    }
}
