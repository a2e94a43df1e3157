//! Maps that opaque casters write are not filled before, and few bytes are copied where they change.
use crate::common::{
    Tier, counted_gpu,
    scenes::{empty, light, material, random_discs, triangle},
    shadows, tiers,
};
use gobo::{LightKind, Transfer, glam::Vec3, model::Scene, view::shadow_views};

const EDGE: u32 = 1024;
/// Less than one of the maps takes \[bytes\].
const FEW: isize = 2 << 20;

/// A sun on a few discs, and on crumbs of a few texels each.
fn lit(crumbs: bool) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter), material(Transfer::Opaque)]);
    let direction = Vec3::new(0.1, -1.0, 0.2);
    scene.lights = vec![light(LightKind::Directional { direction })];
    (scene.lights[0].near, scene.lights[0].far) = (Some(-9.0), Some(9.0));
    scene.shadow.size = EDGE;
    scene.particles = random_discs(20, 5);
    let at = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let crumb = |i: i32| {
        let x = i as f32 * 0.02 - 1.0;
        triangle([at(x, 0.0), at(x + 0.005, 0.0), at(x, 0.005)], 1)
    };
    scene.triangles = (0..if crumbs { 100 } else { 0 }).map(crumb).collect();
    scene
}

#[test]
fn depths_of_new_maps_are_uploaded_only_where_nothing_is_opaque() {
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
            // Staged bytes last until they are submitted.
            let before = bytes();
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            let staged = before - bytes();
            let opaques: Vec<f32> = gpu.read_texture(&prepared.maps().opaques);
            assert_eq!(opaques.len(), (EDGE * EDGE) as usize);
            let hidden = opaques.iter().filter(|&&depth| depth < 1.0).count();
            assert!(if crumbs { (20..20_000).contains(&hidden) } else { hidden == 0 }, "{hidden}");
            assert!(opaques.iter().all(|&depth| depth > 0.0 && depth <= 1.0));
            assert_eq!(staged < FEW, crumbs, "{tier}, {crumbs}: {staged} bytes");
        }
    }
}
