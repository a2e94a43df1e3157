//! Blurred maps: kernels and reference against a Gaussian in 64 bits.
use crate::common::{
    TIERS, gpu, map_frame, renderer,
    scenes::{empty, flat_view, light, material, pane, particle, random_discs},
    shadows,
    windows::{gaussian, least},
};
use gobo::{
    ShadowSettings,
    glam::{DVec3, UVec2, Vec3, Vec4},
    gpu::Gpu,
    model::{LightKind, Material, Profile, Receiver, Transfer},
    records::ViewMaps,
    shadows::Maps,
    view::shadow_views,
    wgpu,
};
use gobo_picture::RenderOptions;
use gobo_reference::render_maps;
use gobo_scene::Scene;
use half::f16;

const SIZE: usize = 48;
const WALL: u32 = 2;

/// Two gels, one partly over the other, and a wall.
fn gels(nodes: u32) -> Scene {
    let gel = |tint: Vec3| Material { tint: tint.extend(1.0), ..material(Transfer::Filter) };
    let first = gel(Vec3::new(0.8, 0.4, 0.2));
    let wall = material(Transfer::Opaque);
    let mut scene = empty(vec![first, gel(Vec3::new(0.5, 0.9, 0.7)), wall]);
    scene.triangles = pane(0.3, 1.1, 0).to_vec();
    scene.triangles.extend(pane(0.6, 1.7, 1));
    if nodes > 0 {
        scene.shadow.receiver = Receiver::Curve;
        scene.shadow.nodes = nodes;
    }
    scene
}

fn cpu(scene: &Scene, blur: u32) -> ViewMaps {
    let mut scene = scene.clone();
    scene.shadow.blur = blur;
    render_maps(&scene, &[flat_view(SIZE as u32, 10.0)]).0.remove(0)
}

fn off(light: Vec3, truth: DVec3) -> f64 {
    (light.as_dvec3() - truth).abs().max_element()
}

/// Maps before and after a blur: the reference's, and those of each tier.
fn sharp_and_soft(scene: &Scene, blur: u32) -> Vec<[ViewMaps; 2]> {
    let mut scene = scene.clone();
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    scene.lights[0].size = Some(SIZE as u32);
    let mut of = |render: &dyn Fn(&Scene) -> ViewMaps| {
        [0, blur].map(|blur| {
            scene.shadow.blur = blur;
            render(&scene)
        })
    };
    let mut all = vec![of(&|scene| render_maps(scene, &shadow_views(scene)).0.remove(0))];
    all.extend(TIERS.map(|tier| of(&|scene| map_frame(tier, scene).maps.remove(0))));
    all
}

#[test]
fn filters_are_a_gaussian_and_depths_the_nearest_of_the_window() {
    for radius in [1, 3, 8] {
        for [sharp, soft] in sharp_and_soft(&gels(0), radius) {
            assert!(sharp.filter != soft.filter);
            let size = sharp.view.size;
            let radius = radius as i32;
            for at in 0..SIZE * SIZE {
                let truth = gaussian(size, at, radius, |i| Vec3::from(sharp.filter[i]), |_| true);
                let error = off(Vec3::from(soft.filter[at]), truth);
                assert!(error < 6e-4, "{radius}, {at}: {error}");
                let nearest = least(size, at, radius, |i| sharp.nearest[i]);
                assert_eq!(soft.nearest[at], nearest, "{radius}, {at}");
                // The blurred filter is behind the nearest depth: no seam.
                assert!(soft.nearest[at] < 1.0 || soft.filter[at] == [1.0; 3], "{radius}, {at}");
            }
            assert_eq!(sharp.opaque, soft.opaque);
        }
    }
}

#[test]
fn curves_are_a_gaussian_at_every_depth() {
    for (nodes, radius) in [(4, 2), (8, 5)] {
        for [sharp, soft] in sharp_and_soft(&gels(nodes), radius) {
            let size = sharp.view.size;
            let [before, after] = [&sharp, &soft].map(|maps| maps.curve.as_ref().unwrap());
            // Between the gels, and within 1% of the depths of each.
            let [first, last] = [3.0, 6.0].map(|away: f32| {
                let view = &sharp.view;
                let depth = -view.view_from_world.transform_point3(Vec3::NEG_Z * away).z;
                (depth - view.near) / (view.far - view.near)
            });
            let middle = 0.5 * (first + last);
            let depths = [first - 0.01, first + 0.01, middle, last - 0.01, last + 0.01, 1.0];
            for at in 0..SIZE * SIZE {
                for z in depths {
                    let own = |i| before.light_at(i, z);
                    let truth = gaussian(size, at, radius as i32, own, |_| true);
                    // A node is rounded twice.
                    let error = off(after.light_at(at, z), truth);
                    assert!(error < 6e-4, "{radius}, {at} at {z}: {error}");
                }
            }
        }
    }
}

/// A slanted gel over an upright one becomes one ramp around the mean of the window's depths.
#[test]
fn slopes_become_ramps_of_the_same_mean() {
    let mut scene = gels(8);
    for corner in scene.triangles[..2].iter_mut().flat_map(|face| &mut face.positions) {
        corner.z += 0.8 * corner.x;
    }
    for [sharp, soft] in sharp_and_soft(&scene, 4) {
        let [before, after] = [&sharp, &soft].map(|maps| maps.curve.as_ref().unwrap());
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        for at in 0..SIZE * SIZE {
            for i in 0..50 {
                let z = (i as f32 + 0.5) / 50.0;
                let truth = gaussian(sharp.view.size, at, 4, |i| before.light_at(i, z), |_| true);
                let error = off(after.light_at(at, z), truth);
                sum += error;
                worst = worst.max(error);
            }
        }
        let mean = sum / (50 * SIZE * SIZE) as f64;
        assert!(mean < 2e-3 && worst < 0.2, "{mean}, {worst}");
    }
}

/// A wall in front of the gel hides it, so that texels beside the wall stay as dark.
#[test]
fn walls_let_no_light_into_the_shadow_beside_them() {
    for nodes in [0, 4] {
        let mut scene = gels(nodes);
        scene.triangles = pane(0.6, 100.0, 1).to_vec();
        scene.triangles.extend(pane(0.2, 0.8, WALL));
        let soft = cpu(&scene, 6);
        let expected = Vec3::new(0.5, 0.9, 0.7);
        let beside = (0..SIZE * SIZE).filter(|&at| soft.opaque[at] == 1.0);
        for at in beside {
            let light = match &soft.curve {
                Some(curve) => curve.light_at(at, 0.9),
                None => Vec3::from(soft.filter[at]),
            };
            assert!((light - expected).abs().max_element() < 1e-3, "{nodes}, {at}: {light}");
        }
        let hidden = soft.opaque.iter().filter(|&&depth| depth < 1.0).count();
        assert!(hidden > 100, "{hidden}");
    }
}

/// Each caster is too faint for a nearest depth, and in front of a ground.
#[test]
fn what_is_faint_stays() {
    let mut scene = gels(8);
    scene.materials[0] = Material { profile: Profile::Flat, ..material(Transfer::Filter) };
    scene.triangles = pane(0.9, 100.0, WALL).to_vec();
    for i in 0..200 {
        let center = Vec3::new(0.0, 0.0, -2.0 - 0.01 * i as f32);
        scene.particles.push(particle(center, 1.2, Vec4::new(0.0, 0.0, 0.0, 0.003)));
    }
    let (sharp, soft) = (cpu(&scene, 0), cpu(&scene, 3));
    let [before, after] = [&sharp, &soft].map(|maps| maps.curve.as_ref().unwrap());
    let middle = SIZE / 2 * SIZE + SIZE / 2;
    assert_eq!(sharp.nearest[middle], 1.0);
    let light = before.light_at(middle, 0.8);
    assert!(light.x < 0.6, "{light}");
    assert!((after.light_at(middle, 0.8) - light).abs().max_element() < 2e-3);
}

/// Six maps of a cube, neighbours in the atlas, and one of a sun.
fn crowd(nodes: u32) -> Scene {
    let glass = Material { tint: Vec4::new(0.2, 0.9, 0.4, 0.7), ..material(Transfer::Filter) };
    let mut scene = gels(nodes);
    scene.materials[1] = glass;
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::NEG_Z }),
        light(LightKind::Point { position: Vec3::new(0.2, 0.3, 2.0) }),
    ];
    scene.lights[1].size = Some(40);
    scene.particles = random_discs(40, 5);
    for disc in &mut scene.particles {
        disc.radius = disc.radius.max(0.2);
        disc.material = 1;
    }
    scene.triangles.extend(pane(0.1, 0.4, WALL));
    scene
}

fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    let (mut apart, mut count) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        for i in 0..a.filter.len() {
            let near = |a: f32, b: f32, most: f32| (a - b).abs() < most;
            let same = (0..3).all(|c| near(a.filter[i][c], b.filter[i][c], 2e-3))
                && near(a.nearest[i], b.nearest[i], 2e-6);
            let curves = a.curve.as_ref().zip(b.curve.as_ref());
            let alike = curves.is_none_or(|(a, b)| {
                let at = |k: i32| (k as f32 + 0.5) / 16.0;
                let off = |k| (a.light_at(i, at(k)) - b.light_at(i, at(k))).abs().max_element();
                (0..16).all(|k| off(k) < 4e-3)
            });
            apart += u32::from(!(same && alike));
            count += 1;
        }
    }
    f64::from(apart) / f64::from(count)
}

/// Share of texels whose curve differs where it has more layers than nodes: kernels merge rows, and then
/// columns of them.
const MERGED: f64 = 0.015;

/// The reference blurs one map at a time, so that no neighbour's light can be in it.
#[test]
fn kernels_match_the_reference() {
    for (nodes, blur, most) in [(0, 4, 4e-3), (8, 3, MERGED)] {
        let mut scene = crowd(nodes);
        let sharp = render_maps(&scene, &shadow_views(&scene)).0;
        scene.shadow.blur = blur;
        let expected = render_maps(&scene, &shadow_views(&scene)).0;
        assert!(share_apart(&sharp, &expected) > 0.1);
        for tier in TIERS {
            let apart = share_apart(&map_frame(tier, &scene).maps, &expected);
            assert!(apart < most, "{nodes} nodes, {tier:?}: {apart}");
        }
    }
}

/// Maps that are kept are blurred once.
#[test]
fn maps_that_stay_stay_as_they_are() {
    let mut renderer = renderer(TIERS[0]);
    let mut scene = crowd(0);
    scene.shadow.blur = 3;
    let options =
        RenderOptions { maps: true, maps_only: true, keep: true, ..RenderOptions::default() };
    let mut rendered = |scene: &Scene| renderer.render(scene, &options).unwrap();
    let first = rendered(&scene);
    scene.particles[0].center += Vec3::new(0.0, 0.0, 0.05);
    let second = rendered(&scene);
    assert!(second.counters.views_kept > 0 && second.counters.views_rendered > 0);
    let fresh = map_frame(TIERS[0], &scene);
    assert!(share_apart(&second.maps, &fresh.maps) < 1e-3);
    assert!(share_apart(&second.maps, &first.maps) > 0.0);
}

fn read_level(gpu: &Gpu, maps: &Maps, level: u32) -> (UVec2, Vec<[f16; 4]>) {
    let size = maps.filters.size().mip_level_size(level, wgpu::TextureDimension::D2);
    let layers = maps.filters.depth_or_array_layers();
    let size = wgpu::Extent3d { depth_or_array_layers: layers, ..size };
    let copy = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("copy"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: maps.filters.format(),
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let from = wgpu::TexelCopyTextureInfo { mip_level: level, ..maps.filters.as_image_copy() };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_texture(from, copy.as_image_copy(), size);
    gpu.queue.submit([encoder.finish()]);
    let texels: Vec<u16> = gpu.read_texture(&copy);
    let texels = texels.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]].map(f16::from_bits));
    (UVec2::new(size.width, size.height), texels.collect())
}

/// Each texel of a mip level is the mean of texels in its own view, whatever is next to the view.
#[test]
fn smaller_levels_are_means_of_one_view() {
    let mut scene = crowd(0);
    // Neither a power of two nor a multiple of tiles.
    scene.lights[1].size = Some(37);
    let views = shadow_views(&scene);
    for tier in TIERS {
        let gpu = gpu(tier);
        let settings = ShadowSettings { mips: 4, ..scene.shadow };
        let prepared = shadows(&gpu).prepare(&scene.casters(), &views, &settings).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).unwrap();
        gpu.queue.submit([encoder.finish()]);
        let maps = prepared.maps();
        let (whole, texels) = read_level(&gpu, maps, 0);
        let mut colored = 0;
        for level in 1..=4 {
            let (size, smaller) = read_level(&gpu, maps, level);
            for (view, place) in views.iter().zip(&maps.slots) {
                let edge = 1 << level;
                let own = (view.size + edge - 1) / edge;
                for at in (0..own.x * own.y).map(|i| UVec2::new(i % own.x, i / own.x)) {
                    let end = ((at + 1) * edge).min(view.size);
                    let below = (at.y * edge..end.y)
                        .flat_map(|y| (at.x * edge..end.x).map(move |x| UVec2::new(x, y)));
                    let (mut sum, mut count) = ([0.0; 3], 0.0);
                    for texel in below {
                        let texel = place.origin + texel;
                        let row = place.layer * whole.y + texel.y;
                        let light = texels[(row * whole.x + texel.x) as usize];
                        (0..3).for_each(|c| sum[c] += light[c].to_f64());
                        count += 1.0;
                    }
                    let there = place.origin / edge + at;
                    let row = place.layer * size.y + there.y;
                    let light = smaller[(row * size.x + there.x) as usize];
                    let light = Vec3::from_array([0, 1, 2].map(|c| light[c].to_f32()));
                    let error = off(light, DVec3::from_array(sum) / count);
                    assert!(error < 2e-3, "{tier:?}, level {level} at {at}: {error}");
                    colored += u32::from(light.x < 0.9);
                }
            }
        }
        assert!(colored > 100, "{colored}");
    }
}
