//! What maps hold without casters is not uploaded.
use crate::common::{
    Tier, counted_gpu,
    scenes::{empty, light, material, triangle},
    shadows, tiers,
};
use gobo::{LightKind, Transfer, glam::Vec3, model::Scene, view::shadow_views};

const EDGE: u32 = 1024;
/// Less than one of the maps takes.
const FEW: isize = 2 << 20;

/// A sun on crumbs of a few texels each, or on nothing.
fn lit(crumbs: bool) -> Scene {
    let mut scene = empty(vec![material(Transfer::Opaque)]);
    let direction = Vec3::new(0.1, -1.0, 0.2);
    scene.lights = vec![light(LightKind::Directional { direction })];
    (scene.lights[0].near, scene.lights[0].far) = (Some(-9.0), Some(9.0));
    scene.shadow.size = EDGE;
    let at = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let crumb = |i: i32| {
        let x = i as f32 * 0.02 - 1.0;
        triangle([at(x, 0.0), at(x + 0.005, 0.0), at(x, 0.005)], 0)
    };
    scene.triangles = (0..if crumbs { 100 } else { 0 }).map(crumb).collect();
    scene
}

#[test]
fn maps_are_cleared_without_a_map_of_bytes() {
    for tier in tiers(Tier::Core) {
        for crumbs in [false, true] {
            let scene = lit(crumbs);
            let (gpu, _alone) = counted_gpu(tier);
            let mut shadows = shadows(&gpu);
            let bytes = || gpu.device.get_internal_counters().hal.buffer_memory.read();
            let views = shadow_views(&scene);
            let prepared = shadows.prepare(&scene.casters(), &views, &scene.shadow).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder).unwrap();
            // What is staged lasts until it is submitted.
            let before = bytes();
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            let staged = before - bytes();
            let maps = prepared.maps();
            let opaques: Vec<f32> = gpu.read_texture(&maps.opaques);
            let nearests: Vec<f32> = gpu.read_texture(&maps.nearests);
            let filters: Vec<[u16; 4]> = gpu.read_texture(&maps.filters);
            assert_eq!(opaques.len(), (EDGE * EDGE) as usize);
            let hidden = opaques.iter().filter(|&&depth| depth < 1.0).count();
            assert!(if crumbs { (50..20_000).contains(&hidden) } else { hidden == 0 }, "{hidden}");
            assert!(opaques.iter().all(|&depth| depth > 0.0 && depth <= 1.0));
            assert!(nearests.iter().all(|&depth| depth == 1.0), "{tier}");
            assert!(filters.iter().all(|texel| texel[..3] == [0x3c00; 3]), "{tier}");
            assert!(staged < FEW, "{tier}, {crumbs}: {staged} bytes");
        }
    }
}
